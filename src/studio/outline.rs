//! What a script is made of, as a list of pages: the species, its bark, leaf kinds, splines, levels and LODs.

use crate::species::fields::{self, Table};
use crate::species::syntax::{Kind, Node};

/// One page.
#[derive(Clone, Debug)]
pub struct Page {
    /// Path of its struct, as for [`crate::species::edit::set`]; empty for the whole script. Items are numbered.
    pub path: String,
    /// Its name.
    pub title: String,
    /// What it is one of.
    pub section: Section,
    /// Its fields.
    pub table: &'static Table,
    /// How deep it stands: levels stand below those that carry them.
    pub depth: usize,
}

/// Groups of pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// The whole script.
    Species,
    /// Several stems.
    Stems,
    /// Bark.
    Bark,
    /// How LODs are made.
    Lod,
    /// Branching levels.
    Levels,
    /// Leaf kinds.
    Leaves,
    /// Shapes of branches.
    Splines,
    /// Named trees.
    Variations,
}

impl Section {
    /// The field of the script that holds it.
    #[must_use]
    pub fn field(self) -> &'static str {
        match self {
            Self::Species => "",
            Self::Stems => "stems",
            Self::Bark => "bark",
            Self::Lod => "lod",
            Self::Levels => "levels",
            Self::Leaves => "leaves",
            Self::Splines => "splines",
            Self::Variations => "variations",
        }
    }

    /// A heading, for those that are lists.
    #[must_use]
    pub fn heading(self) -> Option<&'static str> {
        match self {
            Self::Levels => Some("Levels"),
            Self::Leaves => Some("Leaf kinds"),
            Self::Splines => Some("Splines"),
            Self::Variations => Some("Variations"),
            _ => None,
        }
    }
}

/// All pages of a script, in the order in which they are shown.
#[must_use]
pub fn pages(root: &Node) -> Vec<Page> {
    let mut pages = vec![Page {
        path: String::new(),
        title: "Species".to_owned(),
        section: Section::Species,
        table: &fields::SPECIES,
        depth: 0,
    }];
    for (section, title) in [
        (Section::Stems, "Stems"),
        (Section::Bark, "Bark"),
        (Section::Lod, "LODs"),
    ] {
        let value = field(root, section.field());
        if let Some(table) = value.and_then(|value| table_of(section.field(), value)) {
            pages.push(Page {
                path: section.field().to_owned(),
                title: title.to_owned(),
                section,
                table,
                depth: 0,
            });
        }
    }
    for section in [
        Section::Levels,
        Section::Leaves,
        Section::Splines,
        Section::Variations,
    ] {
        let items = field(root, section.field()).map_or(&[][..], items);
        let depths = depths(items);
        for (index, item) in items.iter().enumerate() {
            let Some(table) = table_of(section.field(), item) else {
                continue;
            };
            pages.push(Page {
                path: format!("{}.{index}", section.field()),
                title: name(item).map_or_else(|| format!("{} {index}", table.name), str::to_owned),
                section,
                table,
                depth: if section == Section::Levels {
                    depths[index]
                } else {
                    0
                },
            });
        }
    }
    pages
}

/// How deep each level stands: below the one that it names, or else below the last level of branches before it.
fn depths(items: &[Node]) -> Vec<usize> {
    let mut depths: Vec<usize> = Vec::with_capacity(items.len());
    let is_branch = |item: &Node| variant(item) == Some("Branch");
    for (index, item) in items.iter().enumerate() {
        let on = field(item, "on").and_then(text);
        let parent = match on {
            Some(on) => items.iter().take(index).position(|i| name(i) == Some(on)),
            None => items.iter().take(index).rposition(is_branch),
        };
        depths.push(parent.map_or(0, |parent| depths[parent] + 1));
    }
    depths
}

/// The fields that a value has, from its variant's name or from the field that holds it.
#[must_use]
pub fn table_of(field: &str, value: &Node) -> Option<&'static Table> {
    let by_name = |name: &str| fields::TABLES.iter().copied().find(|t| t.name == name);
    if let Some(table) = variant(value).and_then(by_name) {
        return Some(table);
    }
    if !matches!(value.kind, Kind::Struct { .. } | Kind::Tuple { .. }) {
        return None;
    }
    let names = match field {
        // `Leaves` is a level of them.
        "leaves" => ["leaf"; 2],
        _ => [field, field.strip_suffix('s').unwrap_or(field)],
    };
    names.into_iter().find_map(|name| {
        let mut letters = name.chars();
        let first = letters.next()?.to_ascii_uppercase();
        by_name(&format!("{first}{}", letters.as_str()))
    })
}

/// A field's value.
#[must_use]
pub fn field<'n>(node: &'n Node, key: &str) -> Option<&'n Node> {
    let Kind::Struct { fields, .. } = &node.kind else {
        return None;
    };
    fields.iter().find(|f| f.key == key).map(|f| &f.value)
}

/// A list's items.
#[must_use]
pub fn items(node: &Node) -> &[Node] {
    match &node.kind {
        Kind::List(items) => items,
        _ => &[],
    }
}

/// The name before the bracket of a variant, or a bare one.
#[must_use]
pub fn variant(node: &Node) -> Option<&str> {
    match &node.kind {
        Kind::Struct { name, .. } | Kind::Tuple { name, .. } => name.as_deref(),
        Kind::Ident(name) => Some(name),
        _ => None,
    }
}

/// The number that a path ends in.
#[must_use]
pub fn number(path: &str) -> Option<usize> {
    path.rsplit_once('.')?.1.parse().ok()
}

/// What an item calls itself.
#[must_use]
pub fn name(node: &Node) -> Option<&str> {
    field(node, "name").and_then(text)
}

/// A text's value.
#[must_use]
pub fn text(node: &Node) -> Option<&str> {
    match &node.kind {
        Kind::Text(text) => Some(text),
        _ => None,
    }
}

/// The value at a path of fields and numbers.
#[must_use]
pub fn at<'n>(root: &'n Node, path: &str) -> Option<&'n Node> {
    let steps = path.split('.').filter(|step| !step.is_empty());
    steps
        .into_iter()
        .try_fold(root, |node, step| match &node.kind {
            Kind::List(items) => items.get(step.parse::<usize>().ok()?),
            _ => field(node, step),
        })
}

/// What a struct that is not there yet begins with.
#[must_use]
pub fn beginning(field: &str) -> Option<&'static str> {
    Some(match field {
        "stems" => "(count: 3)",
        "flare" => "(height_m: 1, amount: 0.5)",
        "flutes" => "(count: 6, depth: 0.1)",
        "envelope" => "(height_m: 12, radius_m: [(0, 1), (0.4, 4), (1, 0.5)])",
        "lod" => "()",
        "bark" => "Ridged()",
        "spray" => "(shoots: 3)",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::syntax;

    fn script(name: &str) -> Node {
        let path = format!("{}/species/{name}.ron", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        syntax::parse(&text).0.unwrap()
    }

    #[test]
    fn every_part_of_the_oak_has_a_page() {
        let root = script("english_oak");
        let pages = pages(&root);
        assert_eq!(pages[0].title, "Species");
        for section in ["levels", "leaves", "splines", "variations"] {
            let items = field(&root, section).map_or(0, |list| items(list).len());
            let shown = pages
                .iter()
                .filter(|p| p.section.field() == section)
                .count();
            assert_eq!((shown, shown > 0), (items, true), "{section}");
        }
        for page in &pages {
            assert!(at(&root, &page.path).is_some(), "{}", page.path);
        }
        let bark = pages.iter().find(|p| p.section == Section::Bark).unwrap();
        assert_eq!(bark.table.name, "Ridged");
        let leaves = pages.iter().filter(|p| p.section == Section::Leaves);
        assert!(leaves.map(|p| p.table.name).all(|name| name == "Leaf"));
    }

    #[test]
    fn levels_stand_below_those_that_carry_them() {
        let pages = pages(&script("coast_redwood"));
        let depth = |title: &str| {
            let level = |p: &&Page| p.section == Section::Levels && p.title == title;
            pages.iter().find(level).unwrap().depth
        };
        assert_eq!(
            ["trunk", "limbs", "branches", "shoots"].map(depth),
            [0, 1, 2, 3]
        );
        assert_eq!(["inner sprays", "upper limbs"].map(depth), [2, 1]);
    }

    #[test]
    fn every_struct_with_a_beginning_reads_as_its_table() {
        for name in [
            "stems", "flare", "flutes", "envelope", "lod", "bark", "spray",
        ] {
            let (node, faults) = syntax::parse(beginning(name).unwrap());
            assert!(faults.is_empty());
            assert!(table_of(name, &node.unwrap()).is_some(), "{name}");
        }
    }
}
