//! Nodes to values, collecting faults and reading on: every getter has something usable to return.

use std::collections::BTreeMap;

use super::fault::{Fault, MOST};
use super::fields::{Absent, Field, Holds, Limits, Table};
use super::syntax::{self, Kind, Node};

/// Collects faults.
#[derive(Debug, Default)]
pub(super) struct Report {
    faults: Vec<Fault>,
}

impl Report {
    pub(super) fn new(faults: Vec<Fault>) -> Self {
        Self { faults }
    }

    /// Adds a fault, unless there are too many already.
    pub(super) fn push(&mut self, fault: Fault) {
        if !self.is_full() {
            self.faults.push(fault);
        }
    }

    /// True if there are too many faults for one more to matter.
    pub(super) fn is_full(&self) -> bool {
        self.faults.len() >= MOST
    }

    /// Faults so far: compare two counts to learn whether what lies between went well.
    pub(super) fn count(&self) -> usize {
        self.faults.len()
    }

    pub(super) fn into_faults(self) -> Vec<Fault> {
        self.faults
    }
}

/// A node and the path that led to it.
#[derive(Clone, Debug)]
pub(super) struct Value<'n> {
    pub(super) node: &'n Node,
    pub(super) path: String,
}

impl<'n> Value<'n> {
    pub(super) fn new(node: &'n Node, path: impl Into<String>) -> Self {
        let path = path.into();
        Self { node, path }
    }

    pub(super) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::new(self.node.head(), &self.path, message)
    }

    /// Reports that something else was expected; says nothing about what was reported before.
    pub(super) fn mismatch(&self, out: &mut Report, expected: &str) {
        if self.node.kind == Kind::Bad {
            return;
        }
        let found = self.node.describe();
        let mut fault = self.fault(format!("expected {expected}, found {found}"));
        match &self.node.kind {
            Kind::Text(text) if expected.contains("number") && text.parse::<f32>().is_ok() => {
                fault = fault.help("write the number without quotes");
            }
            Kind::Ident(name) if expected.contains("text") => {
                fault = fault.help(format!("write it in quotes: \"{name}\""));
            }
            Kind::Map(_) => fault = fault.help("fields are written in `( )`, not in `{ }`"),
            _ => {}
        }
        out.push(fault);
    }

    /// Items of a list.
    pub(super) fn items(&self, out: &mut Report, expected: &str) -> Vec<Self> {
        let Kind::List(items) = &self.node.kind else {
            self.mismatch(out, expected);
            return Vec::new();
        };
        let value = |(i, node)| Self::new(node, format!("{}[{i}]", self.path));
        items.iter().enumerate().map(value).collect()
    }

    /// Items of a tuple without a name, if it has as many as wanted.
    pub(super) fn tuple(&self, count: usize) -> Option<Vec<Self>> {
        match &self.node.kind {
            Kind::Tuple { name: None, items } if items.len() == count => {
                let value = |(i, node)| Self::new(node, format!("{}.{i}", self.path));
                Some(items.iter().enumerate().map(value).collect())
            }
            _ => None,
        }
    }

    /// Name of a variant, with or without fields.
    pub(super) fn variant(&self) -> Option<&'n str> {
        match &self.node.kind {
            Kind::Ident(name)
            | Kind::Tuple {
                name: Some(name), ..
            }
            | Kind::Struct {
                name: Some(name), ..
            } => Some(name),
            _ => None,
        }
    }

    pub(super) fn text(&self, out: &mut Report) -> Option<&'n str> {
        if let Kind::Text(text) = &self.node.kind {
            return Some(text);
        }
        self.mismatch(out, "text in quotes");
        None
    }

    /// A finite number within limits.
    pub(super) fn number(&self, out: &mut Report, limits: Limits) -> Option<f32> {
        let Limits { min, max, unit } = limits;
        let space = if unit.is_empty() { "" } else { " " };
        let range = format!("{min} to {max}{space}{unit}");
        let Kind::Number(text) = &self.node.kind else {
            self.mismatch(out, &format!("a number, {range}"));
            return None;
        };
        // A number too large for a float reads as infinite, and is out of every range.
        let number: f32 = text.replace('_', "").parse().unwrap_or(f32::NAN);
        if (min..=max).contains(&number) {
            // No negative zero: it prints oddly and means the same.
            return Some(number + 0.0);
        }
        let message = if number.is_nan() || text.contains("inf") {
            format!("`{text}` is not a finite number; expected {range}")
        } else {
            format!("{text} is out of range; expected {range}")
        };
        out.push(self.fault(message));
        None
    }

    /// A whole number within `min..=max`.
    pub(super) fn whole(&self, out: &mut Report, min: u64, max: u64) -> Option<u64> {
        let Kind::Number(text) = &self.node.kind else {
            self.mismatch(out, &format!("a whole number, {min} to {max}"));
            return None;
        };
        let digits = text.replace('_', "");
        let number = digits.parse::<u64>().ok();
        if let Some(number) = number.filter(|n| (min..=max).contains(n)) {
            return Some(number);
        }
        let is_whole = digits
            .trim_start_matches(['-', '+'])
            .bytes()
            .all(|b| b.is_ascii_digit());
        let message = if is_whole {
            format!("{text} is out of range; expected a whole number from {min} to {max}")
        } else {
            format!("expected a whole number from {min} to {max}, found {text}")
        };
        out.push(self.fault(message));
        None
    }

    /// Which of some names this is.
    pub(super) fn one_of(&self, out: &mut Report, names: &[&'static str]) -> Option<&'static str> {
        let Some(found) = self.variant() else {
            self.mismatch(out, &format!("one of {}", names.join(", ")));
            return None;
        };
        let known = names.iter().find(|name| **name == found);
        if known.is_none() {
            let message = format!(
                "unknown name `{found}`; expected one of {}",
                names.join(", ")
            );
            out.push(with_nearest(
                self.fault(message),
                found,
                names.iter().copied(),
            ));
        }
        known.copied()
    }
}

/// Adds "did you mean" to a fault, if a name is near enough.
pub(super) fn with_nearest<'a>(
    fault: Fault,
    found: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Fault {
    match nearest(found, names) {
        Some(name) => fault.help(format!("did you mean `{name}`?")),
        None => fault,
    }
}

/// The name that was probably meant: the fewest slips of the pen, at most one in three letters, or
/// one that begins with what was written (`length` for `length_m`).
pub(super) fn nearest<'a>(
    found: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let found = found.to_lowercase();
    // The distance takes time by the product of the lengths.
    if found.is_empty() || found.len() > 100 {
        return None;
    }
    names
        .into_iter()
        .filter_map(|name| {
            let lower = name.to_lowercase();
            let distance = strsim::damerau_levenshtein(&found, &lower);
            let longer = found.chars().count().max(lower.chars().count());
            let prefix = found.len() >= 3 && lower.starts_with(&found);
            (prefix || distance * 3 <= longer.max(3)).then_some((distance, name))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, name)| name)
}

/// The fields of one struct, checked against its table.
#[derive(Debug)]
pub(super) struct Fields<'n> {
    values: BTreeMap<&'static str, Value<'n>>,
    /// Missing fields that are not to be reported: something like them was, or is unreadable.
    excused: Vec<&'static str>,
    all_excused: bool,
    table: &'static Table,
    pub(super) whole: Value<'n>,
}

impl<'n> Fields<'n> {
    /// Reports unknown and repeated fields. What is no struct at all is reported, and read as empty.
    pub(super) fn open(out: &mut Report, value: Value<'n>, table: &'static Table) -> Self {
        let mut fields = Fields {
            values: BTreeMap::new(),
            excused: Vec::new(),
            all_excused: false,
            table,
            whole: value.clone(),
        };
        let expected = format!("the fields of {} in `( )`", table.name);
        match &value.node.kind {
            Kind::Struct {
                fields: entries,
                broken,
                ..
            } => {
                fields.all_excused = *broken;
                fields.take(out, entries);
            }
            // `Name()`, `Name` and `()` are structs with nothing in them.
            Kind::Tuple { items, .. } if items.is_empty() => {}
            Kind::Ident(_) => {}
            _ => {
                fields.all_excused = true;
                value.mismatch(out, &expected);
            }
        }
        fields
    }

    /// As [`Fields::open`], where the struct has no name, or the table's.
    pub(super) fn open_plain(out: &mut Report, value: Value<'n>, table: &'static Table) -> Self {
        let wrong = value.variant().is_some_and(|found| found != table.name);
        if wrong {
            value.mismatch(out, &format!("the fields of {} in `( )`", table.name));
        }
        let mut fields = Self::open(out, value, table);
        fields.all_excused |= wrong;
        fields
    }

    fn take(&mut self, out: &mut Report, entries: &'n [syntax::Entry]) {
        let mut first: BTreeMap<&str, &syntax::Entry> = BTreeMap::new();
        for entry in entries {
            let path = join(&self.whole.path, &entry.key);
            let known = self.table.field(&entry.key);
            if let Some(before) = first.get(entry.key.as_str()) {
                let message = format!("field `{}` is given twice", entry.key);
                let span = before.key_span.clone();
                let fault = Fault::new(entry.key_span.clone(), &path, message);
                out.push(fault.also(span, "first given here"));
            } else if let Some(field) = known {
                self.values
                    .insert(field.name, Value::new(&entry.value, path));
            } else {
                self.unknown(out, entry, &path);
            }
            first.entry(&entry.key).or_insert(entry);
        }
    }

    fn unknown(&mut self, out: &mut Report, entry: &syntax::Entry, path: &str) {
        if out.is_full() {
            // Looking for near names takes time.
            return;
        }
        let names = || self.table.fields().map(|field| field.name);
        let message = format!("unknown field `{}` in {}", entry.key, self.table.name);
        let list = names().collect::<Vec<_>>().join(", ");
        let near = nearest(&entry.key, names());
        let help = match near {
            Some(name) => format!(
                "did you mean `{name}`? Fields of {}: {list}",
                self.table.name
            ),
            None => format!("fields of {}: {list}", self.table.name),
        };
        self.excused.extend(near);
        out.push(Fault::new(entry.key_span.clone(), path, message).help(help));
    }

    /// A field that is there and not `None`.
    pub(super) fn get(&self, name: &str) -> Option<Value<'n>> {
        let value = self.values.get(name)?;
        (value.node.kind != Kind::None).then(|| value.clone())
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.get(name).is_some()
    }

    /// True if a field is there, or was probably meant by something already reported.
    pub(super) fn has_or_excused(&self, name: &str) -> bool {
        self.has(name) || self.all_excused || self.excused.contains(&name)
    }

    /// A field that must be there.
    pub(super) fn require(&self, out: &mut Report, name: &'static str) -> Option<Value<'n>> {
        let value = self.get(name);
        if value.is_none() && !self.has_or_excused(name) {
            let doc = self.field(name).map_or("", |field| field.doc);
            let fault = self
                .whole
                .fault(format!("missing field `{name}` in {}", self.table.name));
            out.push(fault.help(format!("`{name}`: {doc}")));
        }
        value
    }

    /// Exactly one of two fields must be there.
    pub(super) fn either(&self, out: &mut Report, a: &'static str, b: &'static str) {
        match (self.get(a), self.get(b)) {
            (Some(_), Some(second)) => {
                out.push(second.fault(format!("give `{a}` or `{b}`, not both")));
            }
            (None, None) if !self.has_or_excused(a) && !self.has_or_excused(b) => {
                let message = format!("missing field in {}: give `{a}` or `{b}`", self.table.name);
                out.push(self.whole.fault(message));
            }
            _ => {}
        }
    }

    fn field(&self, name: &str) -> Option<&'static Field> {
        self.table.field(name)
    }

    /// Reads a field, or its default through the same reader; `None` if it is at fault or absent.
    pub(super) fn read<T>(
        &self,
        out: &mut Report,
        name: &'static str,
        reader: impl FnOnce(&mut Report, &Value<'_>, Holds) -> Option<T>,
    ) -> Option<T> {
        let Some(field) = self.field(name) else {
            // A slip in this program, shown by any test that reads the struct at all.
            out.push(self.whole.fault(format!("no table entry for `{name}`")));
            return None;
        };
        if let Some(value) = self.get(name) {
            return reader(out, &value, field.holds);
        }
        match field.absent {
            Absent::Fault => {
                self.require(out, name);
                None
            }
            Absent::Means(text) => {
                let node = syntax::parse(text).0?;
                let path = join(&self.whole.path, name);
                reader(out, &Value::new(&node, path), field.holds)
            }
            Absent::Special => None,
        }
    }

    /// A number; the lower limit if at fault.
    pub(super) fn number(&self, out: &mut Report, name: &'static str) -> f32 {
        let mut fallback = 0.0;
        let number = self.read(out, name, |out, value, holds| match holds {
            Holds::Number(limits) => {
                fallback = limits.min;
                value.number(out, limits)
            }
            _ => None,
        });
        number.unwrap_or(fallback)
    }

    /// A whole number; the lower limit if at fault.
    pub(super) fn whole64(&self, out: &mut Report, name: &'static str) -> u64 {
        let mut fallback = 1;
        let number = self.read(out, name, |out, value, holds| match holds {
            Holds::Whole(min, max) => {
                fallback = min;
                value.whole(out, min, max)
            }
            _ => None,
        });
        number.unwrap_or(fallback)
    }

    /// A whole number of a table whose limits fit.
    pub(super) fn whole(&self, out: &mut Report, name: &'static str) -> u32 {
        u32::try_from(self.whole64(out, name)).unwrap_or(u32::MAX)
    }

    /// Text; empty if at fault.
    pub(super) fn text(&self, out: &mut Report, name: &'static str) -> String {
        self.read(out, name, |out, value, _| {
            value.text(out).map(str::to_owned)
        })
        .unwrap_or_default()
    }
}

/// A path one field deeper.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_a_slip_of_the_pen_away() {
        let names = ["length_m", "length_vary", "radius_m", "colour", "links"];
        for (found, expected) in [
            ("lenght_m", Some("length_m")),
            ("length", Some("length_m")),
            ("Colour", Some("colour")),
            ("color", Some("colour")),
            ("link", Some("links")),
            ("bark", None),
            ("", None),
        ] {
            assert_eq!(nearest(found, names), expected, "{found}");
        }
    }
}
