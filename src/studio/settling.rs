//! Keeps the window and the settings that outlive it in step.

use super::app::Studio;
use super::dock::Layout;
use super::kept::{SCALES, Theme};
use super::menu::Scale;
use eframe::egui::{ThemePreference, Ui};
use std::time::Instant;

impl Studio {
    /// Makes the window look as was kept, and keeps how it looks from then on.
    pub(super) fn settle(&mut self, ui: &Ui) {
        let ctx = ui.ctx();
        if self.is_settled {
            self.observe(ui);
        } else {
            self.is_settled = true;
            let screen = ui.input(|input| input.viewport().monitor_size);
            let zoom = ctx.zoom_factor();
            self.kept.suit(screen.map_or(0.0, |screen| screen.y * zoom));
            ctx.set_theme(self.kept.now.theme);
            ctx.set_zoom_factor(self.kept.now.scale);
        }
        let path = self.document.path();
        if self.remembered.as_deref() != path {
            self.remembered = path.map(ToOwned::to_owned);
            if let Some(path) = path {
                self.kept.now.remember(path);
            }
        }
        if let Some(left) = self.kept.keep(Instant::now()) {
            ctx.request_repaint_after(left);
        }
        if let Some(fault) = self.kept.take_fault() {
            self.say(ui, fault);
        }
    }

    /// Takes in what was changed in the window, by whichever widget or key.
    fn observe(&mut self, ui: &Ui) {
        let ctx = ui.ctx();
        self.kept.now.theme = match ctx.options(|o| o.theme_preference) {
            ThemePreference::Dark => Theme::Dark,
            ThemePreference::Light => Theme::Light,
            ThemePreference::System => Theme::System,
        };
        // What is dragged stands somewhere once it is let go of.
        if !ui.input(|input| input.pointer.any_down())
            && let Some(layout) = Layout::of(&self.dock)
        {
            self.kept.now.dock = layout.text();
        }
        let [least, most] = SCALES;
        let scale = ctx.zoom_factor();
        self.kept.now.scale = scale.clamp(least, most);
        if self.kept.now.scale != scale {
            ctx.set_zoom_factor(self.kept.now.scale);
        }
    }

    /// Makes words and widgets larger or smaller.
    pub(super) fn scale(&mut self, ui: &Ui, scale: Scale) {
        ui.ctx().set_zoom_factor(scale.after(self.kept.now.scale));
    }
}
