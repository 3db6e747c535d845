//! The preview's keys, as far as they mean something in the studio.

use super::app::Studio;
use crate::viewer::keys::{self, Action};
use crate::viewer::level::Choice;
use crate::viewer::settings::Arrangement;
use eframe::egui::Ui;

/// True for what the studio does: it has a help of its own, and no other window to close or to hide.
pub(super) fn is_obeyed(action: Action) -> bool {
    !matches!(
        action,
        Action::Screenshot | Action::Panel | Action::Help | Action::Quit
    )
}

impl Studio {
    /// Obeys the keys of the view, unless a person writes somewhere.
    pub(super) fn view_keys(&mut self, ui: &Ui) {
        for action in keys::pressed_of(ui.ctx(), is_obeyed) {
            self.act(action);
        }
    }

    /// Does what a key of the view asks for.
    pub(super) fn act(&mut self, action: Action) {
        let shown = self.shown.clone();
        let subject = shown.as_deref().map(|g| &g.subject);
        let settings = &mut self.settings;
        let before = settings.arrangement;
        match action {
            Action::Frame => {
                if let Some(subject) = subject {
                    self.view.frame(subject, settings);
                }
            }
            Action::Lod(lod) => settings.choice = Choice::Fixed(lod),
            Action::ByDistance => settings.choice = Choice::ByDistance,
            Action::NextView => settings.next_view(),
            Action::Forest => settings.toggle(Arrangement::Forest),
            Action::Strip => settings.toggle(Arrangement::Strip),
            Action::Turntable => settings.turntable = !settings.turntable,
            Action::Wind => settings.breeze.on = !settings.breeze.on,
            Action::Slower => self.view.rig.hasten(0.5),
            Action::Faster => self.view.rig.hasten(2.0),
            Action::Screenshot | Action::Panel | Action::Help | Action::Quit => {}
        }
        if let Some(subject) = subject
            && self.settings.arrangement != before
        {
            self.view.arrange(before, subject, &self.settings);
        }
    }
}
