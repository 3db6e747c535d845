//! Fields and items of a script with all that belongs to them: taken out, put in, moved and copied as an author
//! would with a text editor, comments and all.

use super::{EditError, child, missing};
use crate::species::syntax::{self, Kind, Node};
use std::ops::Range;

/// The script without the field or the item at `path`, and without the comments on its own lines.
///
/// # Errors
/// See [`EditError`].
pub fn remove(source: &str, path: &str) -> Result<String, EditError> {
    let root = whole(source)?;
    let (node, index) = part(&root, path)?;
    let mut pieces = Pieces::of(source, node);
    pieces.parts.remove(index);
    Ok(pieces.joined())
}

/// The script with `item` (RON text) as a new item of the list at `path`; it will be item `index`, or the last.
///
/// # Errors
/// See [`EditError`].
pub fn insert(source: &str, path: &str, index: usize, item: &str) -> Result<String, EditError> {
    let (parsed, faults) = syntax::parse(item);
    let Some(parsed) = parsed.filter(|_| faults.is_empty()) else {
        return Err(EditError::BadValue(item.to_owned()));
    };
    let item = &item[parsed.span];
    let root = whole(source)?;
    let node = at(&root, path)?;
    let Kind::List(items) = &node.kind else {
        return Err(missing(node, path, &index.to_string()));
    };
    let mut pieces = Pieces::of(source, node);
    let lead = pieces.lead(items.len());
    let index = index.min(pieces.parts.len());
    pieces
        .parts
        .insert(index, format!("{lead}{},", item.trim()));
    Ok(pieces.joined())
}

/// The script with the item at `path` copied behind itself; `change` makes the copy's text of the item's.
///
/// # Errors
/// See [`EditError`].
pub fn duplicate(
    source: &str,
    path: &str,
    change: impl FnOnce(&str) -> String,
) -> Result<String, EditError> {
    let root = whole(source)?;
    let (node, index) = part(&root, path)?;
    let Kind::List(items) = &node.kind else {
        return Err(missing(node, path, &index.to_string()));
    };
    let mut pieces = Pieces::of(source, node);
    let item = &items[index].span;
    let copy = change(&source[item.clone()]);
    let lead = pieces.lead(items.len());
    pieces
        .parts
        .insert(index + 1, format!("{lead}{},", copy.trim()));
    Ok(pieces.joined())
}

/// The script with the item at `path` moved so that it is item `to` of its list.
///
/// # Errors
/// See [`EditError`].
pub fn reorder(source: &str, path: &str, to: usize) -> Result<String, EditError> {
    let root = whole(source)?;
    let (node, index) = part(&root, path)?;
    if !matches!(node.kind, Kind::List(_)) {
        return Err(missing(node, path, &index.to_string()));
    }
    let mut pieces = Pieces::of(source, node);
    let moved = pieces.parts.remove(index);
    let to = to.min(pieces.parts.len());
    pieces.parts.insert(to, moved);
    Ok(pieces.joined())
}

/// The whole tree of a script without faults.
fn whole(source: &str) -> Result<Node, EditError> {
    let (root, faults) = syntax::parse(source);
    root.filter(|_| faults.is_empty())
        .ok_or(EditError::Unreadable)
}

/// The value at a path; the root's is empty.
fn at<'n>(root: &'n Node, path: &str) -> Result<&'n Node, EditError> {
    let steps = path.split('.').filter(|step| !step.is_empty());
    let mut node = root;
    for step in steps {
        node = child(node, step).ok_or_else(|| missing(node, path, step))?;
    }
    Ok(node)
}

/// What holds the field or item at a path, and its number there.
fn part<'n>(root: &'n Node, path: &str) -> Result<(&'n Node, usize), EditError> {
    let (holder, step) = path.rsplit_once('.').unwrap_or(("", path));
    let node = at(root, holder)?;
    let found = child(node, step).ok_or_else(|| missing(node, path, step))?;
    let index = match &node.kind {
        Kind::Struct { fields, .. } => fields.iter().position(|f| core::ptr::eq(&f.value, found)),
        Kind::List(items) => items.iter().position(|item| core::ptr::eq(item, found)),
        _ => None,
    };
    let index = index.ok_or_else(|| missing(node, path, step))?;
    Ok((node, index))
}

/// A list's or a struct's text in pieces, one a part, each with the comments before it, its comma, and the
/// comment behind it on its line.
struct Pieces<'s> {
    source: &'s str,
    /// All pieces lie here.
    inside: Range<usize>,
    parts: Vec<String>,
    /// What stands behind the last one.
    rest: &'s str,
}

impl<'s> Pieces<'s> {
    fn of(source: &'s str, node: &Node) -> Self {
        let spans: Vec<Range<usize>> = match &node.kind {
            Kind::Struct { fields, .. } => fields
                .iter()
                .map(|f| f.key_span.start..f.value.span.end)
                .collect(),
            Kind::List(items) => items.iter().map(|item| item.span.clone()).collect(),
            _ => Vec::new(),
        };
        let end = node.span.end - 1;
        let open = match &node.kind {
            Kind::Struct {
                name: Some(name), ..
            } => {
                let after = node.span.start + name.len();
                after + source[after..].find('(').map_or(0, |at| at + 1)
            }
            _ => node.span.start + 1,
        };
        let mut start = open;
        let mut parts = Vec::with_capacity(spans.len());
        for span in &spans {
            let (comma, next) = tail(source, span.end, end);
            let mut text = source[start..span.end].to_owned();
            if !comma {
                // So that whatever comes to stand behind it can.
                text.push(',');
            }
            text.push_str(&source[span.end..next]);
            parts.push(text);
            start = next;
        }
        Self {
            source,
            inside: open..end,
            parts,
            rest: &source[start..end],
        }
    }

    /// The space that a new item among `count` begins with: that of the last one, or a line of its own.
    fn lead(&self, count: usize) -> String {
        let Some(last) = count.checked_sub(1).and_then(|i| self.parts.get(i)) else {
            return String::new();
        };
        let space = last.len() - last.trim_start().len();
        let blank = &last[..space];
        match blank.rfind('\n') {
            Some(line) => blank[line..].to_owned(),
            None => " ".to_owned(),
        }
    }

    fn joined(self) -> String {
        let (before, after) = (
            &self.source[..self.inside.start],
            &self.source[self.inside.end..],
        );
        let inside = &self.source[self.inside.clone()];
        if !inside.contains('\n') {
            let parts = on_one_line(inside, &self.parts);
            return format!("{before}{parts}{}{after}", self.rest);
        }
        let mut text = before.to_owned();
        for part in self.parts.iter().map(String::as_str).chain([self.rest]) {
            // A comment to the end of its line must not swallow what comes to stand behind it.
            let last_line = text.rsplit('\n').next().unwrap_or_default();
            let goes_on = !part
                .trim_start_matches([' ', '\t'])
                .starts_with(['\n', '\r']);
            if goes_on && last_line.contains("//") {
                text.push('\n');
            }
            text.push_str(part);
        }
        text + after
    }
}

/// Parts that stand on one line, as one writes them there: a space between two, and a comma behind the last only if
/// there was one.
fn on_one_line(before: &str, parts: &[String]) -> String {
    let lead = &before[..before.len() - before.trim_start().len()];
    let ends_with_comma = before.trim_end().ends_with(',');
    let mut line = lead.to_owned();
    for (index, part) in parts.iter().enumerate() {
        let part = part.trim();
        if index > 0 {
            line.push(' ');
        }
        line.push_str(match part.strip_suffix(',') {
            Some(bare) if index + 1 == parts.len() && !ends_with_comma => bare,
            _ => part,
        });
    }
    line
}

/// Where a part that ends at `from` ends with its comma and with the comment behind it on its line, and whether
/// it has a comma; `end` closes the whole.
fn tail(source: &str, from: usize, end: usize) -> (bool, usize) {
    let mut at = from;
    let mut comma = false;
    // The end of what belongs to the part so far.
    let mut kept = from;
    while at < end {
        let rest = &source[at..end];
        if rest.starts_with("//") {
            // Behind the part on its own line.
            return (comma, at + rest.find('\n').unwrap_or(rest.len()));
        } else if rest.starts_with("/*") {
            at += comment(rest);
            kept = at;
        } else if rest.starts_with(',') && !comma {
            comma = true;
            at += 1;
            kept = at;
        } else if rest.starts_with('\n') && comma {
            return (comma, kept);
        } else if rest.starts_with(char::is_whitespace) {
            at += rest.chars().next().map_or(1, char::len_utf8);
        } else {
            break;
        }
    }
    (comma, kept)
}

/// Bytes of the comment that a text begins with; comments of this kind stand in one another.
fn comment(text: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while let Some(mark) = text.get(at..).and_then(|rest| {
        let next = |mark: &str| rest.find(mark).map(|place| (place, mark == "/*"));
        next("/*").into_iter().chain(next("*/")).min()
    }) {
        at += mark.0 + 2;
        depth = if mark.1 {
            depth + 1
        } else {
            depth.saturating_sub(1)
        };
        if depth == 0 {
            return at;
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::edit::set;

    const SCRIPT: &str = "\
( // a tree
    name: \"A\", seed: 3,
    levels: [
        // The stem.
        Branch(name: \"trunk\", length_m: 2), // tall
        /* all of them */ Branch(name: \"limbs\", length_m: 1),
        // What is green.
        Leaves(name: \"leaves\", links: 3)
    ],
)
";

    #[test]
    fn no_comment_swallows_what_comes_behind_it() {
        let script = "(list: [\n    a, // first\n    b, c])";
        for (from, to) in [(0, 2), (0, 1), (2, 0)] {
            let moved = reorder(script, &format!("list.{from}"), to).unwrap();
            let (root, faults) = syntax::parse(&moved);
            let list = child(&root.unwrap(), "list").cloned().unwrap();
            let Kind::List(items) = list.kind else {
                panic!("{moved}");
            };
            assert_eq!((items.len(), faults.len()), (3, 0), "{moved}");
        }
    }

    #[test]
    fn comments_in_comments_go_with_their_part() {
        let script = "(list: [\n    a, /* one /* two */ three */\n    b,\n])";
        assert_eq!(remove(script, "list.0").unwrap(), "(list: [\n    b,\n])");
    }

    #[test]
    fn a_list_on_one_line_stays_one() {
        let script = "(points: [(0, 0), (0, 1), (1, 2)], names: [ a, b, ])";
        let points = |text: String| text.split("], names").next().map(str::to_owned);
        let is = |text: Result<String, EditError>, points_are: &str| {
            assert_eq!(
                points(text.unwrap()).unwrap(),
                format!("(points: [{points_are}")
            );
        };
        is(
            insert(script, "points", 1, "(5, 5)"),
            "(0, 0), (5, 5), (0, 1), (1, 2)",
        );
        is(
            insert(script, "points", 9, "(5, 5)"),
            "(0, 0), (0, 1), (1, 2), (5, 5)",
        );
        is(
            insert(script, "points", 0, "(5, 5)"),
            "(5, 5), (0, 0), (0, 1), (1, 2)",
        );
        is(remove(script, "points.2"), "(0, 0), (0, 1)");
        is(remove(script, "points.0"), "(0, 1), (1, 2)");
        is(reorder(script, "points.0", 2), "(0, 1), (1, 2), (0, 0)");
        let names = reorder(script, "names.0", 1).unwrap();
        assert!(names.ends_with("names: [ b, a, ])"), "{names}");
        let fields = remove("(a: 1, b: 2, c: 3)", "b").unwrap();
        assert_eq!(fields, "(a: 1, c: 3)");
    }

    #[test]
    fn a_part_goes_with_its_comments_and_comes_back_by_being_put_in() {
        let without = remove(SCRIPT, "levels.limbs").unwrap();
        assert!(
            !without.contains("limbs") && !without.contains("all of them"),
            "{without}"
        );
        assert!(
            without.contains("// tall\n        // What is green."),
            "{without}"
        );
        let back = insert(
            &without,
            "levels",
            1,
            "Branch(name: \"limbs\", length_m: 1)",
        )
        .unwrap();
        assert!(
            back.contains(
                "// tall\n        Branch(name: \"limbs\", length_m: 1),\n        // What"
            ),
            "{back}"
        );
        assert_eq!(
            remove(SCRIPT, "seed").unwrap(),
            SCRIPT.replace(" seed: 3,", "")
        );
    }

    #[test]
    fn items_change_places_with_the_comments_above_and_behind_them() {
        let moved = reorder(SCRIPT, "levels.leaves", 0).unwrap();
        let places = [
            "// What is green.",
            "Leaves(",
            "// The stem.",
            "trunk",
            "// tall",
            "limbs",
        ];
        let found: Vec<_> = places.iter().map(|p| moved.find(p).unwrap()).collect();
        assert!(found.is_sorted(), "{moved}");
        let back = reorder(&moved, "levels.leaves", 9).unwrap();
        assert_eq!(back.replace("links: 3),", "links: 3)"), SCRIPT);
    }

    #[test]
    fn a_copy_stands_behind_what_it_is_a_copy_of() {
        let copied = duplicate(SCRIPT, "levels.trunk", |text| {
            text.replace("trunk", "second")
        })
        .unwrap();
        let places = ["trunk", "// tall", "second", "limbs"];
        let found: Vec<_> = places.iter().map(|p| copied.find(p).unwrap()).collect();
        assert!(found.is_sorted(), "{copied}");
        assert!(set(&copied, "levels.second.length_m", "5").is_ok());
    }

    #[test]
    fn items_come_into_an_empty_list_and_go_from_a_list_of_one() {
        let one = insert("(a: [])", "a", 0, "(x: 1)").unwrap();
        assert_eq!(one, "(a: [(x: 1)])");
        assert_eq!(remove(&one, "a.0").unwrap(), "(a: [])");
        assert_eq!(remove("Name(a: 1, b: 2)", "b").unwrap(), "Name(a: 1)");
    }

    #[test]
    fn what_is_not_there_is_told() {
        let message = |result: Result<String, EditError>| result.unwrap_err().to_string();
        assert!(message(remove(SCRIPT, "levels.roots")).contains("trunk, limbs, leaves"));
        assert!(message(insert(SCRIPT, "levels", 0, "(")).contains("no value"));
        assert!(message(insert(SCRIPT, "name", 0, "1")).contains("plain value"));
        assert!(message(remove("(", "a")).contains("cannot be read"));
    }
}
