//! Tokens to the tree, reading on after faults that stay inside one item.

use std::ops::Range;

use super::lex::{Spanned, Token};
use super::{Entry, Kind, MAX_DEPTH, Node};
use crate::species::fault::{Fault, MOST};

/// The rest of the text cannot be told apart; the fault is reported.
struct Stop;

/// An item of a bracket that may hold fields.
enum Item {
    Field(Entry),
    Value(Node),
}

/// An opening bracket.
#[derive(Clone, Copy)]
struct Open {
    bracket: char,
    at: usize,
}

impl Open {
    fn span(self) -> Range<usize> {
        self.at..self.at + 1
    }

    fn closing(self) -> char {
        match self.bracket {
            '(' => ')',
            '[' => ']',
            _ => '}',
        }
    }
}

pub(super) struct Parser<'s> {
    source: &'s str,
    tokens: &'s [Spanned],
    at: usize,
    depth: usize,
    path: String,
    faults: Vec<Fault>,
}

impl<'s> Parser<'s> {
    pub(super) fn new(source: &'s str, tokens: &'s [Spanned], faults: Vec<Fault>) -> Self {
        Self {
            source,
            tokens,
            at: 0,
            depth: 0,
            path: String::new(),
            faults,
        }
    }

    /// The one value of a text.
    pub(super) fn document(mut self) -> (Option<Node>, Vec<Fault>) {
        if self.tokens.is_empty() {
            self.fault(0..0, "the script is empty");
            self.advise("a script is one value in brackets, `( ... )`");
            return (None, self.faults);
        }
        let Ok(root) = self.value() else {
            return (None, self.faults);
        };
        if self.at < self.tokens.len() {
            let message = format!("{} after the end of the script", self.found());
            self.fault(self.span(), message);
            self.advise("a bracket may be closed too early");
            return (None, self.faults);
        }
        (Some(root), self.faults)
    }

    fn peek(&self) -> Option<&'s Token> {
        self.tokens.get(self.at).map(|(token, _)| token)
    }

    fn peek_after(&self) -> Option<&'s Token> {
        self.tokens.get(self.at + 1).map(|(token, _)| token)
    }

    /// Bytes of the current token; the end of the text after the last.
    fn span(&self) -> Range<usize> {
        let end = self.source.len();
        self.tokens
            .get(self.at)
            .map_or(end..end, |(_, span)| span.clone())
    }

    /// End of the token before the current one.
    fn last_end(&self) -> usize {
        let last = self.at.checked_sub(1).and_then(|at| self.tokens.get(at));
        last.map_or(0, |(_, span)| span.end)
    }

    fn slice(&self) -> &'s str {
        self.source.get(self.span()).unwrap_or("")
    }

    /// The current token in words that follow "found".
    fn found(&self) -> String {
        match self.peek() {
            None => "the end of the file".into(),
            Some(Token::Text(_)) => "text".into(),
            Some(_) => format!("`{}`", self.slice()),
        }
    }

    fn fault(&mut self, span: Range<usize>, message: impl Into<String>) {
        if self.faults.len() < MOST {
            let fault = Fault::new(span, &self.path, message);
            self.faults.push(fault);
        }
    }

    fn advise(&mut self, help: &str) {
        if let Some(last) = self.faults.last_mut() {
            last.help = Some(help.into());
        }
    }

    fn value(&mut self) -> Result<Node, Stop> {
        let span = self.span();
        if self.depth >= MAX_DEPTH {
            self.path.clear();
            self.fault(span, format!("values are nested deeper than {MAX_DEPTH}"));
            return Err(Stop);
        }
        self.depth += 1;
        let node = self.value_at_depth(span);
        self.depth -= 1;
        node
    }

    fn value_at_depth(&mut self, span: Range<usize>) -> Result<Node, Stop> {
        let slice = self.slice();
        let kind = match self.peek() {
            Some(Token::Open('(')) => return self.group(None, span.start),
            Some(Token::Open('[')) => return self.list(),
            Some(Token::Open(_)) => return self.map(),
            Some(Token::Ident) => match slice {
                "true" | "false" => Kind::Bool(slice == "true"),
                "None" => Kind::None,
                _ if self.peek_after() == Some(&Token::Open('(')) => {
                    self.at += 1;
                    return self.group(Some(slice), span.start);
                }
                "Some" => {
                    self.fault(span.clone(), "expected a value in brackets after `Some`");
                    self.advise("write `Some(...)`, or the value alone");
                    Kind::Bad
                }
                _ => Kind::Ident(slice.to_owned()),
            },
            Some(Token::Number) => Kind::Number(slice.to_owned()),
            Some(Token::Text(text)) => Kind::Text(text.clone()),
            Some(Token::Bad) => Kind::Bad,
            Some(Token::Comma | Token::Colon | Token::Equals | Token::Close(_)) | None => {
                return self.no_value(span);
            }
        };
        self.at += 1;
        Ok(Node { span, kind })
    }

    /// Something else where a value should be.
    fn no_value(&mut self, span: Range<usize>) -> Result<Node, Stop> {
        self.fault(
            span.clone(),
            format!("expected a value, found {}", self.found()),
        );
        match self.peek() {
            None => return Err(Stop),
            Some(Token::Colon | Token::Equals) => self.at += 1,
            // Left for the bracket around it.
            _ => {}
        }
        let kind = Kind::Bad;
        Ok(Node { span, kind })
    }

    fn open(&mut self) -> Open {
        let open = Open {
            bracket: self.slice().chars().next().unwrap_or('('),
            at: self.span().start,
        };
        self.at += 1;
        open
    }

    /// True once the bracket is closed, and steps over the closing one.
    fn closed(&mut self, open: Open) -> Result<bool, Stop> {
        match self.peek() {
            Some(&Token::Close(bracket)) if bracket == open.closing() => {
                self.at += 1;
                Ok(true)
            }
            Some(&Token::Close(bracket)) => {
                let message = format!("expected `{}`, found `{bracket}`", open.closing());
                self.stop(self.span(), message, open)
            }
            None => {
                let message = format!("this `{}` is never closed", open.bracket);
                self.fault(open.span(), message);
                Err(Stop)
            }
            Some(_) => Ok(false),
        }
    }

    fn stop<T>(&mut self, span: Range<usize>, message: String, open: Open) -> Result<T, Stop> {
        let label = format!("`{}` opened here", open.bracket);
        let fault = Fault::new(span, &self.path, message).also(open.span(), label);
        self.faults.push(fault);
        Err(Stop)
    }

    /// After an item: a comma, or the end of the bracket. Anything else is reported and read as if
    /// the comma were there.
    fn separator(&mut self, open: Open, after_bad: bool) {
        match self.peek() {
            Some(Token::Comma) => self.at += 1,
            Some(Token::Close(_)) | None => {}
            Some(found) => {
                if !after_bad && *found != Token::Bad {
                    let end = self.last_end();
                    let message = format!(
                        "expected `,` or `{}` before {}",
                        open.closing(),
                        self.found()
                    );
                    // The caret belongs where the comma is missing, not on the next line.
                    self.fault(end..end, message);
                }
                if matches!(found, Token::Colon | Token::Equals) {
                    self.at += 1;
                }
            }
        }
    }

    fn list(&mut self) -> Result<Node, Stop> {
        let open = self.open();
        let mut items = Vec::new();
        while !self.closed(open)? {
            if matches!(self.peek(), Some(Token::Ident))
                && matches!(self.peek_after(), Some(Token::Colon | Token::Equals))
            {
                let message = format!("expected `]` before the field `{}`", self.slice());
                let stopped = self.stop(self.span(), message, open);
                self.advise("close the list, or put the fields of each item in `( )`");
                return stopped;
            }
            let outer = self.path.len();
            self.path.push_str(&format!("[{}]", items.len()));
            let item = self.value()?;
            self.separator(open, item.kind == Kind::Bad);
            self.path.truncate(outer);
            items.push(item);
        }
        let span = open.at..self.last_end();
        let kind = Kind::List(items);
        Ok(Node { span, kind })
    }

    fn map(&mut self) -> Result<Node, Stop> {
        let open = self.open();
        let mut entries = Vec::new();
        while !self.closed(open)? {
            let key = self.value()?;
            if self.peek() == Some(&Token::Colon) {
                self.at += 1;
            } else {
                let message = format!("expected `:` and a value, found {}", self.found());
                self.fault(self.span(), message);
            }
            let value = self.value()?;
            self.separator(open, value.kind == Kind::Bad);
            entries.push((key, value));
        }
        let span = open.at..self.last_end();
        let kind = Kind::Map(entries);
        Ok(Node { span, kind })
    }

    /// Fields or values in `( )`, after a name or none.
    fn group(&mut self, name: Option<&str>, start: usize) -> Result<Node, Stop> {
        let open = self.open();
        let (mut fields, mut items) = (Vec::new(), Vec::new());
        let mut broken = false;
        let mut mixed = None;
        while !self.closed(open)? {
            let outer = self.path.len();
            let item = self.item(items.len(), items.is_empty())?;
            let bad = match &item {
                Item::Field(entry) => entry.value.kind == Kind::Bad,
                Item::Value(node) => node.kind == Kind::Bad,
            };
            self.separator(open, bad);
            self.path.truncate(outer);
            let (is_field, span) = match item {
                Item::Field(entry) => {
                    let span = entry.key_span.clone();
                    fields.push(entry);
                    (true, span)
                }
                Item::Value(node) if bad => {
                    broken = true;
                    (fields.is_empty() && items.is_empty(), node.span)
                }
                Item::Value(node) => {
                    let span = node.head();
                    items.push(node);
                    (false, span)
                }
            };
            let clash = !fields.is_empty() && !items.is_empty();
            if clash && mixed.is_none() && !bad {
                mixed = Some((is_field, span));
            }
        }
        if let Some((is_field, span)) = mixed {
            broken = true;
            let message = if is_field {
                "a named field among values without names"
            } else {
                "a value without a name among named fields"
            };
            self.fault(span, message);
            self.advise("fields are written `name: value`");
        }
        let span = start..self.last_end();
        let name = name.map(str::to_owned);
        Ok(self.grouped(span, name, fields, items, broken))
    }

    fn grouped(
        &mut self,
        span: Range<usize>,
        name: Option<String>,
        fields: Vec<Entry>,
        mut items: Vec<Node>,
        broken: bool,
    ) -> Node {
        if name.as_deref() == Some("Some") {
            if fields.is_empty()
                && items.len() == 1
                && let Some(item) = items.pop()
            {
                return item;
            }
            if !broken {
                self.fault(span.clone(), "`Some` takes exactly one value");
                self.advise("`Some` may be left out: write the value alone");
            }
            let kind = Kind::Bad;
            return Node { span, kind };
        }
        let kind = if fields.is_empty() && !broken {
            Kind::Tuple { name, items }
        } else if fields.is_empty() && !items.is_empty() {
            Kind::Bad
        } else {
            Kind::Struct {
                name,
                fields,
                broken,
            }
        };
        Node { span, kind }
    }

    /// `key: value`, or a value. `index` is where a value would stand.
    fn item(&mut self, index: usize, may_be_field: bool) -> Result<Item, Stop> {
        let span = self.span();
        let key = match self.peek() {
            Some(Token::Ident) => self.slice().to_owned(),
            Some(Token::Text(text)) => text.clone(),
            // `inf` and `NaN` are words too.
            Some(Token::Number) if self.slice().starts_with(['i', 'N']) => self.slice().to_owned(),
            _ => return self.plain_item(index),
        };
        let quoted = matches!(self.peek(), Some(Token::Text(_)));
        match self.peek_after() {
            Some(Token::Colon) => {
                self.at += 2;
                self.path_into(&key);
            }
            Some(Token::Equals) => {
                self.at += 1;
                self.path_into(&key);
                self.fault(self.span(), "expected `:`, found `=`");
                self.at += 1;
            }
            Some(Token::Text(_) | Token::Number | Token::Open('['))
                if may_be_field && !quoted && self.peek() == Some(&Token::Ident) =>
            {
                self.at += 1;
                self.path_into(&key);
                let message = format!("expected `:` between `{key}` and its value");
                let end = self.last_end();
                self.fault(end..end, message);
            }
            _ => return self.plain_item(index),
        }
        if quoted {
            self.fault(span.clone(), "a field's name is written without quotes");
        }
        let value = self.value()?;
        Ok(Item::Field(Entry {
            key,
            key_span: span,
            value,
        }))
    }

    fn plain_item(&mut self, index: usize) -> Result<Item, Stop> {
        self.path.push_str(&format!("[{index}]"));
        Ok(Item::Value(self.value()?))
    }

    fn path_into(&mut self, key: &str) {
        if !self.path.is_empty() {
            self.path.push('.');
        }
        self.path.push_str(key);
    }
}
