//! Editing a script's text at one place, leaving comments, order and everything else as they are.

mod parts;

pub use parts::{duplicate, insert, remove, reorder};

use super::fields::{Absent, SPECIES, TABLES};
use super::schema::{Species, Variation};
use super::syntax::{self, Kind, Node};

/// Why a field could not be set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// The script cannot be read at all.
    #[error("the script cannot be read; run `pleach check` on it")]
    Unreadable,
    /// The new value is no RON.
    #[error("`{0}` is no value that a script could hold")]
    BadValue(String),
    /// The path leads nowhere.
    #[error("`{path}`: there is no `{step}`; known here: {known}")]
    NoSuchField {
        /// Path asked for.
        path: String,
        /// Step that is not there.
        step: String,
        /// What is there.
        known: String,
    },
    /// The path goes on where there is nothing to go into.
    #[error("`{path}`: `{step}` stands in a plain value, which holds no fields")]
    NotAStruct {
        /// Path asked for.
        path: String,
        /// Step that leads into a plain value.
        step: String,
    },
}

/// The script with the field at `path` set to `value` (RON text).
///
/// Steps of a path are separated by `.`; an item of a list is named by its `name` field or by its
/// number from 0: `levels.trunk.length_m`, `levels.0.length_m`. The last field may be absent and is then
/// added, and so may a struct of the whole script that has a default for all of its fields: `lod.selector`.
///
/// # Errors
/// See [`EditError`].
pub fn set(source: &str, path: &str, value: &str) -> Result<String, EditError> {
    let value = value.trim();
    let (parsed, faults) = syntax::parse(value);
    if parsed.is_none() || !faults.is_empty() {
        return Err(EditError::BadValue(value.to_owned()));
    }
    let (root, faults) = syntax::parse(source);
    let Some(root) = root.filter(|_| faults.is_empty()) else {
        return Err(EditError::Unreadable);
    };
    // Without a comment behind it, which would swallow what follows on its line.
    let value = parsed.map_or(value, |node| &value[node.span]);
    let steps: Vec<&str> = path.split('.').collect();
    let mut node = &root;
    for (index, step) in steps.iter().enumerate() {
        match child(node, step) {
            Some(next) => node = next,
            None if index + 1 == steps.len() => return added(source, node, path, step, value),
            None if index == 0 && steps.len() == 2 && is_all_defaults(step) => {
                let whole = format!("({}: {value})", steps[1]);
                return added(source, node, path, step, &whole);
            }
            None => return Err(missing(node, path, step)),
        }
    }
    Ok(spliced(source, node.span.clone(), value))
}

/// The script of one of its named variations, with a slug that tells its packs from others.
///
/// # Errors
/// See [`EditError`].
pub fn vary(source: &str, species: &Species, variation: &Variation) -> Result<String, EditError> {
    let slug = format!("\"{}-{}\"", species.slug, variation.name);
    let mut text = set(source, "slug", &slug)?;
    text = set(&text, "seed", &variation.seed.to_string())?;
    if let Some(age) = variation.age {
        text = set(&text, "age", &age.to_string())?;
    }
    if let Some(habit) = variation.habit {
        text = set(&text, "habit", &format!("{habit:?}"))?;
    }
    if let Some(season) = variation.season {
        text = set(&text, "season", &season.to_string())?;
    }
    Ok(text)
}

fn spliced(source: &str, span: std::ops::Range<usize>, text: &str) -> String {
    format!("{}{text}{}", &source[..span.start], &source[span.end..])
}

/// True for a field of the whole script that may be `()`.
fn is_all_defaults(step: &str) -> bool {
    let field = SPECIES.field(step);
    field.is_some_and(|field| field.absent == Absent::Means("()"))
}

/// The field or item that a step names.
fn child<'n>(node: &'n Node, step: &str) -> Option<&'n Node> {
    match &node.kind {
        Kind::Struct { fields, .. } => fields.iter().find(|f| f.key == step).map(|f| &f.value),
        // A number is a number, also where an item is called so: a path of numbers must lead where it says.
        Kind::List(items) => match step.parse::<usize>() {
            Ok(index) => items.get(index),
            Err(_) => items.iter().find(|item| name_of(item) == Some(step)),
        },
        _ => None,
    }
}

/// The `name` field of a list's item.
fn name_of(item: &Node) -> Option<&str> {
    let Kind::Struct { fields, .. } = &item.kind else {
        return None;
    };
    fields
        .iter()
        .find(|f| f.key == "name")
        .and_then(|f| match &f.value.kind {
            Kind::Text(text) => Some(text.as_str()),
            _ => None,
        })
}

/// A new field after the last one of a struct.
fn added(
    source: &str,
    node: &Node,
    path: &str,
    step: &str,
    value: &str,
) -> Result<String, EditError> {
    let no_fields = Vec::new();
    let fields = match &node.kind {
        Kind::Struct { fields, .. } => fields,
        // `()` and `Name()` are structs with nothing in them.
        Kind::Tuple { items, .. } if items.is_empty() => &no_fields,
        // A bare `Name` that may have fields gets its brackets with the first one.
        Kind::Ident(name)
            if TABLES
                .iter()
                .any(|t| t.name == name && t.field(step).is_some()) =>
        {
            let at = node.span.end;
            return Ok(spliced(source, at..at, &format!("({step}: {value})")));
        }
        _ => return Err(missing(node, path, step)),
    };
    let is_name = step.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    match fields.last() {
        // Straight after the last value, so that a comma or a comment behind it stays behind.
        Some(last) if is_name && !step.is_empty() => {
            let at = last.value.span.end;
            Ok(spliced(source, at..at, &format!(", {step}: {value}")))
        }
        // Straight before the bracket that closes it.
        None if is_name && !step.is_empty() => {
            let at = node.span.end - 1;
            Ok(spliced(source, at..at, &format!("{step}: {value}")))
        }
        _ => Err(missing(node, path, step)),
    }
}

fn missing(node: &Node, path: &str, step: &str) -> EditError {
    let known: Vec<String> = match &node.kind {
        Kind::Struct { fields, .. } => fields.iter().map(|f| f.key.clone()).collect(),
        Kind::List(items) => items
            .iter()
            .enumerate()
            .map(|(i, item)| name_of(item).map_or_else(|| i.to_string(), str::to_owned))
            .collect(),
        _ => {
            return EditError::NotAStruct {
                path: path.to_owned(),
                step: step.to_owned(),
            };
        }
    };
    EditError::NoSuchField {
        path: path.to_owned(),
        step: step.to_owned(),
        known: known.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCRIPT: &str = "( // a tree\n  name: \"A\",\n  levels: [\n    Branch(name: \"trunk\", length_m: 2.0, // tall\n    ),\n    Leaves(name: \"leaves\", links: 3),\n  ],\n)";

    #[test]
    fn a_value_changes_and_all_around_it_stays() {
        let edited = set(SCRIPT, "levels.trunk.length_m", "3.5").unwrap();
        assert_eq!(edited, SCRIPT.replace("2.0", "3.5"));
        assert_eq!(
            set(SCRIPT, "levels.1.links", " 9 ").unwrap(),
            SCRIPT.replace("links: 3", "links: 9")
        );
    }

    #[test]
    fn an_absent_field_is_added_behind_the_last() {
        let edited = set(SCRIPT, "levels.trunk.gnarl", "0.1").unwrap();
        assert_eq!(edited, SCRIPT.replace("2.0,", "2.0, gnarl: 0.1,"));
    }

    #[test]
    fn numbers_lead_to_places_and_comments_swallow_nothing() {
        let script = "(list: [(name: \"1\", a: 1), (name: \"2\", a: 2), (name: \"b\", a: 3)])";
        let set = |path: &str, value: &str| set(script, path, value).unwrap();
        assert_eq!(set("list.1.a", "9"), script.replace("a: 2", "a: 9"));
        assert_eq!(set("list.b.a", "9"), script.replace("a: 3", "a: 9"));
        assert_eq!(set("list.0.a", "9 // nine"), script.replace("a: 1", "a: 9"));
        assert_eq!(
            set("list.0.a", "/* so */ 9"),
            script.replace("a: 1", "a: 9")
        );
    }

    #[test]
    fn a_bare_name_gets_brackets_with_its_first_field() {
        let script = SCRIPT.replace("\n)", "\n  bark: Smooth,\n)");
        let edited = set(&script, "bark.height_m", "2").unwrap();
        assert_eq!(edited, script.replace("Smooth", "Smooth(height_m: 2)"));
        assert!(set(&script, "bark.links", "2").is_err());
    }

    #[test]
    fn fields_of_the_lod_chain_are_set_wherever_they_stand() {
        let set = |lod: &str| {
            let script = SCRIPT.replace("  ],\n)", &format!("  ]{lod},\n)"));
            let edited = set(&script, "lod.selector", "Levels").unwrap();
            edited.split_once("\n  ]").map(|(_, rest)| rest.to_owned())
        };
        let only = Some(", lod: (selector: Levels),\n)".to_owned());
        assert_eq!(set(""), only);
        assert_eq!(set(", lod: ()"), only);
        assert_eq!(set(", lod: (selector: Cut)"), only);
        let beside = ", lod: (calibrate: false, selector: Levels),\n)";
        assert_eq!(set(", lod: (calibrate: false)"), Some(beside.to_owned()));
        let forms = super::set(SCRIPT, "lod.forms", "[(\"trunk\", Planes(8))]").unwrap();
        assert!(
            forms.contains("lod: (forms: [(\"trunk\", Planes(8))])"),
            "{forms}"
        );
    }

    #[test]
    fn wrong_paths_and_values_are_explained() {
        let message = |path, value| set(SCRIPT, path, value).unwrap_err().to_string();
        assert!(message("levels.trunc.length_m", "1").contains("trunk, leaves"));
        assert!(message("name.first", "1").contains("plain value"));
        assert!(message("name", "1)").contains("no value"));
        assert!(message("levels.9", "1").contains("there is no `9`"));
    }
}
