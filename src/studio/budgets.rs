//! Triangle budgets of the LODs as the text has them: which LOD was made of which, and sound changes of them.

use super::document::Edit;
use super::outline;
use crate::species::fields::{BUDGET, MAX_BUDGETS};
use crate::species::syntax::Node;
use std::ops::RangeInclusive;

/// How much coarser a new LOD is that has none beyond it.
const STEP: u64 = 4;

/// A budget, a LOD, or both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Line {
    /// Index of the budget in the text.
    pub(super) budget: Option<usize>,
    /// Index of the LOD that was made of it.
    pub(super) lod: Option<usize>,
}

/// The lines of a table: LODs without a budget, then the budgets of the text in their order, each with the LOD that
/// was made of it, or of the one that stood in its place while the tree `asked` for others. `lods` are the budgets of
/// the LODs.
pub(super) fn lines(budgets: &[u64], asked: &[u64], lods: &[Option<u64>]) -> Vec<Line> {
    let is_same = budgets.len() == asked.len();
    let free = lods.iter().enumerate().filter(|(_, of)| of.is_none());
    let mut lines: Vec<Line> = free
        .map(|(lod, _)| Line {
            budget: None,
            lod: Some(lod),
        })
        .collect();
    lines.extend(budgets.iter().enumerate().map(|(index, &budget)| {
        let made_of = if is_same { asked[index] } else { budget };
        Line {
            budget: Some(index),
            lod: lods.iter().position(|&of| of == Some(made_of)),
        }
    }));
    lines
}

/// What a budget may be set to: less than the one before, more than the one after.
pub(super) fn range(budgets: &[u64], index: usize) -> RangeInclusive<u64> {
    let before = index.checked_sub(1).and_then(|i| budgets.get(i));
    let most = before.map_or(BUDGET.1, |&before| before.saturating_sub(1));
    let least = budgets.get(index + 1).map_or(BUDGET.0, |&after| after + 1);
    least..=most.max(least)
}

/// A new budget at `index`, between its neighbours; none where there is no room.
pub(super) fn between(budgets: &[u64], index: usize) -> Option<u64> {
    if budgets.len() >= MAX_BUDGETS {
        return None;
    }
    let before = index.checked_sub(1).and_then(|i| budgets.get(i)).copied();
    let after = budgets.get(index).copied();
    let new = match (before, after) {
        (None, None) => return None,
        (None, Some(after)) => after.saturating_mul(STEP).min(BUDGET.1),
        (Some(before), None) => (before / STEP).max(BUDGET.0),
        // Their geometric mean, or the nearest number above the lower one.
        (Some(before), Some(after)) => before.saturating_mul(after).isqrt().max(after + 1),
    };
    let is_sound = before.is_none_or(|before| new < before) && after.is_none_or(|a| new > a);
    is_sound.then_some(new)
}

/// A list as a script writes it.
pub(super) fn list<T>(items: &[T], text: impl Fn(&T) -> String) -> String {
    let all: Vec<String> = items.iter().map(text).collect();
    format!("[{}]", all.join(", "))
}

/// Changes of the list, whether the text holds it already or means its default.
pub(super) struct Budgets<'a> {
    /// The text's values.
    pub(super) root: &'a Node,
    /// The budgets that they mean.
    pub(super) budgets: &'a [u64],
}

impl Budgets<'_> {
    const PATH: &'static str = "lod.budgets";

    fn is_written(&self) -> bool {
        let lod = outline::field(self.root, "lod");
        lod.and_then(|lod| outline::field(lod, "budgets")).is_some()
    }

    fn whole(budgets: &[u64]) -> Edit {
        Edit::Set {
            path: Self::PATH.to_owned(),
            value: list(budgets, ToString::to_string),
        }
    }

    /// Sets one of them.
    pub(super) fn set(&self, index: usize, budget: u64) -> Edit {
        if self.is_written() {
            return Edit::Set {
                path: format!("{}.{index}", Self::PATH),
                value: budget.to_string(),
            };
        }
        let mut budgets = self.budgets.to_vec();
        budgets[index] = budget;
        Self::whole(&budgets)
    }

    /// Puts one in.
    pub(super) fn add(&self, index: usize, budget: u64) -> Edit {
        if self.is_written() {
            return Edit::Insert {
                list: Self::PATH.to_owned(),
                index,
                item: budget.to_string(),
            };
        }
        let mut budgets = self.budgets.to_vec();
        budgets.insert(index, budget);
        Self::whole(&budgets)
    }

    /// Takes one out; the last one stays.
    pub(super) fn remove(&self, index: usize) -> Option<Edit> {
        if self.budgets.len() < 2 {
            return None;
        }
        if self.is_written() {
            return Some(Edit::Remove(format!("{}.{index}", Self::PATH)));
        }
        let mut budgets = self.budgets.to_vec();
        budgets.remove(index);
        Some(Self::whole(&budgets))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studio::document::Document;
    use crate::studio::templates::BLANK;

    fn budgets(document: &Document) -> Vec<u64> {
        match &document.reading().species {
            Ok(species) => species.lod.budgets.clone(),
            Err(faults) => panic!("{}", faults.render(false)),
        }
    }

    fn change(document: &mut Document, edit: impl FnOnce(&Budgets<'_>) -> Option<Edit>) -> bool {
        let budgets = budgets(document);
        let edit = edit(&Budgets {
            root: document.reading().root.as_ref().unwrap(),
            budgets: &budgets,
        });
        let Some(edit) = edit else {
            return false;
        };
        document.apply("Change budgets", None, edit).unwrap();
        true
    }

    #[test]
    fn budgets_are_changed_where_the_text_has_them_and_where_it_means_them() {
        let written = BLANK.replacen(
            "format:",
            "lod: (budgets: [\n 9000, // near\n 700, // far\n]),\n format:",
            1,
        );
        let plain = BLANK.replacen("format:", "lod: (budgets: [9000, 700]), format:", 1);
        for (text, first) in [(BLANK, 10_000), (&*written, 9_000), (&*plain, 9_000)] {
            let mut document = Document::new(text.to_owned());
            let before = budgets(&document);
            assert_eq!(before[0], first);
            assert!(change(&mut document, |b| Some(b.set(1, 500))));
            assert_eq!(budgets(&document)[..2], [first, 500]);
            assert_eq!(
                document.text().contains("// near"),
                text.contains("// near")
            );
            assert!(change(&mut document, |b| Some(b.add(1, 654))));
            assert_eq!(budgets(&document)[..3], [first, 654, 500]);
            // What is said of the others stays beside them.
            assert_eq!(document.text().contains("// far"), text.contains("// far"));
            assert!(change(&mut document, |b| b.remove(0)));
            assert_eq!(budgets(&document)[..2], [654, 500]);
            assert_eq!(document.text().contains("// far"), text.contains("// far"));
            assert_eq!(budgets(&document).len(), before.len());
            while change(&mut document, |b| b.remove(0)) {}
            assert_eq!(budgets(&document).len(), 1, "the last one stays");
        }
    }

    #[test]
    fn whatever_is_added_or_dragged_to_its_ends_the_budgets_fall() {
        let mut document = Document::new(BLANK.to_owned());
        for round in 0..40_usize {
            let now = budgets(&document);
            let index = round * 7 % (now.len() + 1);
            match between(&now, index) {
                Some(new) => assert!(change(&mut document, |b| Some(b.add(index, new)))),
                None => assert!(
                    now.len() == MAX_BUDGETS || index == now.len() && now.last() == Some(&4)
                ),
            }
            let now = budgets(&document);
            let index = round * 5 % now.len();
            let range = range(&now, index);
            assert!(range.contains(&now[index]));
            for end in [*range.start(), *range.end()] {
                assert!(change(&mut document, |b| Some(b.set(index, end))));
                assert_eq!(budgets(&document)[index], end);
            }
            assert!(change(&mut document, |b| Some(b.set(index, now[index]))));
        }
    }

    #[test]
    fn there_is_no_budget_between_neighbours() {
        assert_eq!(between(&[100, 99], 1), None);
        assert_eq!(between(&[100, 98], 1), Some(99));
        assert_eq!(between(&[1000, 10], 1), Some(100));
        assert_eq!(between(&[1000, 10], 2), Some(4));
        assert_eq!(between(&[1000, 4], 2), None);
        assert_eq!(between(&[1000, 10], 0), Some(4000));
        assert_eq!(between(&[], 0), None);
    }

    #[test]
    fn a_budget_keeps_its_line_while_it_is_dragged() {
        let line = |budget, lod| Line { budget, lod };
        let lods = [None, Some(1000), Some(10)];
        // The second budget got no LOD.
        let asked = [1000, 900, 10];
        let expected = [
            line(None, Some(0)),
            line(Some(0), Some(1)),
            line(Some(1), None),
            line(Some(2), Some(2)),
        ];
        assert_eq!(lines(&asked, &asked, &lods), expected);
        assert_eq!(lines(&[1200, 900, 20], &asked, &lods), expected);
        // One is new: the others are known by what they ask for.
        let new = lines(&[1000, 900, 100, 10], &asked, &lods);
        assert_eq!(new[3..], [line(Some(2), None), line(Some(3), Some(2))]);
    }
}
