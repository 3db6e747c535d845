//! The editor of a spline: its control points from the front and from the side, to be dragged, and as numbers.

use super::curve::number;
use super::document::Edit;
use super::form::Change;
use super::outline;
use super::parts::number_of;
use crate::math::Vec3;
use crate::species::fields::COORDINATE;
use crate::species::schema::Knots;
use crate::species::syntax::{Kind, Node};
use crate::spline::CatmullRom;
use eframe::egui::{self, Color32, Pos2, Rect, Response, RichText, Sense, Stroke, Ui, pos2, vec2};

/// Points within this many points of the screen are taken hold of.
const REACH: f32 = 10.0;

/// Height of the views, points.
const HEIGHT: f32 = 230.0;

/// More control points than this have no row of numbers each.
const ROWS: usize = 24;

/// Smallest step of a coordinate, parts of the height that is shown.
const FINEST: f64 = 400.0;

/// A spline as its page shows it.
#[derive(Debug)]
pub(super) struct Editor<'a> {
    /// Path of its struct.
    path: &'a str,
    pub(super) points: Vec<[f64; 3]>,
    pub(super) knots: Knots,
}

/// A change of the list of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Touch {
    Move(usize, [f64; 3]),
    Add(usize, [f64; 3]),
    Take(usize),
    Rest,
}

impl<'a> Editor<'a> {
    /// That of a spline's struct; `None` if its points are not in the script.
    pub(super) fn of(path: &'a str, node: &Node) -> Option<Self> {
        let list = outline::field(node, "points")?;
        let points: Option<Vec<[f64; 3]>> = outline::items(list).iter().map(triple).collect();
        let knots = match outline::field(node, "knots").and_then(outline::variant) {
            Some("Uniform") => Knots::Uniform,
            Some("Chordal") => Knots::Chordal,
            _ => Knots::Centripetal,
        };
        Some(Self {
            path,
            points: points.filter(|points| points.len() > 1)?,
            knots,
        })
    }

    /// Shows it and gives what was changed.
    pub(super) fn ui(&self, ui: &mut Ui, changes: &mut Vec<Change>) {
        let mut touches = Vec::new();
        let frame = self.frame(ui);
        ui.horizontal(|ui| {
            let width = ((ui.available_width() - 8.0) / 2.0).clamp(70.0, 240.0);
            for (name, axis) in [("front", 0), ("side", 2)] {
                self.view(ui, (name, axis), (width, frame), &mut touches);
            }
        });
        ui.label(
            RichText::new("Drag a point; a double click adds one, a right click takes one away.")
                .small()
                .weak(),
        );
        self.rows(ui, &mut touches);
        for touch in touches {
            changes.push(self.change(touch));
        }
    }

    /// The box of the points: its lower end, its upper one, and how far it reaches to each side. It stays as it is
    /// while a point is dragged.
    fn frame(&self, ui: &Ui) -> [f64; 3] {
        let heights = self.points.iter().map(|p| p[1]);
        let (low, high) = heights.fold((0.0_f64, 0.0_f64), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        let tall = (high - low).max(1e-6);
        let aside = self.points.iter().flat_map(|p| [p[0].abs(), p[2].abs()]);
        let aside = aside.fold(tall * 0.3, f64::max) * 1.15;
        let now = [low - tall * 0.06, high + tall * 0.1, aside];
        let id = egui::Id::unique(("spline frame", self.path));
        let held = ui.input(|i| i.pointer.any_down());
        ui.data_mut(|data| {
            let kept = data.get_temp::<[f64; 3]>(id);
            let frame = kept.filter(|_| held).unwrap_or(now);
            data.insert_temp(id, frame);
            frame
        })
    }

    fn view(
        &self,
        ui: &mut Ui,
        (name, axis): (&str, usize),
        (width, frame): (f32, [f64; 3]),
        touches: &mut Vec<Touch>,
    ) {
        let (rect, response) = ui.allocate_exact_size(vec2(width, HEIGHT), Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Canvas, true, format!("Spline from the {name}"))
        });
        let view = View { rect, axis, frame };
        let held_id = response.id.with("held");
        let at = response.interact_pointer_pos();
        let hit = at.and_then(|at| view.nearest(&self.points, at));
        if response.double_clicked()
            && let Some(at) = at
        {
            let (index, point) = self.between(&view, at);
            touches.extend([Touch::Add(index, point), Touch::Rest]);
        } else if response.secondary_clicked()
            && let Some(index) = hit
            && self.points.len() > 2
        {
            touches.extend([Touch::Take(index), Touch::Rest]);
        }
        if response.drag_started() {
            let press = ui.input(|i| i.pointer.press_origin());
            let hit = press.and_then(|at| view.nearest(&self.points, at));
            ui.data_mut(|data| data.insert_temp(held_id, hit));
        }
        let held = || ui.data(|data| data.get_temp::<Option<usize>>(held_id));
        if response.dragged()
            && let Some(at) = at
            && let Some(index) = held().flatten().filter(|index| *index < self.points.len())
        {
            let point = view.moved(self.points[index], at);
            if point != self.points[index] {
                touches.push(Touch::Move(index, point));
            }
        }
        if response.drag_stopped() {
            touches.push(Touch::Rest);
        }
        self.paint(ui, &view, name, &response);
    }

    /// Where a new point is put that is seen at a place: after which, and how deep.
    fn between(&self, view: &View, at: Pos2) -> (usize, [f64; 3]) {
        let place = |index: usize| view.place(self.points[index]);
        let away = |index: &usize| {
            let (a, b) = (place(*index), place(*index + 1));
            let along = b - a;
            let part = ((at - a).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
            ((a + along * part).distance(at), part)
        };
        let spans = 0..self.points.len() - 1;
        let nearest = spans.min_by(|a, b| away(a).0.total_cmp(&away(b).0));
        let index = nearest.unwrap_or(0);
        let last = self.points.len() - 1;
        // Beyond the tip the spline grows longer.
        if index + 1 == last && at.y < place(last).y - REACH {
            return (last + 1, view.moved(self.points[last], at));
        }
        let part = f64::from(away(&index).1);
        let (a, b) = (self.points[index], self.points[index + 1]);
        let middle = core::array::from_fn(|k| rounded(a[k] + (b[k] - a[k]) * part));
        (index + 1, view.moved(middle, at))
    }

    fn paint(&self, ui: &Ui, view: &View, name: &str, response: &Response) {
        let visuals = ui.visuals();
        let painter = ui.painter_at(view.rect);
        painter.rect_filled(view.rect, 3.0, visuals.extreme_bg_color);
        let weak = Stroke::new(0.5, visuals.weak_text_color());
        let foot = view.place([0.0; 3]);
        painter.vline(foot.x, view.rect.y_range(), weak);
        painter.hline(view.rect.x_range(), foot.y, weak);
        let colour = visuals.hyperlink_color;
        #[expect(clippy::cast_possible_truncation, reason = "places on a screen")]
        let control: Vec<Vec3> = self
            .points
            .iter()
            .map(|p| Vec3::from(p.map(|part| part as f32)))
            .collect();
        if let Some(curve) = CatmullRom::new(&control, self.knots) {
            let samples = curve.samples();
            let line = samples
                .iter()
                .map(|p| view.place(p.to_array().map(f64::from)));
            painter.line(line.collect(), Stroke::new(2.0, colour));
        }
        let under = response
            .hover_pos()
            .and_then(|at| view.nearest(&self.points, at));
        for (index, point) in self.points.iter().enumerate() {
            let radius = if under == Some(index) { 5.0 } else { 3.5 };
            painter.circle(
                view.place(*point),
                radius,
                colour,
                Stroke::new(1.0, Color32::WHITE),
            );
        }
        let font = egui::FontId::proportional(10.0);
        let corner = view.rect.left_top() + vec2(4.0, 3.0);
        painter.text(
            corner,
            egui::Align2::LEFT_TOP,
            name,
            font,
            visuals.weak_text_color(),
        );
    }

    /// The points as numbers.
    fn rows(&self, ui: &mut Ui, touches: &mut Vec<Touch>) {
        if self.points.len() > ROWS {
            ui.weak(format!("{} points", self.points.len()));
            return;
        }
        let tall = self
            .points
            .iter()
            .fold(1e-3_f64, |tall, p| tall.max(p[1].abs()));
        egui::Grid::new(("points", self.path))
            .num_columns(5)
            .show(ui, |ui| {
                for heading in ["", "x", "y", "z"] {
                    ui.label(RichText::new(heading).weak());
                }
                ui.end_row();
                for (index, point) in self.points.iter().enumerate() {
                    ui.weak(index.to_string());
                    let mut edited = *point;
                    let mut rests = false;
                    for (part, axis) in edited.iter_mut().zip(["x", "y", "z"]) {
                        let field = egui::DragValue::new(part)
                            .speed(tall / 400.0)
                            .range(COORDINATE.min..=COORDINATE.max)
                            .max_decimals(3);
                        let response = ui.add(field);
                        response.widget_info(|| {
                            let name = format!("{axis} of point {index}");
                            egui::WidgetInfo::labeled(egui::Role::SpinButton, true, name)
                        });
                        rests |= response.drag_stopped() || response.lost_focus();
                    }
                    if edited != *point {
                        touches.push(Touch::Move(index, edited));
                    }
                    if rests {
                        touches.push(Touch::Rest);
                    }
                    ui.horizontal(|ui| {
                        let add = small(ui, "+", &format!("Add a point after {index}"), true);
                        if add {
                            touches.extend([Touch::Add(index + 1, self.after(index)), Touch::Rest]);
                        }
                        let may = self.points.len() > 2;
                        if small(ui, "×", &format!("Take away point {index}"), may) {
                            touches.extend([Touch::Take(index), Touch::Rest]);
                        }
                    });
                    ui.end_row();
                }
            });
    }

    /// A point half way to the next one, or as far beyond the last as that is from the one before it.
    pub(super) fn after(&self, index: usize) -> [f64; 3] {
        let last = self.points.len() - 1;
        let a = self.points[index.min(last)];
        match self.points.get(index + 1) {
            Some(b) => core::array::from_fn(|k| rounded((a[k] + b[k]) / 2.0)),
            None => core::array::from_fn(|k| rounded(2.0 * a[k] - self.points[last - 1][k])),
        }
    }

    /// What makes the script say it.
    pub(super) fn change(&self, touch: Touch) -> Change {
        let list = format!("{}.points", self.path);
        let item = |index: usize| format!("{list}.{index}");
        match touch {
            Touch::Move(index, point) => {
                let path = item(index);
                let value = written(point);
                let gesture = Some(path.clone());
                Change::Edit(
                    format!("Move point {index}"),
                    gesture,
                    Edit::Set { path, value },
                )
            }
            Touch::Add(index, point) => {
                let item = written(point);
                let edit = Edit::Insert { list, index, item };
                Change::Edit("Add a point".to_owned(), None, edit)
            }
            Touch::Take(index) => Change::Edit(
                format!("Take away point {index}"),
                None,
                Edit::Remove(item(index)),
            ),
            Touch::Rest => Change::Rest,
        }
    }
}

fn small(ui: &mut Ui, label: &str, what: &str, enabled: bool) -> bool {
    let button = ui.add_enabled(enabled, egui::Button::new(label).small().frame(false));
    let button = button.on_hover_text(what);
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, what));
    button.clicked()
}

fn triple(node: &Node) -> Option<[f64; 3]> {
    let Kind::Tuple { items, .. } = &node.kind else {
        return None;
    };
    let [x, y, z] = items.as_slice() else {
        return None;
    };
    Some([number_of(x)?, number_of(y)?, number_of(z)?])
}

/// A point as a script writes it.
pub(super) fn written(point: [f64; 3]) -> String {
    format!("({})", point.map(number).join(", "))
}

/// A coordinate in few digits.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}

/// One view of a spline: +Y is up, and x or z to the right.
struct View {
    rect: Rect,
    /// Which coordinate is to the right.
    axis: usize,
    frame: [f64; 3],
}

impl View {
    /// Pixels of one unit.
    fn scale(&self) -> f64 {
        let [low, high, aside] = self.frame;
        let up = f64::from(self.rect.height()) / (high - low);
        up.min(f64::from(self.rect.width()) / (2.0 * aside))
    }

    #[expect(clippy::cast_possible_truncation, reason = "places on a screen")]
    fn place(&self, point: [f64; 3]) -> Pos2 {
        let scale = self.scale();
        let x = f64::from(self.rect.center().x) + point[self.axis] * scale;
        let y = f64::from(self.rect.bottom()) - (point[1] - self.frame[0]) * scale;
        pos2(x as f32, y as f32)
    }

    /// A point moved to where it is seen at a place; its depth stays.
    fn moved(&self, mut point: [f64; 3], at: Pos2) -> [f64; 3] {
        let scale = self.scale();
        let finest = (self.frame[1] - self.frame[0]) / FINEST;
        let step = libm::pow(10.0, libm::log10(finest).floor());
        let snapped = |value: f64| rounded((value / step).round() * step);
        point[self.axis] = snapped(f64::from(at.x - self.rect.center().x) / scale);
        point[1] = snapped(f64::from(self.rect.bottom() - at.y) / scale + self.frame[0]);
        point
    }

    fn nearest(&self, points: &[[f64; 3]], at: Pos2) -> Option<usize> {
        let away = |p: &[f64; 3]| self.place(*p).distance(at);
        let all = points.iter().enumerate().map(|(i, p)| (i, away(p)));
        let nearest = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (nearest.1 <= REACH).then_some(nearest.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::syntax;

    fn editor(text: &str) -> Option<Editor<'static>> {
        Editor::of("splines.0", &syntax::parse(text).0.unwrap())
    }

    fn view(axis: usize) -> View {
        View {
            rect: Rect::from_min_size(pos2(10.0, 20.0), vec2(200.0, 230.0)),
            axis,
            frame: [-0.2, 2.2, 0.7],
        }
    }

    #[test]
    fn points_go_to_where_they_are_dragged_and_keep_their_depth() {
        let point = [0.25, 1.5, -0.3];
        for axis in [0, 2] {
            let view = view(axis);
            let at = view.place([-0.1, 0.7, -0.1]);
            let moved = view.moved(point, at);
            assert_eq!(moved[axis], -0.1);
            assert_eq!((moved[1], moved[2 - axis]), (0.7, point[2 - axis]));
            assert_eq!(view.nearest(&[point, moved], at), Some(1));
        }
    }

    #[test]
    fn new_points_stand_between_their_neighbours_or_lengthen_the_tip() {
        let editor = editor("(name: \"a\", points: [(0, 0, 0), (0, 1, 0.4), (0, 2, 0)])").unwrap();
        let view = view(0);
        let (index, point) = editor.between(&view, view.place([0.1, 0.5, 0.0]));
        assert_eq!((index, point), (1, [0.1, 0.5, 0.2]));
        let beyond = view.place([0.0, 2.15, 0.0]);
        assert_eq!(editor.between(&view, beyond).0, 3);
        assert_eq!(editor.after(0), [0.0, 0.5, 0.2]);
        assert_eq!(editor.after(2), [0.0, 3.0, -0.4]);
    }

    #[test]
    fn only_points_in_the_script_are_edited() {
        assert!(editor("(name: \"a\", file: \"a.txt\")").is_none());
        assert!(editor("(name: \"a\", points: [(0, 0, 0)])").is_none());
        assert!(editor("(name: \"a\", points: [(0, 0), (1, 1)])").is_none());
    }
}
