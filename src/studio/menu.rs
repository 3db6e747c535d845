//! All commands in one table, from which the menu, its keys and the palette are made.

use super::app::{Next, Order, Studio};
use super::kept::{SCALES, Theme};
use super::templates;
use eframe::egui::{self, Key, KeyboardShortcut, Modifiers, RichText, Ui};

/// Where a command stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Menu {
    New,
    File,
    Edit,
    View,
    Theme,
    Help,
}

impl Menu {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::New => "New",
            Self::File => "File",
            Self::Edit => "Edit",
            Self::View => "View",
            Self::Theme => "Theme",
            Self::Help => "Help",
        }
    }
}

/// Something that can be asked for by menu, keys or palette.
pub(super) struct Command {
    pub(super) menu: Menu,
    pub(super) name: &'static str,
    /// Keys that ask for it; the menu shows the first.
    pub(super) keys: &'static [KeyboardShortcut],
    pub(super) order: fn() -> Order,
}

/// How the scale of words and widgets changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    Larger,
    Smaller,
    Usual,
}

/// One step of the scale.
const STEP: f32 = 0.1;

impl Scale {
    /// The scale after `scale`, in steps of a tenth and within bounds.
    pub(super) fn after(self, scale: f32) -> f32 {
        let step = match self {
            Self::Larger => STEP,
            Self::Smaller => -STEP,
            Self::Usual => return 1.0,
        };
        let [least, most] = SCALES;
        (((scale + step) * 10.0).round() / 10.0).clamp(least, most)
    }
}

const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}

const fn ctrl_shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key)
}

const fn command(
    menu: Menu,
    name: &'static str,
    keys: &'static [KeyboardShortcut],
    order: fn() -> Order,
) -> Command {
    Command {
        menu,
        name,
        keys,
        order,
    }
}

fn blank() -> Order {
    Order::Ask(Next::New(templates::BLANK.to_owned()))
}

const UNDO: &[KeyboardShortcut] = &[ctrl(Key::Z)];
const REDO: &[KeyboardShortcut] = &[ctrl_shift(Key::Z), ctrl(Key::Y)];
const LARGER: &[KeyboardShortcut] = &[ctrl(Key::Plus), ctrl(Key::Equals)];
const PALETTE: &[KeyboardShortcut] = &[
    KeyboardShortcut::new(Modifiers::NONE, Key::F1),
    ctrl_shift(Key::P),
];

/// Every command that stands in the menu as it is, in the menu's order.
#[rustfmt::skip]
pub(super) const COMMANDS: &[Command] = &[
    command(Menu::New, "Blank", &[ctrl(Key::N)], blank),
    command(Menu::File, "Open ...", &[ctrl(Key::O)], || Order::Open),
    command(Menu::File, "Save", &[ctrl(Key::S)], || Order::Save),
    command(Menu::File, "Save as ...", &[ctrl_shift(Key::S)], || Order::SaveAs),
    command(Menu::File, "Export a pack ...", &[ctrl(Key::E)], || Order::Export),
    command(Menu::File, "Quit", &[ctrl(Key::Q)], || Order::Ask(Next::Close)),
    command(Menu::Edit, "Undo", UNDO, || Order::Undo),
    command(Menu::Edit, "Redo", REDO, || Order::Redo),
    command(Menu::View, "Larger", LARGER, || Order::Scale(Scale::Larger)),
    command(Menu::View, "Smaller", &[ctrl(Key::Minus)], || Order::Scale(Scale::Smaller)),
    command(Menu::View, "Usual size", &[ctrl(Key::Num0)], || Order::Scale(Scale::Usual)),
    command(Menu::View, "Reset layout", &[], || Order::ResetLayout),
    command(Menu::Theme, "Dark", &[], || Order::Theme(Theme::Dark)),
    command(Menu::Theme, "Light", &[], || Order::Theme(Theme::Light)),
    command(Menu::Theme, "As the system", &[], || Order::Theme(Theme::System)),
    command(Menu::Help, "Shortcuts ...", PALETTE, || Order::Palette),
    command(Menu::Help, "Hints", &[], || Order::Hints),
    command(Menu::Help, "About ...", &[], || Order::About),
];

/// Commands that a line parts from those before them.
const PARTED: [&str; 4] = ["Export a pack ...", "Quit", "Reset layout", "About ..."];

/// What the keys that are pressed ask for; taken before the fields see them, which have an undo of their own.
pub(super) fn pressed(ui: &Ui, orders: &mut Vec<Order>) {
    let pairs = COMMANDS
        .iter()
        .flat_map(|c| c.keys.iter().map(move |k| (k, c)));
    // Keys with fewer modifiers pass for those with more of them, which come first.
    let (more, fewer): (Vec<_>, Vec<_>) = pairs.partition(|(keys, _)| keys.modifiers.shift);
    for (keys, command) in more.into_iter().chain(fewer) {
        if ui.input_mut(|i| i.consume_shortcut(keys)) {
            orders.push((command.order)());
        }
    }
}

impl Studio {
    pub(super) fn menu(&self, ui: &mut Ui, orders: &mut Vec<Order>) {
        ui.menu_button("File", |ui| {
            ui.menu_button("New", |ui| {
                self.entries(ui, Menu::New, orders);
                ui.separator();
                for (name, text) in templates::ALL {
                    if ui.button(*name).clicked() {
                        orders.push(Order::Ask(Next::New((*text).to_owned())));
                    }
                }
            });
            ui.menu_button("Open recent", |ui| self.recent(ui, orders));
            self.entries(ui, Menu::File, orders);
        });
        ui.menu_button("Edit", |ui| self.entries(ui, Menu::Edit, orders));
        ui.menu_button("View", |ui| {
            ui.label(format!(
                "Size of words: {:.0} %",
                self.kept.now.scale * 100.0
            ));
            self.entries(ui, Menu::View, orders);
            ui.separator();
            ui.label("Theme");
            self.entries(ui, Menu::Theme, orders);
        });
        ui.menu_button("Help", |ui| self.entries(ui, Menu::Help, orders));
    }

    fn entries(&self, ui: &mut Ui, menu: Menu, orders: &mut Vec<Order>) {
        let history = self.document.history();
        for command in COMMANDS.iter().filter(|c| c.menu == menu) {
            let order = (command.order)();
            let step = match order {
                Order::Undo => Some(history.undoable()),
                Order::Redo => Some(history.redoable()),
                _ => None,
            };
            let text = match step {
                Some(Some(step)) => format!("{}: {step}", command.name),
                _ => command.name.to_owned(),
            };
            if PARTED.contains(&command.name) {
                ui.separator();
            }
            let mut button = egui::Button::new(text);
            if let Order::Theme(theme) = order {
                button = button.selected(theme == self.kept.now.theme);
            }
            if let Some(keys) = command.keys.first() {
                button = button.shortcut_text(ui.ctx().format_shortcut(keys));
            }
            if ui.add_enabled(step != Some(None), button).clicked() {
                orders.push(order);
            }
        }
    }

    /// Scripts that were open; those that are gone are shown weak.
    fn recent(&self, ui: &mut Ui, orders: &mut Vec<Order>) {
        let recent = &self.kept.now.recent;
        if recent.is_empty() {
            ui.weak("none yet");
        }
        for path in recent {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let folder = path.parent().map(|p| p.display().to_string());
            let text = format!("{name}  in {}", folder.unwrap_or_default());
            let text = if self.presence.is_there(path, ui.ctx()) {
                RichText::new(text)
            } else {
                RichText::new(text).weak()
            };
            if ui.button(text).clicked() {
                orders.push(Order::Ask(Next::Open(path.clone())));
            }
        }
        if !recent.is_empty() {
            ui.separator();
            if ui.button("Forget these").clicked() {
                orders.push(Order::ForgetRecent);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_keys_or_a_name_in_a_menu() {
        let mut keys = Vec::new();
        for (index, command) in COMMANDS.iter().enumerate() {
            for shortcut in command.keys {
                assert!(!keys.contains(shortcut), "{}: {shortcut:?}", command.name);
                keys.push(*shortcut);
            }
            let same = |c: &Command| (c.menu, c.name) == (command.menu, command.name);
            assert!(!COMMANDS[..index].iter().any(same), "{}", command.name);
        }
        for name in PARTED {
            assert!(COMMANDS.iter().any(|c| c.name == name), "{name}");
        }
    }

    #[test]
    fn the_scale_goes_in_tenths_and_stays_within_bounds() {
        let after = |scale: f32, by: Scale| (by.after(scale) * 100.0).round();
        assert_eq!(after(1.0, Scale::Larger), 110.0);
        assert_eq!(after(1.13, Scale::Smaller), 100.0);
        assert_eq!(after(2.0, Scale::Larger), 200.0);
        assert_eq!(after(0.8, Scale::Smaller), 80.0);
        assert_eq!(after(1.7, Scale::Usual), 100.0);
    }
}
