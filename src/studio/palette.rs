//! The palette: every command and every template with its keys, found by typing a part of its name; and what keys
//! and mouse do in the view.

use super::app::{Next, Order};
use super::menu::{COMMANDS, Menu};
use super::templates;
use super::viewing::is_obeyed;
use crate::viewer::keys;
use eframe::egui::{self, Key, KeyboardShortcut, Modifiers, Ui};

/// Height of the list, points.
const LIST: f32 = 380.0;

/// A line of the palette.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// What it does.
    pub(super) name: String,
    /// Keys or mouse, in words.
    pub(super) keys: String,
    /// What is done; none if it can only be done by hand.
    pub(super) order: Option<Order>,
}

/// The palette while it is open.
#[derive(Debug, Default)]
pub(super) struct Palette {
    search: String,
    /// Number of the row that Enter runs, among those that are shown and can be run.
    chosen: usize,
    is_open: bool,
}

/// All rows; `keys` is how a shortcut is written.
pub(super) fn rows(keys: impl Fn(&KeyboardShortcut) -> String) -> Vec<Row> {
    let commands = COMMANDS.iter().map(|command| {
        let all: Vec<String> = command.keys.iter().map(&keys).collect();
        let name = match command.menu {
            Menu::New | Menu::Theme => format!("{}: {}", command.menu.name(), command.name),
            _ => command.name.trim_end_matches(" ...").to_owned(),
        };
        Row {
            name,
            keys: all.join(" or "),
            order: Some((command.order)()),
        }
    });
    let new = templates::ALL.iter().map(|(name, text)| Row {
        name: format!("New: {name}"),
        keys: String::new(),
        order: Some(Order::Ask(Next::New((*text).to_owned()))),
    });
    let in_view = keys::KEYS.iter().filter_map(|(line, pairs)| {
        let (_, action) = pairs.first().filter(|(_, action)| is_obeyed(*action))?;
        let is_one = pairs.iter().all(|(_, other)| other == action);
        Some(Row {
            name: format!("View: {}", line.does),
            keys: line.keys.to_owned(),
            order: is_one.then_some(Order::Act(*action)),
        })
    });
    let by_hand = keys::HELD.iter().map(|line| Row {
        name: format!("View: {}", line.does),
        keys: line.keys.to_owned(),
        order: None,
    });
    commands.chain(in_view).chain(by_hand).chain(new).collect()
}

/// True if a row holds all words of a search, in any case and order.
pub(super) fn is_found(row: &Row, search: &str) -> bool {
    let text = format!("{} {}", row.name, row.keys).to_lowercase();
    search
        .to_lowercase()
        .split_whitespace()
        .all(|word| text.contains(word))
}

impl Palette {
    /// The palette's widgets; what is to be run.
    pub(super) fn ui(&mut self, ui: &mut Ui) -> Option<Order> {
        let all = rows(|keys| ui.ctx().format_shortcut(keys));
        let label = ui.heading("Shortcuts");
        let run = self.field(ui, label.id);
        let found: Vec<&Row> = all
            .iter()
            .filter(|row| is_found(row, &self.search))
            .collect();
        let count = found.iter().filter(|row| row.order.is_some()).count();
        self.chosen = self.chosen.min(count.saturating_sub(1));
        let mut asked = None;
        let before = self.chosen;
        if ui.memory(|m| m.focused().is_some()) {
            let down = ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::ArrowDown));
            let up = ui.input_mut(|i| i.consume_key(Modifiers::NONE, Key::ArrowUp));
            self.chosen += usize::from(down && self.chosen + 1 < count);
            self.chosen -= usize::from(up && self.chosen > 0);
        }
        ui.add_space(4.0);
        let area = egui::ScrollArea::vertical().auto_shrink(false);
        let rows = |ui: &mut Ui| {
            let mut number = 0;
            for row in &found {
                let is_chosen = row.order.is_some() && number == self.chosen;
                number += usize::from(row.order.is_some());
                let response = line(ui, row, is_chosen);
                if is_chosen && before != self.chosen {
                    response.scroll_to_me(None);
                }
                if response.clicked() || (is_chosen && run) {
                    asked.clone_from(&row.order);
                }
            }
            if found.is_empty() {
                ui.weak("Nothing is called so.");
            }
        };
        area.max_height(LIST).show(ui, |ui| {
            ui.with_layout(egui::Layout::top_down_justified(egui::Align::LEFT), rows);
        });
        asked
    }

    /// The field to search in; true if Enter was pressed in it.
    fn field(&mut self, ui: &mut Ui, label: egui::Id) -> bool {
        let edit = egui::TextEdit::singleline(&mut self.search);
        let edit = edit.desired_width(f32::INFINITY).hint_text("Search");
        let response = ui.add(edit).labelled_by(label);
        if response.changed() {
            self.chosen = 0;
        }
        if !std::mem::replace(&mut self.is_open, true) {
            response.request_focus();
        }
        let run = response.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        if run {
            response.request_focus();
        }
        run
    }
}

/// A row over the whole width; what can only be done by hand cannot be pressed.
fn line(ui: &mut Ui, row: &Row, is_chosen: bool) -> egui::Response {
    let button = egui::Button::selectable(is_chosen, &*row.name).shortcut_text(&*row.keys);
    ui.add_enabled(row.order.is_some(), button)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_and_what_the_view_obeys_is_in_the_palette() {
        let rows = rows(|keys| format!("{:?}", keys.logical_key));
        for command in COMMANDS {
            let name = command.name.trim_end_matches(" ...");
            let row = rows
                .iter()
                .find(|row| row.name.ends_with(name) && row.order.is_some());
            let keys = &row.unwrap_or_else(|| panic!("{name}")).keys;
            for shortcut in command.keys {
                assert!(
                    keys.contains(&format!("{:?}", shortcut.logical_key)),
                    "{name}: {keys}"
                );
            }
        }
        for word in ["orbit", "turntable", "silver birch"] {
            assert_eq!(
                rows.iter().filter(|row| is_found(row, word)).count(),
                1,
                "{word}"
            );
        }
        // The palette has no use for what only the preview's window does.
        assert!(!rows.iter().any(|row| is_found(row, "show or hide")));
    }

    #[test]
    fn words_are_found_in_any_order() {
        let row = Row {
            name: "Export a pack".to_owned(),
            keys: "Ctrl+E".to_owned(),
            order: None,
        };
        for (search, found) in [
            ("", true),
            ("pack EXP", true),
            ("ctrl", true),
            ("undo", false),
        ] {
            assert_eq!(is_found(&row, search), found, "{search}");
        }
    }
}
