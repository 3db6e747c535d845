//! How the panes stand beside one another: at first, as the user has put them, and as it is kept.

use egui_tiles::{
    Container, Linear, LinearDir, SimplificationOptions, Tabs, Tile, TileId, Tiles, Tree,
};
use serde::{Deserialize, Serialize};

/// A part of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Pane {
    Tree,
    Outline,
    Fields,
    Seeds,
    Script,
    Lods,
    Atlas,
    Shadows,
    View,
}

impl Pane {
    const ALL: [Self; 9] = [
        Self::Tree,
        Self::Outline,
        Self::Fields,
        Self::Seeds,
        Self::Script,
        Self::Lods,
        Self::Atlas,
        Self::Shadows,
        Self::View,
    ];

    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Tree => "Tree",
            Self::Outline => "Parts",
            Self::Fields => "Fields",
            Self::Seeds => "Seeds",
            Self::Script => "Script",
            Self::Lods => "LODs",
            Self::Atlas => "Atlas",
            Self::Shadows => "Shadows",
            Self::View => "View",
        }
    }
}

/// Smallest and largest share of its row or column that a part may have.
const SHARES: [f32; 2] = [0.05, 20.0];

/// Rows, columns and tabs within one another are followed so deep.
const DEEPEST: usize = 12;

/// How panes stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Layout {
    Pane(Pane),
    /// One behind another; the number is that of the one in front.
    Tabs(Vec<Self>, usize),
    /// From the left to the right, each with its share of the width.
    Row(Vec<(f32, Self)>),
    /// From the top to the bottom, each with its share of the height.
    Column(Vec<(f32, Self)>),
}

/// Every pane has a tab, by which it can be taken elsewhere.
pub(super) const SIMPLER: SimplificationOptions = SimplificationOptions {
    prune_empty_tabs: true,
    prune_empty_containers: true,
    prune_single_child_tabs: true,
    prune_single_child_containers: true,
    all_panes_must_have_tabs: true,
    join_nested_linear_containers: true,
    flatten_tabs_in_tabs: true,
};

impl Layout {
    /// How the panes stand at first.
    pub(super) fn usual() -> Self {
        use Pane::{Atlas, Fields, Lods, Outline, Script, Seeds, Shadows, View};
        let tabs = |panes: &[Pane]| Self::Tabs(panes.iter().copied().map(Self::Pane).collect(), 0);
        let right = vec![
            (1.5, tabs(&[Fields, Seeds, Lods, Atlas, Shadows, View])),
            (1.0, tabs(&[Script])),
        ];
        Self::Row(vec![
            (0.55, tabs(&[Outline])),
            (2.0, tabs(&[Pane::Tree])),
            (1.25, Self::Column(right)),
        ])
    }

    /// How they stand in a window.
    pub(super) fn of(dock: &Tree<Pane>) -> Option<Self> {
        Self::of_tile(&dock.tiles, dock.root()?)
    }

    fn of_tile(tiles: &Tiles<Pane>, id: TileId) -> Option<Self> {
        let container = match tiles.get(id)? {
            Tile::Pane(pane) => return Some(Self::Pane(*pane)),
            Tile::Container(container) => container,
        };
        let known = |id: &TileId| Some((*id, Self::of_tile(tiles, *id)?));
        let inside: Vec<(TileId, Self)> = container.children().filter_map(known).collect();
        let share = |id: TileId| match container {
            // As much as hands can tell from one another.
            Container::Linear(linear) => {
                let share = (linear.shares[id] * 1000.0).round() / 1000.0;
                // A wide window lets parts get slimmer than other windows may show them.
                share.clamp(SHARES[0], SHARES[1])
            }
            Container::Tabs(_) | Container::Grid(_) => 1.0,
        };
        let shared = || {
            inside
                .iter()
                .map(|(id, one)| (share(*id), one.clone()))
                .collect()
        };
        Some(match container {
            Container::Tabs(tabs) => {
                let active = inside.iter().position(|(id, _)| tabs.active == Some(*id));
                let all = inside.into_iter().map(|(_, one)| one).collect();
                Self::Tabs(all, active.unwrap_or(0))
            }
            Container::Linear(linear) if linear.dir == LinearDir::Vertical => {
                Self::Column(shared())
            }
            Container::Linear(_) | Container::Grid(_) => Self::Row(shared()),
        })
    }

    /// A window's panes that stand so.
    pub(super) fn dock(&self) -> Tree<Pane> {
        let mut tiles = Tiles::default();
        let root = self.tile(&mut tiles);
        Tree::new(egui_id(), root, tiles)
    }

    fn tile(&self, tiles: &mut Tiles<Pane>) -> TileId {
        let (dir, parts) = match self {
            Self::Pane(pane) => return tiles.insert_pane(*pane),
            Self::Tabs(all, active) => {
                let all: Vec<TileId> = all.iter().map(|one| one.tile(tiles)).collect();
                let mut tabs = Tabs::new(all.clone());
                if let Some(active) = all.get(*active) {
                    tabs.set_active(*active);
                }
                return tiles.insert_container(tabs);
            }
            Self::Row(parts) => (LinearDir::Horizontal, parts),
            Self::Column(parts) => (LinearDir::Vertical, parts),
        };
        let ids: Vec<TileId> = parts.iter().map(|(_, one)| one.tile(tiles)).collect();
        let mut linear = Linear::new(dir, ids.clone());
        for (id, (share, _)) in ids.into_iter().zip(parts) {
            linear.shares.set_share(id, *share);
        }
        tiles.insert_container(linear)
    }

    /// As it is kept: no text for the usual one.
    pub(super) fn text(&self) -> String {
        if *self == Self::usual() {
            return String::new();
        }
        ron::to_string(self).unwrap_or_default()
    }

    /// What was kept, so far as it is sound: each pane stands somewhere, and only once. A pane that another version
    /// did not have comes behind the fields.
    pub(super) fn read(text: &str) -> Option<Self> {
        let mut layout: Self = ron::from_str(text).ok()?;
        let mut panes = Vec::new();
        layout.gather(DEEPEST, &mut panes)?;
        let is_twice = |(index, pane): (usize, &Pane)| panes[..index].contains(pane);
        if panes.iter().enumerate().any(is_twice) {
            return None;
        }
        for pane in Pane::ALL.into_iter().filter(|pane| !panes.contains(pane)) {
            layout.add(pane)?;
        }
        Some(layout)
    }

    /// Gathers the panes; `None` if it is too deep, or a share is no number that a window has.
    fn gather(&self, deepest: usize, panes: &mut Vec<Pane>) -> Option<()> {
        let deepest = deepest.checked_sub(1)?;
        match self {
            Self::Pane(pane) => panes.push(*pane),
            Self::Tabs(all, _) => all.iter().try_for_each(|one| one.gather(deepest, panes))?,
            Self::Row(parts) | Self::Column(parts) => {
                for (share, one) in parts {
                    (SHARES[0]..=SHARES[1]).contains(share).then_some(())?;
                    one.gather(deepest, panes)?;
                }
            }
        }
        Some(())
    }

    /// Puts a pane behind the fields.
    fn add(&mut self, pane: Pane) -> Option<()> {
        match self {
            Self::Pane(_) => None,
            Self::Tabs(all, _) if all.contains(&Self::Pane(Pane::Fields)) => {
                all.push(Self::Pane(pane));
                Some(())
            }
            Self::Tabs(all, _) => all.iter_mut().find_map(|one| one.add(pane)),
            Self::Row(parts) | Self::Column(parts) => {
                parts.iter_mut().find_map(|(_, one)| one.add(pane))
            }
        }
    }
}

fn egui_id() -> eframe::egui::Id {
    eframe::egui::Id::unique("studio dock")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn simplified(layout: &Layout) -> Layout {
        let mut dock = layout.dock();
        dock.simplify(&SIMPLER);
        Layout::of(&dock).unwrap()
    }

    #[test]
    fn the_usual_layout_is_no_text_and_stays_as_it_is() {
        let usual = Layout::usual();
        assert_eq!(simplified(&usual), usual);
        assert_eq!(usual.text(), "");
        assert_eq!(Layout::read(""), None);
    }

    #[test]
    fn what_a_user_has_put_elsewhere_is_read_again() {
        let Layout::Row(mut parts) = Layout::usual() else {
            panic!("no row");
        };
        parts.swap(0, 1);
        parts[0].0 = 3.25;
        let Layout::Column(right) = &mut parts[2].1 else {
            panic!("no column");
        };
        right[0].1 = match &right[0].1 {
            Layout::Tabs(all, _) => Layout::Tabs(all.clone(), 2),
            other => panic!("{other:?}"),
        };
        let moved = Layout::Row(parts);
        let text = moved.text();
        assert_eq!(Layout::read(&text), Some(moved.clone()), "{text}");
        assert_eq!(simplified(&moved), moved);
    }

    #[test]
    fn what_is_damaged_or_foreign_is_no_layout() {
        let usual = ron::to_string(&Layout::usual()).unwrap();
        for (from, to) in [
            ("Pane(Script)", "Pane(Tree)"),
            ("Pane(Script)", "Pane(Later)"),
            ("0.55", "0"),
            ("0.55", "inf"),
            ("0.55", "NaN"),
            ("Row(", "Row["),
            ("Pane(Fields)", "Pane(Script)"),
        ] {
            let text = usual.replace(from, to);
            assert_ne!(text, usual);
            assert_eq!(Layout::read(&text), None, "{text}");
        }
        let deep = format!(
            "{}{}{}",
            "Tabs([".repeat(40),
            "Pane(Tree)",
            "],0)".repeat(40)
        );
        assert_eq!(Layout::read(&deep), None);
        let deeper = "Tabs([".repeat(100_000);
        assert_eq!(Layout::read(&deeper), None);
    }

    #[test]
    fn a_pane_that_was_not_there_comes_behind_the_fields() {
        let usual = ron::to_string(&Layout::usual()).unwrap();
        let older = usual.replace("Pane(Lods),", "");
        assert_ne!(older, usual);
        let read = Layout::read(&older).unwrap();
        let text = ron::to_string(&read).unwrap();
        assert!(text.contains("Pane(View),Pane(Lods)]"), "{text}");
    }
}
