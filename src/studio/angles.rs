//! Angles and factors as rows of a page.

use super::curve::{self, Curve};
use super::form::{Change, Row, called, drag};
use super::parts::{Parts, usual_step};
use crate::species::fields::{self, Field, Holds, Limits};
use eframe::egui::{self, RichText, Ui};

impl Row<'_, '_> {
    /// An angle or a factor: a number, a curve, or both with a step and chance.
    pub(super) fn parts(&mut self, ui: &mut Ui, label: egui::Id, limits: Limits, is_angle: bool) {
        let Some(mut parts) = self.shown().as_ref().and_then(Parts::of) else {
            return self.raw_value(ui, Some(label));
        };
        let before = parts.clone();
        let first = self.changes.len();
        let usual = usual_step(self.field);
        let unsaid = if parts.in_brackets { usual } else { 0.0 };
        let full = self.name();
        ui.vertical(|ui| {
            ui.horizontal(|ui| {
                if let Curve::Flat(value) = &mut parts.at {
                    let response = drag(ui, value, limits).labelled_by(label);
                    self.rest(&response);
                }
                let mut varies = matches!(parts.at, Curve::Points(_));
                let toggle = ui.toggle_value(&mut varies, "curve");
                toggle.widget_info(|| {
                    let what = format!("{full} as a curve");
                    egui::WidgetInfo::selected(egui::Role::Button, true, varies, what)
                });
                let toggle = toggle.on_hover_text("By position on the parent");
                if toggle.clicked() {
                    self.changes.push(Change::Rest);
                    parts.at = match &parts.at {
                        Curve::Flat(value) => Curve::Points(vec![[0.0, *value], [1.0, *value]]),
                        Curve::Points(points) => Curve::Flat(points[0][1]),
                    };
                }
            });
            if let Curve::Points(_) = &parts.at {
                let (_, response) = curve::ui(ui, &full, &mut parts.at, limits);
                self.rest(&response);
            }
            ui.horizontal(|ui| {
                if is_angle {
                    self.part(ui, "step", (&mut parts.step, unsaid), limits);
                }
                let vary = if is_angle {
                    fields::ANGLE.field("vary")
                } else {
                    fields::FACTOR_PARTS.field("vary")
                };
                if let Some(Field {
                    holds: Holds::Number(limits),
                    ..
                }) = vary
                {
                    self.part(ui, "vary", (&mut parts.vary, 0.0), *limits);
                }
            });
        });
        if parts != before {
            // What ends the gesture comes behind what it has done.
            let ends = self.changes.split_off(first);
            self.set(parts.text_with(usual));
            self.changes.extend(ends);
        }
    }

    /// A part of an angle or factor, and what it is where it is left out.
    fn part(
        &mut self,
        ui: &mut Ui,
        what: &str,
        (value, unsaid): (&mut Option<f64>, f64),
        limits: Limits,
    ) {
        let label = ui.label(RichText::new(what).weak());
        let label = called(label, &format!("{what} of {}", self.name()));
        let mut number = value.unwrap_or(unsaid);
        let widget = egui::DragValue::new(&mut number)
            .range(limits.min..=limits.max)
            .speed(f64::from(limits.max - limits.min).min(100.0) / 300.0)
            .max_decimals(3);
        let response = ui.add(widget).labelled_by(label.id);
        let response = response.on_hover_text(match what {
            "step" => "Added once more for each link",
            _ => "Random part, either way",
        });
        if response.changed() {
            *value = Some(number);
        }
        self.rest(&response);
    }
}
