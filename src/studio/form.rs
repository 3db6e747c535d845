//! A page: the fields of a struct as rows, made from its table, each with its unit, range and meaning.

use super::curve::{self, Curve};
use super::document::Edit;
use super::drawings::{Drawings, Wish};
use super::nearby;
use super::outline;
use super::parts::number_of;
use crate::species::fault::Fault;
use crate::species::fields::{self, Absent, Field, Holds, Limits, Table};
use crate::species::syntax::{self, Kind, Node};
use eframe::egui::{self, Color32, RichText, Ui};
use std::cell::RefCell;

/// Something that the user has done on a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// An edit with its name, and the gesture that it is a part of.
    Edit(String, Option<String>, Edit),
    /// The end of a gesture.
    Rest,
}

/// What a page is made from.
#[derive(Clone, Copy)]
pub(super) struct Sheet<'a> {
    /// The script's text.
    pub(super) source: &'a str,
    /// What is at fault in it.
    pub(super) faults: &'a [Fault],
    /// True for the trunk's page: its place on a parent means nothing.
    pub(super) is_trunk: bool,
    /// Drawings of what a field does.
    pub(super) drawings: &'a RefCell<Drawings>,
    /// The struct within the page that the fields are of.
    pub(super) within: Option<&'a str>,
}

/// Fields of the whole script that have pages of their own, or that nobody should change.
const ELSEWHERE: [&str; 5] = ["format", "splines", "leaves", "levels", "variations"];

/// Those that have a page once they are there.
const SOMETIMES: [&str; 3] = ["stems", "bark", "lod"];

/// Shows the fields of `node`, which stands at `path` and has those of `table`.
pub(super) fn page(
    ui: &mut Ui,
    sheet: Sheet<'_>,
    (node, table): (&Node, &'static Table),
    path: &str,
    changes: &mut Vec<Change>,
) {
    for field in table.fields() {
        let is_page = SOMETIMES.contains(&field.name) && outline::field(node, field.name).is_some();
        let elsewhere = table.name == "Species" && (is_page || ELSEWHERE.contains(&field.name));
        let placeless = sheet.is_trunk && fields::NOT_FOR_TRUNK.contains(&field.name);
        if elsewhere || placeless {
            continue;
        }
        let at = if path.is_empty() {
            field.name.to_owned()
        } else {
            format!("{path}.{}", field.name)
        };
        let value = outline::field(node, field.name);
        let mut row = Row {
            sheet,
            field,
            path: &at,
            value,
            changes,
        };
        row.ui(ui);
        for fault in sheet.faults.iter().filter(|f| belongs(f, &at)) {
            let colour = ui.visuals().error_fg_color;
            ui.label(RichText::new(&fault.message).small().color(colour));
        }
    }
}

/// True if a fault is told at a field of our path: items are `[1]` there and `.1` here.
fn belongs(fault: &Fault, path: &str) -> bool {
    let theirs = fault.path.replace('[', ".").replace(']', "");
    theirs == path
        || theirs
            .strip_prefix(path)
            .is_some_and(|rest| rest.starts_with('.'))
}

/// A field's name as it is read: `radius_of_parent` is "radius of parent".
#[must_use]
pub fn readable(name: &str) -> String {
    let name = name.strip_suffix("_m").unwrap_or(name);
    name.strip_suffix("_deg").unwrap_or(name).replace('_', " ")
}

/// What hovering a field tells.
#[must_use]
pub fn meaning(field: &Field) -> String {
    let range = |l: Limits| {
        let unit = if l.unit.is_empty() {
            String::new()
        } else {
            format!(" {}", l.unit)
        };
        format!("{} to {}{unit}", l.min, l.max)
    };
    let range = match field.holds {
        Holds::Number(l) => range(l),
        Holds::Angle(l) => format!("{}, by position, link and chance", range(l)),
        Holds::Factor(l) => format!("{}, by position and chance", range(l)),
        Holds::Curve(l) => format!("{}, by position", range(l)),
        Holds::Whole(low, u64::MAX) => format!("a whole number from {low}"),
        Holds::Whole(low, high) => format!("a whole number, {low} to {high}"),
        Holds::OneOf(names) => names.join(", "),
        Holds::Text => "text".to_owned(),
        Holds::Colour => "a colour".to_owned(),
        Holds::Path => "a file beside the script".to_owned(),
        Holds::Other(words) => words.to_owned(),
    };
    let absent = match field.absent {
        Absent::Means(value) => format!("\nLeft out: {value}"),
        Absent::Fault | Absent::Special => String::new(),
    };
    format!(
        "{}\n{range}{absent}\nIn the script: {}",
        field.doc, field.name
    )
}

/// A field's row.
pub(super) struct Row<'a, 'c> {
    sheet: Sheet<'a>,
    pub(super) field: &'static Field,
    path: &'a str,
    value: Option<&'a Node>,
    pub(super) changes: &'c mut Vec<Change>,
}

/// Width of names.
const NAMES: f32 = 118.0;

impl Row<'_, '_> {
    /// The field's name as no other of the page has it.
    pub(super) fn name(&self) -> String {
        let name = readable(self.field.name);
        match self.sheet.within {
            Some(within) => format!("{name} of {within}"),
            None => name,
        }
    }

    fn ui(&mut self, ui: &mut Ui) {
        if let Holds::Other(_) = self.field.holds
            && let Some(value) = self.value
            && let Some(table) = outline::table_of(self.field.name, value)
        {
            return self.nested(ui, value, table);
        }
        ui.horizontal(|ui| {
            let mut name = RichText::new(readable(self.field.name));
            if self.value.is_none() {
                name = name.weak();
            }
            let size = egui::vec2(NAMES, ui.spacing().interact_size.y);
            let left = egui::Layout::left_to_right(egui::Align::Center);
            let label = ui
                .allocate_ui_with_layout(size, left, |ui| {
                    ui.set_min_width(NAMES);
                    let label = called(ui.label(name), &self.name());
                    label.on_hover_ui(|ui| self.told(ui))
                })
                .inner;
            self.widget(ui, label.id);
            if self.value.is_some() && self.field.absent != Absent::Fault {
                let what = format!("Leave out {}", self.name());
                let button = ui.add(egui::Button::new("×").small().frame(false));
                let button = button.on_hover_text(&what);
                button.widget_info(|| {
                    egui::WidgetInfo::labeled(egui::Role::Button, true, what.clone())
                });
                if button.clicked() {
                    self.edit(what, None, Edit::Remove(self.path.to_owned()));
                }
            }
        });
    }

    /// What hovering the name tells and shows.
    fn told(&self, ui: &mut Ui) {
        ui.label(meaning(self.field));
        let shown = self.shown();
        let values = nearby::values(self.field, shown.as_ref());
        if !values.is_empty() {
            let path = self.path.to_owned();
            ui.add_space(4.0);
            let mut drawings = self.sheet.drawings.borrow_mut();
            drawings.ui(ui, &Wish { path, values });
        }
    }

    /// A struct within the struct.
    fn nested(&mut self, ui: &mut Ui, value: &Node, table: &'static Table) {
        let title = match outline::variant(value) {
            Some(variant) => format!("{}: {variant}", readable(self.field.name)),
            None => readable(self.field.name),
        };
        let (sheet, path) = (self.sheet, self.path.to_owned());
        let name = self.name();
        egui::CollapsingHeader::new(title)
            .id_salt(&path)
            .show(ui, |ui| {
                ui.label(RichText::new(self.field.doc).small().weak());
                let sheet = Sheet {
                    is_trunk: false,
                    within: Some(&name),
                    ..sheet
                };
                page(ui, sheet, (value, table), &path, self.changes);
                if self.field.absent == Absent::Fault {
                    return;
                }
                let what = format!("Leave out {name}");
                if button(ui, "Leave out", &what) {
                    self.edit(what, None, Edit::Remove(path.clone()));
                }
            });
    }

    fn widget(&mut self, ui: &mut Ui, label: egui::Id) {
        match self.field.holds {
            Holds::Number(limits) => self.number(ui, label, limits),
            Holds::Whole(low, high) => self.whole(ui, label, (low, high)),
            Holds::Angle(limits) => self.parts(ui, label, limits, true),
            Holds::Factor(limits) => self.parts(ui, label, limits, false),
            Holds::Curve(limits) => self.curve(ui, label, limits),
            Holds::Text | Holds::Path => self.text(ui, label),
            Holds::Colour => self.colour(ui, label),
            Holds::OneOf(names) => self.choice(ui, label, names),
            Holds::Other(_) => self.raw(ui, label),
        }
    }

    fn edit(&mut self, name: String, gesture: Option<String>, edit: Edit) {
        self.changes.push(Change::Edit(name, gesture, edit));
    }

    pub(super) fn set(&mut self, value: String) {
        let path = self.path.to_owned();
        let name = format!("Set {}", readable(self.field.name));
        self.edit(name, Some(path.clone()), Edit::Set { path, value });
    }

    /// Ends a gesture when a widget is let go of.
    pub(super) fn rest(&mut self, response: &egui::Response) {
        // A double click adds a point of a curve, a right click takes one away.
        let clicked = response.double_clicked() || response.secondary_clicked();
        if response.drag_stopped() || response.lost_focus() || clicked {
            self.changes.push(Change::Rest);
        }
    }

    /// The value as it stands, or as it is meant where it is left out.
    pub(super) fn shown(&self) -> Option<Node> {
        match (self.value, self.field.absent) {
            (Some(value), _) => Some(value.clone()),
            (None, Absent::Means(text)) => syntax::parse(text).0,
            (None, _) => None,
        }
    }

    fn number(&mut self, ui: &mut Ui, label: egui::Id, limits: Limits) {
        let Some(mut value) = self.shown().as_ref().and_then(number_of) else {
            return self.absent_number(ui, limits);
        };
        let response = drag(ui, &mut value, limits).labelled_by(label);
        if response.changed() {
            self.set(curve::number(value));
        }
        self.rest(&response);
    }

    /// A number that has no value of its own while it is left out.
    fn absent_number(&mut self, ui: &mut Ui, limits: Limits) {
        if self.value.is_some() {
            return self.raw_value(ui, None);
        }
        if button(ui, "set", &format!("Set {}", self.name())) {
            let usual = 1.0_f64.clamp(f64::from(limits.min), f64::from(limits.max));
            self.set(curve::number(usual));
            self.changes.push(Change::Rest);
        }
    }

    fn whole(&mut self, ui: &mut Ui, label: egui::Id, (low, high): (u64, u64)) {
        let shown = self.shown();
        let Some(mut value) = shown.as_ref().and_then(whole_of) else {
            if self.value.is_some() {
                return self.raw_value(ui, Some(label));
            }
            if button(ui, "set", &format!("Set {}", self.name())) {
                self.set(low.max(1).min(high).to_string());
                self.changes.push(Change::Rest);
            }
            return;
        };
        let lock = egui::Id::unique(("locked seed", self.path));
        let locked = ui.data(|data| data.get_temp(lock).unwrap_or(false));
        let field = egui::DragValue::new(&mut value)
            .range(low..=high)
            .speed(0.1);
        let response = ui.add_enabled(!locked, field).labelled_by(label);
        if response.changed() {
            self.set(value.to_string());
        }
        self.rest(&response);
        if self.field.name == "seed" {
            let mut locked = locked;
            let dice = ui.add_enabled(!locked, egui::Button::new("roll").small());
            let dice = dice.on_hover_text("Another seed");
            dice.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::Button, !locked, "Another seed")
            });
            let toggle = ui.toggle_value(&mut locked, "lock");
            toggle.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::Button, true, locked, "Lock the seed")
            });
            let toggle = toggle.on_hover_text("Keeps the seed from being rolled or dragged");
            if toggle.changed() {
                ui.data_mut(|data| data.insert_temp(lock, locked));
            }
            if dice.clicked() {
                self.set(another(value).to_string());
                self.changes.push(Change::Rest);
            }
        }
    }

    fn curve(&mut self, ui: &mut Ui, label: egui::Id, limits: Limits) {
        let Some(mut curve) = self.shown().as_ref().and_then(Curve::of) else {
            return self.raw_value(ui, Some(label));
        };
        let (changed, response) = curve::ui(ui, &self.name(), &mut curve, limits);
        if changed {
            self.set(curve.text());
        }
        self.rest(&response);
    }

    fn text(&mut self, ui: &mut Ui, label: egui::Id) {
        let shown = self.shown();
        let mut text = shown
            .as_ref()
            .and_then(outline::text)
            .unwrap_or("")
            .to_owned();
        let edit = egui::TextEdit::singleline(&mut text).desired_width(150.0);
        let response = ui.add(edit).labelled_by(label);
        if response.changed() {
            self.set(quoted(&text));
        }
        self.rest(&response);
    }

    fn colour(&mut self, ui: &mut Ui, label: egui::Id) {
        let shown = self.shown();
        let Some(mut rgb) = shown.as_ref().and_then(outline::text).and_then(rgb_of) else {
            return self.raw_value(ui, Some(label));
        };
        let response = ui.color_edit_button_srgb(&mut rgb).labelled_by(label);
        if response.clicked() {
            // Each time that it is opened is a gesture of its own.
            self.changes.push(Change::Rest);
        }
        if response.changed() {
            let [r, g, b] = rgb;
            self.set(format!("\"#{r:02x}{g:02x}{b:02x}\""));
        }
        let [r, g, b] = rgb;
        ui.label(
            RichText::new(format!("#{r:02x}{g:02x}{b:02x}"))
                .monospace()
                .weak(),
        );
    }

    fn choice(&mut self, ui: &mut Ui, label: egui::Id, names: &'static [&'static str]) {
        let shown = self.shown();
        let chosen = shown
            .as_ref()
            .and_then(outline::variant)
            .unwrap_or("")
            .to_owned();
        let mut picked = None;
        let combo = egui::ComboBox::from_id_salt(self.path)
            .selected_text(&chosen)
            .show_ui(ui, |ui| {
                for name in names {
                    if ui.selectable_label(*name == chosen, *name).clicked() {
                        picked = Some(*name);
                    }
                }
            });
        combo.response.labelled_by(label);
        if let Some(name) = picked.filter(|name| *name != chosen) {
            self.set(name.to_owned());
            self.changes.push(Change::Rest);
        }
    }

    /// What has no widget of its own: in the script's words; or a button that begins it.
    fn raw(&mut self, ui: &mut Ui, label: egui::Id) {
        let name = self.name();
        match (self.value, outline::beginning(self.field.name)) {
            (None, Some(beginning)) => {
                let what = format!("Add {name}");
                if button(ui, "add", &what) {
                    let path = self.path.to_owned();
                    let value = beginning.to_owned();
                    self.edit(what, None, Edit::Set { path, value });
                }
            }
            _ => self.raw_value(ui, Some(label)),
        }
    }

    /// A value in the script's own words, taken once it can be read.
    pub(super) fn raw_value(&mut self, ui: &mut Ui, label: Option<egui::Id>) {
        let source = self.sheet.source;
        let now = match (self.value, self.field.absent) {
            (Some(value), _) => source.get(value.span.clone()).unwrap_or("").to_owned(),
            (None, Absent::Means(text)) => text.to_owned(),
            (None, _) => String::new(),
        };
        let id = ui.scope_id().with(("words", self.path));
        let mut words = ui
            .data(|data| data.get_temp::<String>(id))
            .unwrap_or_else(|| now.clone());
        let readable = syntax::parse(&words);
        let sound = words.is_empty() || (readable.0.is_some() && readable.1.is_empty());
        let mut edit = egui::TextEdit::singleline(&mut words)
            .id(id)
            .font(egui::TextStyle::Monospace)
            .desired_width(ui.available_width().clamp(60.0, 220.0));
        if !sound {
            edit = edit.text_color(Color32::LIGHT_RED);
        }
        let mut response = ui.add(edit);
        if let Some(label) = label {
            response = response.labelled_by(label);
        }
        if response.changed() {
            ui.data_mut(|data| data.insert_temp(id, words.clone()));
        }
        if response.lost_focus() {
            ui.data_mut(|data| data.remove::<String>(id));
            if sound && words != now && !words.is_empty() {
                self.set(words);
                self.changes.push(Change::Rest);
            }
        }
    }
}

/// Gives a label the name that those hear who do not see what stands around it.
pub(super) fn called(label: egui::Response, name: &str) -> egui::Response {
    label.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, name));
    label
}

/// A small button with such a name; true if it was pressed.
fn button(ui: &mut Ui, label: &str, what: &str) -> bool {
    let button = ui.small_button(label);
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, what));
    button.clicked()
}

/// A number: a slider where the range is short, else a field to drag or to type in.
pub(super) fn drag(ui: &mut Ui, value: &mut f64, limits: Limits) -> egui::Response {
    let range = f64::from(limits.min)..=f64::from(limits.max);
    let unit = match limits.unit {
        "" => String::new(),
        "metres" => " m".to_owned(),
        "degrees" => "°".to_owned(),
        other if other.len() < 8 => format!(" {other}"),
        _ => String::new(),
    };
    if limits.max - limits.min <= 4.0 {
        ui.spacing_mut().slider_width = 90.0;
        return ui.add(egui::Slider::new(value, range).suffix(unit).max_decimals(4));
    }
    // No hand sets an angle to a thousandth of a degree; digits follow the speed.
    let finest = if limits.unit == "degrees" {
        0.1
    } else {
        0.0005
    };
    let speed = (value.abs() * 0.01).clamp(finest, 2.0);
    ui.add(
        egui::DragValue::new(value)
            .range(range)
            .speed(speed)
            .max_decimals(4)
            .suffix(unit),
    )
}

fn whole_of(node: &Node) -> Option<u64> {
    match &node.kind {
        Kind::Number(number) => number.parse().ok(),
        _ => None,
    }
}

/// Text as a script writes it.
#[must_use]
pub fn quoted(text: &str) -> String {
    let escaped = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{escaped}\"")
}

fn rgb_of(text: &str) -> Option<[u8; 3]> {
    let digits = text
        .strip_prefix('#')
        .filter(|d| d.len() == 6 && d.is_ascii())?;
    let part = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).ok();
    Some([part(0)?, part(2)?, part(4)?])
}

/// A seed that is not this one.
fn another(seed: u64) -> u64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let nanos = now.map_or(0, |d| u64::from(d.subsec_nanos()));
    let new = (nanos / 128).wrapping_mul(0x9e37_79b9) % 10_000;
    if new == seed { new + 1 } else { new }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_readable_and_every_meaning_has_its_range() {
        assert_eq!(readable("radius_of_parent"), "radius of parent");
        assert_eq!(readable("length_m"), "length");
        let told = meaning(fields::BRANCH.field("taper").unwrap());
        assert!(
            told.contains("0 to 10, by position") && told.contains("Left out: [(0, 1)"),
            "{told}"
        );
        for field in fields::TABLES.iter().flat_map(|t| t.fields()) {
            assert!(meaning(field).lines().count() >= 3, "{}", field.name);
        }
    }

    #[test]
    fn text_and_colours_survive_the_way_into_a_script() {
        let text = "a \"b\" \\ c";
        let node = syntax::parse(&quoted(text)).0.unwrap();
        assert_eq!(outline::text(&node), Some(text));
        assert_eq!(rgb_of("#0a1Bff"), Some([10, 27, 255]));
        assert_eq!(
            (rgb_of("#12345"), rgb_of("#12345é"), rgb_of("red")),
            (None, None, None)
        );
    }
}
