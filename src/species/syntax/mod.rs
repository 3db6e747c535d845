//! RON text as a tree in which every node knows its bytes.
//!
//! A subset of RON 0.12: all that this accepts, the `ron` crate accepts too (a test holds them
//! together). Left out: characters, byte strings, ranges, number suffixes, `0x`, raw identifiers,
//! identifiers beyond ASCII, and line breaks inside `"..."` (use `r"..."`), because a forgotten quote
//! is then found on its own line. Comments are not in the tree; an editor finds them between spans.
//!
//! Faults inside one item are reported and read over ([`Kind::Bad`]); a bracket that is never
//! closed, or closed by another, ends the reading.

mod lex;
mod parse;

use std::ops::Range;

use crate::species::fault::{Fault, MOST};

/// Deepest nesting of values that is read.
pub const MAX_DEPTH: usize = 128;

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Bytes of the source, without surrounding space.
    pub span: Range<usize>,
    /// The value.
    pub kind: Kind,
}

/// The values of RON.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A number as written, or `inf` or `NaN` with a sign or none.
    Number(String),
    /// Text, escapes resolved.
    Text(String),
    /// `true` or `false`.
    Bool(bool),
    /// `None`. (`Some(x)` is read as `x`.)
    None,
    /// A name on its own: an enum's unit variant.
    Ident(String),
    /// `()`, `(1, 2)`, `Name(1, 2)`.
    Tuple {
        /// Name before the bracket.
        name: Option<String>,
        /// Values in order.
        items: Vec<Node>,
    },
    /// `(a: 1)`, `Name(a: 1)`.
    Struct {
        /// Name before the bracket.
        name: Option<String>,
        /// Fields in order; keys may repeat.
        fields: Vec<Entry>,
        /// True if some of it could not be read: what is missing may be in there.
        broken: bool,
    },
    /// `[1, 2]`.
    List(Vec<Node>),
    /// `{"a": 1}`.
    Map(Vec<(Node, Node)>),
    /// Could not be read, and was reported.
    Bad,
}

/// A named field of a struct.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Field name.
    pub key: String,
    /// Bytes of the name.
    pub key_span: Range<usize>,
    /// Field value.
    pub value: Node,
}

impl Node {
    /// The bytes that stand for the node in a report: all of a scalar, the name (or the opening
    /// bracket) of what has items.
    #[must_use]
    pub fn head(&self) -> Range<usize> {
        let start = self.span.start;
        match &self.kind {
            Kind::Tuple { name, .. } | Kind::Struct { name, .. } => {
                start..start + name.as_ref().map_or(1, String::len)
            }
            Kind::List(_) | Kind::Map(_) => start..start + 1,
            _ => self.span.clone(),
        }
    }

    /// What kind of thing it is, in words that follow "found".
    #[must_use]
    pub fn describe(&self) -> String {
        match &self.kind {
            Kind::Number(_) => "a number".into(),
            Kind::Text(_) => "text".into(),
            Kind::Bool(value) => format!("`{value}`"),
            Kind::None => "`None`".into(),
            Kind::Ident(name) => format!("the name `{name}`"),
            Kind::Tuple {
                name: Some(name), ..
            }
            | Kind::Struct {
                name: Some(name), ..
            } => {
                format!("`{name}(...)`")
            }
            Kind::Tuple { items, .. } if items.is_empty() => "`()`".into(),
            Kind::Tuple { items, .. } => format!("a tuple of {}", items.len()),
            Kind::Struct { .. } => "named fields".into(),
            Kind::List(_) => "a list".into(),
            Kind::Map(_) => "a map".into(),
            Kind::Bad => "something unreadable".into(),
        }
    }
}

/// Reads RON text. The tree is `None` where the brackets do not match; otherwise the tree is whole
/// but for [`Kind::Bad`] nodes, one fault or more for each.
#[must_use]
pub fn parse(source: &str) -> (Option<Node>, Vec<Fault>) {
    let (tokens, faults) = lex::tokens(source);
    if faults.len() >= MOST {
        return (None, faults);
    }
    parse::Parser::new(source, &tokens, faults).document()
}

#[cfg(test)]
mod tests;
