//! Writes scripts, and asks where to.

use super::app::{Next, Studio};
use super::browser::Browser;
use super::folder::Wants;
use super::questions::Question;
use eframe::egui::Ui;
use std::path::Path;

impl Studio {
    /// Writes the script to its file or to another one, and goes on to what is next. A script without a file asks
    /// for one first.
    pub(super) fn save(&mut self, ui: &Ui, to: Option<&Path>, next: Option<Next>) {
        if to.is_none() && self.document.path().is_none() {
            return self.ask_where(next);
        }
        // Nothing that another program has written meanwhile is lost.
        if to.is_none() && self.look(ui) && matches!(self.question, Some(Question::Conflict(_))) {
            return;
        }
        match self.document.save(to) {
            Ok(()) => {
                let path = self.document.path().map(|p| p.display().to_string());
                self.say(ui, format!("{} is saved", path.unwrap_or_default()));
                self.renew();
                if let Some(next) = next {
                    self.go_on(ui, next);
                }
            }
            Err(error) => self.say(ui, format!("cannot be saved: {error}")),
        }
    }

    /// Asks for a file to write to.
    pub(super) fn ask_where(&mut self, next: Option<Next>) {
        let slug = self
            .document
            .reading()
            .species
            .as_ref()
            .map(|s| s.slug.clone());
        let own = self.document.path().and_then(Path::file_name);
        let name = own.map(|name| name.to_string_lossy().into_owned());
        let name = name.unwrap_or_else(|| {
            let slug = slug.unwrap_or_else(|_| "species".to_owned());
            format!("{}.ron", slug.replace('-', "_"))
        });
        let browser = Browser::new(Wants::NewScript, &self.document.folder(), &name);
        self.question = Some(Question::SaveAs(browser, next));
    }
}
