//! What can be added to a script, as it is when it is new.

use super::document::Edit;
use super::form::quoted;
use super::outline::{self, Page, Section};
use crate::species::fields::MAX_LEVELS;
use crate::species::schema::Species;
use crate::species::syntax::Node;

/// Something that can be added.
#[derive(Clone, Debug)]
pub struct Offer {
    /// Text of its button.
    pub label: &'static str,
    /// What it does, in words.
    pub what: &'static str,
    /// How.
    pub edit: Edit,
    /// Path of what was added.
    pub select: String,
}

/// What can be added to a list of a script. New branches follow the branches that are `selected`, or the last ones,
/// so that what grew on those grows on the new ones.
#[must_use]
pub fn offers(
    section: Section,
    (root, species): (&Node, &Species),
    pages: &[Page],
    selected: &str,
) -> Vec<Offer> {
    let names = || {
        pages
            .iter()
            .filter(|p| p.section == section)
            .map(|p| &*p.title)
    };
    let last = names().count();
    let spline = species.splines.first().map(|s| quoted(&s.name));
    let leaf = species.leaves.first().map(|l| quoted(&l.name));
    let whole = Whole { root, section };
    match section {
        Section::Levels => {
            if last >= MAX_LEVELS {
                return Vec::new();
            }
            let is_branch = |p: &&Page| p.section == section && p.table.name == "Branch";
            let branches = || pages.iter().filter(is_branch);
            let chosen = branches()
                .find(|p| p.path == selected)
                .or_else(|| branches().next_back());
            let Some(parent) = chosen else {
                return Vec::new();
            };
            let after = outline::number(&parent.path).map_or(last, |index| index + 1);
            let mut offers = Vec::new();
            if let Some(spline) = spline {
                let name = quoted(&free(names(), "branches"));
                let item = format!(
                    "Branch(name: {name}, links: 6, start: 0.2, splines: [{spline}], down: 45, \
                     length_of_parent: 0.45, radius_of_parent: 0.5)"
                );
                offers.push(whole.offer("+ branches", "Add branches", after, item));
            }
            if let Some(leaf) = leaf {
                let name = quoted(&free(names(), "leaves"));
                let on = quoted(&parent.title);
                let item = format!(
                    "Leaves(name: {name}, on: {on}, links: 8, start: 0.2, kinds: [{leaf}], down: 50)"
                );
                offers.push(whole.offer("+ leaves", "Add leaves", last, item));
            }
            offers
        }
        Section::Leaves => {
            let name = quoted(&free(names(), "leaf"));
            let item = format!("(name: {name}, length_m: 0.1, width_m: 0.06)");
            vec![whole.offer("+", "Add a leaf kind", last, item)]
        }
        Section::Splines => {
            let name = quoted(&free(names(), "spline"));
            let item = format!("(name: {name}, points: [(0, 0, 0), (0.1, 1, 0), (0, 2, 0)])");
            vec![whole.offer("+", "Add a spline", last, item)]
        }
        Section::Variations => {
            let name = quoted(&free(names(), "kept"));
            let item = format!("(name: {name}, seed: {})", species.seed);
            vec![whole.offer("+", "Keep this tree", last, item)]
        }
        _ => Vec::new(),
    }
}

/// A list of a script, which may not be there yet.
struct Whole<'a> {
    root: &'a Node,
    section: Section,
}

impl Whole<'_> {
    fn offer(&self, label: &'static str, what: &'static str, index: usize, item: String) -> Offer {
        let list = self.section.field().to_owned();
        let select = format!("{list}.{index}");
        let edit = if outline::field(self.root, &list).is_some() {
            Edit::Insert { list, index, item }
        } else {
            Edit::Set {
                path: list,
                value: format!("[{item}]"),
            }
        };
        Offer {
            label,
            what,
            edit,
            select,
        }
    }
}

/// A name that none has yet.
#[must_use]
pub fn free<'a>(names: impl Iterator<Item = &'a str> + Clone, wish: &str) -> String {
    let taken = |name: &str| names.clone().any(|n| n == name);
    if !taken(wish) {
        return wish.to_owned();
    }
    let base = wish.trim_end_matches(|c: char| c.is_ascii_digit());
    let numbered = (2_u64..).map(|number| format!("{base}{number}"));
    numbered
        .into_iter()
        .find(|name| !taken(name))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::document::Document;
    use crate::studio::templates;

    const LISTS: [Section; 4] = [
        Section::Levels,
        Section::Leaves,
        Section::Splines,
        Section::Variations,
    ];

    #[test]
    fn whatever_is_added_to_whatever_template_it_stays_sound() {
        let scripts = templates::ALL.iter().map(|(_, text)| *text);
        for text in scripts.chain([templates::BLANK]) {
            for section in LISTS {
                for number in 0..2 {
                    let mut document = Document::new(text.to_owned());
                    // Twice: names must not clash.
                    for _ in 0..2 {
                        let reading = document.reading();
                        let (root, species) = (
                            reading.root.as_ref().unwrap(),
                            reading.species.as_ref().unwrap(),
                        );
                        let pages = outline::pages(root);
                        let offers = offers(section, (root, species), &pages, "");
                        let Some(offer) = offers.get(number).cloned() else {
                            continue;
                        };
                        document.apply(offer.what, None, offer.edit).unwrap();
                        let reading = document.reading();
                        if let Err(faults) = &reading.species {
                            panic!("{}: {}", offer.what, faults.render(false));
                        }
                        let root = reading.root.as_ref().unwrap();
                        assert!(
                            outline::at(root, &offer.select).is_some(),
                            "{}",
                            offer.select
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn free_names_are_numbered() {
        let names = ["limbs", "limbs2", "kept"];
        let free = |wish| free(names.iter().copied(), wish);
        assert_eq!(
            [free("limbs"), free("limbs2"), free("twigs")],
            ["limbs3", "limbs3", "twigs"]
        );
    }
}
