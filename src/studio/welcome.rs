//! First words: hints in a corner of a first window, and what the program is.

use super::app::Studio;
use super::dock::Pane;
use eframe::egui::{self, Align2, RichText, Ui, vec2};

/// What a first window says.
const HINTS: [&str; 4] = [
    "Pick a part of the tree on the left; its fields are on the right.",
    "Drag a value, or click it and type. Everything can be undone.",
    "Drag in the view to look around; the wheel brings the tree nearer.",
    "Ctrl+S saves the script, Ctrl+E exports a pack, F1 shows all keys.",
];

/// How far inside the view the hints stand, below what is told of growing, and how wide they are, points. Lower they
/// would hide the tree's foot and the person beside it.
const INSIDE: f32 = 12.0;
const BELOW: f32 = 34.0;
const WIDTH: f32 = 420.0;

impl Studio {
    /// The hints, until they are dismissed.
    pub(super) fn hints(&mut self, ui: &Ui) {
        if !self.shows_hints {
            return;
        }
        let tiles = &self.dock.tiles;
        let view = tiles.find_pane(&Pane::Tree).and_then(|id| tiles.rect(id));
        let view = view.unwrap_or_else(|| ui.ctx().content_rect());
        let mut dismissed = false;
        egui::Window::new("First steps")
            .pivot(Align2::LEFT_TOP)
            .fixed_pos(view.left_top() + vec2(INSIDE, BELOW))
            .collapsible(false)
            .resizable(false)
            .show(ui.ctx(), |ui| {
                ui.set_max_width(WIDTH.min(view.width() - 4.0 * INSIDE));
                for hint in HINTS {
                    ui.label(hint);
                }
                ui.add_space(4.0);
                dismissed = ui.button("Got it").clicked();
            });
        if dismissed {
            self.shows_hints = false;
            self.kept.now.hints = false;
        }
    }

    /// What the program is; true once it is read.
    pub(super) fn about(ui: &mut Ui, adapter: &str) -> bool {
        ui.heading("Pleach studio");
        ui.label(concat!("Version ", env!("CARGO_PKG_VERSION")));
        ui.add_space(4.0);
        ui.label(concat!(env!("CARGO_PKG_DESCRIPTION"), "."));
        ui.add_space(4.0);
        ui.label(RichText::new(concat!("Licence: ", env!("CARGO_PKG_LICENSE"))).weak());
        ui.label(RichText::new(format!("Drawn by {adapter}")).weak());
        ui.add_space(8.0);
        ui.button("Close").clicked()
    }
}

#[cfg(test)]
mod tests {
    use crate::studio::menu::COMMANDS;
    use crate::viewer::keys;
    use eframe::egui::{Key, Modifiers};

    #[test]
    fn the_keys_that_are_hinted_at_are_those_of_the_commands() {
        let has = |name: &str, modifiers: Modifiers, key: Key| {
            let command = COMMANDS.iter().find(|c| c.name == name).unwrap();
            let mut keys = command.keys.iter();
            keys.any(|k| k.logical_key == key && k.modifiers == modifiers)
        };
        assert!(has("Save", Modifiers::COMMAND, Key::S));
        assert!(has("Export a pack ...", Modifiers::COMMAND, Key::E));
        assert!(has("Shortcuts ...", Modifiers::NONE, Key::F1));
        assert!(
            keys::HELD
                .iter()
                .any(|line| line.keys == "Wheel" && line.does == "zoom")
        );
    }
}
