//! RON text to tokens. Faults are reported here and leave a [`Token::Bad`].

use std::ops::Range;

use crate::species::fault::{Fault, MOST};

/// One token; names and numbers are the source text of their span.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token {
    Open(char),
    Close(char),
    Comma,
    Colon,
    Equals,
    Number,
    Ident,
    Text(String),
    Bad,
}

/// A token and its bytes.
pub(super) type Spanned = (Token, Range<usize>);

/// All tokens of a text.
pub(super) fn tokens(source: &str) -> (Vec<Spanned>, Vec<Fault>) {
    let mut lexer = Lexer {
        source,
        at: 0,
        tokens: Vec::new(),
        faults: Vec::new(),
    };
    lexer.header();
    while lexer.faults.len() < MOST && lexer.next_token() {}
    (lexer.tokens, lexer.faults)
}

struct Lexer<'s> {
    source: &'s str,
    at: usize,
    tokens: Vec<Spanned>,
    faults: Vec<Fault>,
}

/// White space of RON.
fn is_space(c: char) -> bool {
    matches!(
        c,
        ' ' | '\t'..='\r' | '\u{85}' | '\u{200E}' | '\u{200F}' | '\u{2028}' | '\u{2029}'
    )
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

impl<'s> Lexer<'s> {
    fn rest(&self) -> &'s str {
        self.source.get(self.at..).unwrap_or("")
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn eat(&mut self, what: &str) -> bool {
        let found = self.rest().starts_with(what);
        if found {
            self.at += what.len();
        }
        found
    }

    /// Steps over characters; returns how many bytes.
    fn eat_while(&mut self, wanted: impl Fn(char) -> bool) -> usize {
        let rest = self.rest();
        let length = rest.find(|c| !wanted(c)).unwrap_or(rest.len());
        self.at += length;
        length
    }

    fn fault(&mut self, span: Range<usize>, message: impl Into<String>) -> &mut Fault {
        self.faults.push(Fault::new(span, "", message));
        let last = self.faults.len() - 1;
        &mut self.faults[last]
    }

    fn push(&mut self, token: Token, start: usize) {
        self.tokens.push((token, start..self.at));
    }

    /// White space and comments.
    fn skip_space(&mut self) {
        loop {
            self.eat_while(is_space);
            if self.eat("//") {
                self.eat_while(|c| c != '\n');
            } else if self.rest().starts_with("/*") {
                self.block_comment();
            } else {
                return;
            }
        }
    }

    fn block_comment(&mut self) {
        let start = self.at;
        self.at += 2;
        let mut level = 1;
        while level > 0 {
            self.eat_while(|c| !matches!(c, '/' | '*'));
            if self.rest().is_empty() {
                self.fault(start..start + 2, "this comment is never closed")
                    .help = Some("comments nest: each `/*` needs a `*/` of its own".into());
                return;
            }
            if self.eat("/*") {
                level += 1;
            } else if self.eat("*/") {
                level -= 1;
            } else {
                self.at += 1;
            }
        }
    }

    /// `#![enable(implicit_some)]`, which changes nothing here.
    fn header(&mut self) {
        loop {
            self.skip_space();
            let start = self.at;
            if self.peek() != Some('#') {
                return;
            }
            let mut known = true;
            for part in ["#", "!", "[", "enable", "(", "implicit_some", ")", "]"] {
                known = known && self.eat(part);
                self.skip_space();
            }
            if !known {
                self.at = start;
                self.eat_while(|c| c != '\n');
                self.fault(start..self.at, "unknown header line").help =
                    Some("the only header that is read is `#![enable(implicit_some)]`".into());
            }
        }
    }

    fn next_token(&mut self) -> bool {
        self.skip_space();
        let start = self.at;
        let Some(c) = self.peek() else {
            return false;
        };
        let single = match c {
            '(' | '[' | '{' => Some(Token::Open(c)),
            ')' | ']' | '}' => Some(Token::Close(c)),
            ',' => Some(Token::Comma),
            ':' => Some(Token::Colon),
            '=' => Some(Token::Equals),
            _ => None,
        };
        if let Some(token) = single {
            self.at += 1;
            self.push(token, start);
        } else if c == '"' {
            self.text();
        } else if c == 'r' && self.raw_hashes().is_some() {
            self.raw_text();
        } else if c.is_ascii_alphabetic() || c == '_' {
            self.eat_while(is_word);
            let special = matches!(self.source.get(start..self.at), Some("inf" | "NaN"));
            // `inf` and `NaN` may still be field names; the parser knows.
            self.push(if special { Token::Number } else { Token::Ident }, start);
        } else if c.is_ascii_digit() || matches!(c, '+' | '-' | '.') {
            self.number();
        } else {
            self.stray(c);
        }
        true
    }

    fn number(&mut self) {
        let start = self.at;
        if !self.eat("-") {
            self.eat("+");
        }
        if self.eat("inf") || self.eat("NaN") {
            self.end_number(start, true);
            return;
        }
        let whole = self.digits();
        let fraction = self.eat(".") && {
            let digits = self.digits();
            digits || whole
        };
        let mut good = whole || fraction;
        if good && matches!(self.peek(), Some('e' | 'E')) {
            self.at += 1;
            if !self.eat("-") {
                self.eat("+");
            }
            good = self.digits();
        }
        self.end_number(start, good);
    }

    /// Digits with `_` between them; false if there are none.
    fn digits(&mut self) -> bool {
        if !self.peek().is_some_and(|c| c.is_ascii_digit()) {
            return false;
        }
        self.eat_while(|c| c.is_ascii_digit() || c == '_');
        true
    }

    /// A number must not run on into a word or a second point: `5deg`, `1.2.3`, `0x1F`.
    fn end_number(&mut self, start: usize, good: bool) {
        let end = self.at;
        let more = self.eat_while(|c| is_word(c) || matches!(c, '.' | '+' | '-'));
        if good && more == 0 {
            self.push(Token::Number, start);
            return;
        }
        if self.at == start {
            // Cannot happen (the first character is one of the above), but must not loop.
            self.at += 1;
        }
        let text = self.source.get(start..self.at).unwrap_or("");
        let tail = self.source.get(end..self.at).unwrap_or("");
        let message = format!("`{text}` is not a number");
        let help = if good && tail.starts_with(|c: char| c.is_ascii_alphabetic()) {
            "a number is written without its unit: the field's name tells it"
        } else {
            "numbers are written like `2`, `-0.5` or `1e3`"
        };
        self.fault(start..self.at, message).help = Some(help.into());
        self.push(Token::Bad, start);
    }

    /// Number of `#` if a raw text starts here (`r"`, `r#"`).
    fn raw_hashes(&self) -> Option<usize> {
        let after = self.rest().strip_prefix('r')?;
        let hashes = after.len() - after.trim_start_matches('#').len();
        after.get(hashes..)?.starts_with('"').then_some(hashes)
    }

    fn raw_text(&mut self) {
        let start = self.at;
        let hashes = self.raw_hashes().unwrap_or(0);
        self.at += hashes + 2;
        let end = format!("\"{}", "#".repeat(hashes));
        let rest = self.rest();
        if let Some(length) = rest.find(&end) {
            let text = rest.get(..length).unwrap_or("").to_owned();
            self.at += length + end.len();
            self.push(Token::Text(text), start);
        } else {
            let head = start..self.at;
            self.at = self.source.len();
            self.fault(head, format!("this text is never closed by `{end}`"));
            self.push(Token::Bad, start);
        }
    }

    fn text(&mut self) {
        let start = self.at;
        self.at += 1;
        let mut text = String::new();
        let mut good = true;
        loop {
            let from = self.at;
            self.eat_while(|c| !matches!(c, '"' | '\\' | '\n'));
            text.push_str(self.source.get(from..self.at).unwrap_or(""));
            if self.eat("\"") {
                break;
            }
            if self.peek() != Some('\\') {
                let end = self.source.get(..self.at).unwrap_or("").trim_end().len();
                self.fault(
                    start..end.max(start + 1),
                    "this text is not closed on its line",
                )
                .help = Some("end it with `\"`".into());
                self.push(Token::Bad, start);
                return;
            }
            match self.escape() {
                Some(c) => text.push(c),
                None => good = false,
            }
        }
        self.push(if good { Token::Text(text) } else { Token::Bad }, start);
    }

    /// The character of an escape sequence; `None` is reported.
    fn escape(&mut self) -> Option<char> {
        let start = self.at;
        self.at += 1;
        let c = self.peek();
        // A line break stays: the text ends there, which is the fault to report.
        self.at += c.filter(|&c| c != '\n').map_or(0, char::len_utf8);
        let value = match c {
            Some(c @ ('\'' | '"' | '\\')) => Some(c),
            Some('n') => Some('\n'),
            Some('r') => Some('\r'),
            Some('t') => Some('\t'),
            Some('0') => Some('\0'),
            Some('x') => self.hex(2).filter(char::is_ascii),
            Some('u') if self.eat("{") => {
                let value = self.hex(6);
                value.filter(|_| self.eat("}"))
            }
            _ => None,
        };
        if value.is_none() {
            let escape = self.source.get(start..self.at).unwrap_or("");
            let message = format!("unknown escape `{escape}` in text");
            self.fault(start..self.at, message).help =
                Some("a backslash itself is written `\\\\`".into());
        }
        value
    }

    /// Up to `most` hexadecimal digits (two exactly for two).
    fn hex(&mut self, most: usize) -> Option<char> {
        let digits: String = self
            .rest()
            .chars()
            .take(most)
            .take_while(char::is_ascii_hexdigit)
            .collect();
        self.at += digits.len();
        if most == 2 && digits.len() < 2 {
            return None;
        }
        char::from_u32(u32::from_str_radix(&digits, 16).ok()?)
    }

    /// A run of characters that begin no token.
    fn stray(&mut self, c: char) {
        let start = self.at;
        let mut help = None;
        match c {
            '\'' => {
                self.at += 1;
                self.eat_while(|c| !matches!(c, '\'' | '\n' | ',' | ')' | ']'));
                self.eat("'");
                help = Some("text is written in double quotes, `\"...\"`");
            }
            '“' | '”' | '„' | '«' | '»' | '‘' | '’' => {
                self.at += c.len_utf8();
                self.eat_while(|c| !matches!(c, '“' | '”' | '»' | '’' | '\n' | ',' | ')' | ']'));
                if self
                    .peek()
                    .is_some_and(|c| matches!(c, '“' | '”' | '»' | '’'))
                {
                    self.at += self.peek().map_or(0, char::len_utf8);
                }
                help = Some("text is written in straight double quotes, `\"...\"`");
            }
            '\u{FEFF}' => {
                self.at += c.len_utf8();
                help = Some("save the file as UTF-8 without a byte order mark");
            }
            _ => {
                self.eat_while(|other| other == c);
            }
        }
        let message = if c.is_ascii_graphic() || c.is_alphanumeric() || help.is_some() {
            let text = self.source.get(start..self.at).unwrap_or("");
            if c == '\u{FEFF}' {
                "a byte order mark (U+FEFF) does not belong here".to_owned()
            } else {
                format!("`{text}` does not belong here")
            }
        } else {
            format!("the character U+{:04X} does not belong here", u32::from(c))
        };
        self.fault(start..self.at, message).help = help.map(Into::into);
        self.push(Token::Bad, start);
    }
}
