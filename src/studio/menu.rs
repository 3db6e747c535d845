//! The menu, and the keys for what it holds.

use super::app::{Next, Order, Studio};
use super::templates;
use eframe::egui::{self, Key, KeyboardShortcut, Modifiers, Ui};

const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: KeyboardShortcut =
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
const REDO_TOO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
const SAVE_AS: KeyboardShortcut =
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
const QUIT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Q);
const EXPORT: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::E);

/// What the keys that are pressed ask for; taken before the fields see them, which have an undo of their own.
pub(super) fn pressed(ui: &Ui, orders: &mut Vec<Order>) {
    for (shortcut, order) in [
        (REDO, Order::Redo),
        (REDO_TOO, Order::Redo),
        (UNDO, Order::Undo),
        (SAVE_AS, Order::SaveAs),
        (SAVE, Order::Save),
        (OPEN, Order::Open),
        (EXPORT, Order::Export),
        (QUIT, Order::Ask(Next::Close)),
    ] {
        if ui.input_mut(|i| i.consume_shortcut(&shortcut)) {
            orders.push(order);
        }
    }
}

impl Studio {
    pub(super) fn menu(&self, ui: &mut Ui, orders: &mut Vec<Order>) {
        let entry = |ui: &mut Ui, text: &str, shortcut: &KeyboardShortcut| {
            let keys = ui.ctx().format_shortcut(shortcut);
            ui.add(egui::Button::new(text).shortcut_text(keys))
                .clicked()
        };
        ui.menu_button("File", |ui| {
            ui.menu_button("New", |ui| {
                if ui.button("Blank").clicked() {
                    orders.push(Order::Ask(Next::New(templates::BLANK.to_owned())));
                }
                ui.separator();
                for (name, text) in templates::ALL {
                    if ui.button(*name).clicked() {
                        orders.push(Order::Ask(Next::New((*text).to_owned())));
                    }
                }
            });
            if entry(ui, "Open ...", &OPEN) {
                orders.push(Order::Open);
            }
            if entry(ui, "Save", &SAVE) {
                orders.push(Order::Save);
            }
            if entry(ui, "Save as ...", &SAVE_AS) {
                orders.push(Order::SaveAs);
            }
            ui.separator();
            if entry(ui, "Export a pack ...", &EXPORT) {
                orders.push(Order::Export);
            }
            ui.separator();
            if entry(ui, "Quit", &QUIT) {
                orders.push(Order::Ask(Next::Close));
            }
        });
        ui.menu_button("Edit", |ui| {
            let history = self.document.history();
            let mut step = |ui: &mut Ui, verb: &str, name: Option<&str>, shortcut, order| {
                let text = name.map_or_else(|| verb.to_owned(), |name| format!("{verb}: {name}"));
                let keys = ui.ctx().format_shortcut(shortcut);
                let button = egui::Button::new(text).shortcut_text(keys);
                if ui.add_enabled(name.is_some(), button).clicked() {
                    orders.push(order);
                }
            };
            step(ui, "Undo", history.undoable(), &UNDO, Order::Undo);
            step(ui, "Redo", history.redoable(), &REDO, Order::Redo);
        });
        ui.menu_button("View", |ui| {
            egui::widgets::global_theme_preference_buttons(ui);
        });
    }
}
