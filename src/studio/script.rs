//! The script's text beside the pages: both can be edited, faults are underlined.

use crate::species::fault::Fault;
use eframe::egui::text::{LayoutJob, TextFormat};
use eframe::egui::{self, Color32, FontId, RichText, Stroke, TextStyle, Ui};
use std::ops::Range;

/// Shows the text and what is at fault in it; gives a new text if it was changed, and true if a word was finished.
pub(super) fn ui(ui: &mut Ui, text: &str, faults: &[Fault]) -> (Option<String>, bool) {
    let mut edited = text.to_owned();
    let mut finished = false;
    let height = if faults.is_empty() { 0.0 } else { 96.0 };
    let room = (ui.available_height() - height).max(60.0);
    egui::ScrollArea::both()
        .id_salt("script")
        .max_height(room)
        .show(ui, |ui| {
            let spans: Vec<Range<usize>> = own(faults).map(|f| f.span.clone()).collect();
            let mut layouter = |ui: &Ui, text: &dyn egui::TextBuffer, _wrap: f32| {
                let job = laid_out(ui, text.as_str(), &spans);
                ui.fonts_mut(|fonts| fonts.layout_job(job))
            };
            let edit = egui::TextEdit::multiline(&mut edited)
                .id_salt("text")
                .code_editor()
                .desired_width(f32::INFINITY)
                .layouter(&mut layouter);
            let response = ui.add(edit);
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::MultilineTextInput, true, "Script")
            });
            let paused = response.changed() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            finished = response.lost_focus() || paused;
        });
    if !faults.is_empty() {
        ui.separator();
        egui::ScrollArea::vertical()
            .id_salt("faults")
            .show(ui, |ui| {
                for fault in faults {
                    told(ui, text, fault);
                }
            });
    }
    ((edited != text).then_some(edited), finished)
}

/// Faults of the script itself.
fn own(faults: &[Fault]) -> impl Iterator<Item = &Fault> {
    faults.iter().filter(|f| f.source == 0)
}

fn told(ui: &mut Ui, text: &str, fault: &Fault) {
    let colour = ui.visuals().error_fg_color;
    let line = text
        .get(..fault.span.start)
        .map(|before| before.matches('\n').count() + 1);
    let place = match line.filter(|_| fault.source == 0) {
        Some(line) => format!("line {line}: "),
        None => String::new(),
    };
    ui.label(RichText::new(format!("{place}{}", fault.message)).color(colour));
    if let Some(help) = &fault.help {
        ui.label(RichText::new(help).weak());
    }
}

/// The text in monospace, comments weak, faults underlined.
fn laid_out(ui: &Ui, text: &str, faults: &[Range<usize>]) -> LayoutJob {
    let font = TextStyle::Monospace.resolve(ui.style());
    let visuals = ui.visuals();
    let colours = [visuals.text_color(), visuals.weak_text_color()];
    let mut job = LayoutJob::default();
    for (range, is_comment) in runs(text) {
        // A fault may begin and end within a run.
        let mut cuts = vec![range.start, range.end];
        for fault in faults {
            for at in [fault.start, fault.end.max(fault.start + 1)] {
                if range.contains(&at) && text.is_char_boundary(at) {
                    cuts.push(at);
                }
            }
        }
        cuts.sort_unstable();
        cuts.dedup();
        for pair in cuts.windows(2) {
            let within = |f: &&Range<usize>| f.start <= pair[0] && pair[0] < f.end.max(f.start + 1);
            let is_fault = faults.iter().any(|f| within(&f));
            let format = format(font.clone(), colours[usize::from(is_comment)], is_fault);
            job.append(&text[pair[0]..pair[1]], 0.0, format);
        }
    }
    job
}

fn format(font: FontId, colour: Color32, is_fault: bool) -> TextFormat {
    TextFormat {
        underline: if is_fault {
            Stroke::new(1.5, Color32::from_rgb(255, 90, 80))
        } else {
            Stroke::NONE
        },
        ..TextFormat::simple(font, colour)
    }
}

/// The text in runs of comment and of what is none.
fn runs(text: &str) -> Vec<(Range<usize>, bool)> {
    let mut runs = Vec::new();
    let mut start = 0;
    let mut in_text = false;
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &text[at..];
        if in_text {
            at += if rest.starts_with("\\\"") { 2 } else { 1 };
            in_text = !rest.starts_with('"');
        } else if rest.starts_with('"') {
            in_text = true;
            at += 1;
        } else if rest.starts_with("//") || rest.starts_with("/*") {
            let end = if rest.starts_with("//") {
                rest.find('\n').unwrap_or(rest.len())
            } else {
                rest.find("*/").map_or(rest.len(), |close| close + 2)
            };
            runs.push((start..at, false));
            runs.push((at..at + end, true));
            at += end;
            start = at;
        } else {
            at += 1;
        }
        // Never in the middle of a character.
        while at < bytes.len() && !text.is_char_boundary(at) {
            at += 1;
        }
    }
    runs.push((start..text.len(), false));
    runs.retain(|(range, _)| !range.is_empty());
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn comments_are_told_from_text_that_looks_like_them() {
        let text = "a: \"// no\", // yes é\nb: 1, /* and\nthis */ c";
        let comments: Vec<&str> = runs(text)
            .into_iter()
            .filter(|(_, is_comment)| *is_comment)
            .map(|(range, _)| &text[range])
            .collect();
        assert_eq!(comments, ["// yes é", "/* and\nthis */"]);
    }

    proptest! {
        #[test]
        fn runs_are_the_whole_text(text in "[a\"/*\\\\\né ]{0,40}") {
            let joined: String = runs(&text).into_iter().map(|(range, _)| text[range].to_owned()).collect();
            prop_assert_eq!(joined, text);
        }
    }
}
