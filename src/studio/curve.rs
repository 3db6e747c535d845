//! A small editor of functions over 0..=1: points to drag, to add by a double click and to take away.

use crate::species::fields::Limits;
use crate::species::syntax::{Kind, Node};
use eframe::egui::{self, Color32, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};

/// A function as a script writes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Curve {
    /// The same everywhere.
    Flat(f64),
    /// Places and values, places rising.
    Points(Vec<[f64; 2]>),
}

impl Curve {
    /// Reads a number or a list of pairs.
    pub(super) fn of(node: &Node) -> Option<Self> {
        match &node.kind {
            Kind::Number(number) => number.parse().ok().map(Self::Flat),
            Kind::List(items) => {
                let points: Option<Vec<[f64; 2]>> = items.iter().map(pair).collect();
                points.filter(|p| !p.is_empty()).map(Self::Points)
            }
            _ => None,
        }
    }

    /// As a script writes it.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Flat(value) => number(*value),
            Self::Points(points) => {
                let pair = |[x, y]: &[f64; 2]| format!("({}, {})", number(*x), number(*y));
                format!(
                    "[{}]",
                    points.iter().map(pair).collect::<Vec<_>>().join(", ")
                )
            }
        }
    }

    /// The value at a place.
    pub(super) fn at(&self, x: f64) -> f64 {
        let points = match self {
            Self::Flat(value) => return *value,
            Self::Points(points) => points,
        };
        let after = points.partition_point(|p| p[0] <= x);
        match (
            after.checked_sub(1).and_then(|before| points.get(before)),
            points.get(after),
        ) {
            (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * (x - x0) / (x1 - x0),
            (Some([_, y]), None) | (None, Some([_, y])) => *y,
            (None, None) => 0.0,
        }
    }

    /// Smallest and largest value.
    pub(super) fn range(&self) -> (f64, f64) {
        let values: Vec<f64> = match self {
            Self::Flat(value) => vec![*value],
            Self::Points(points) => points.iter().map(|p| p[1]).collect(),
        };
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (low, high)
    }
}

fn pair(node: &Node) -> Option<[f64; 2]> {
    let Kind::Tuple { items, .. } = &node.kind else {
        return None;
    };
    let [Kind::Number(x), Kind::Number(y)] = [&items.first()?.kind, &items.get(1)?.kind] else {
        return None;
    };
    Some([x.parse().ok()?, y.parse().ok()?])
}

/// A number in few digits.
pub(super) fn number(value: f64) -> String {
    let text = if value.abs() < 0.01 {
        format!("{value:.6}")
    } else {
        format!("{value:.4}")
    };
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if matches!(text, "-0" | "") {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

/// Places of a curve are this far apart at least.
pub(super) const APART: f64 = 0.005;

/// Points within this many points of the screen are taken hold of.
const REACH: f32 = 9.0;

/// Draws a curve and lets it be changed; true if it was.
pub(super) fn ui(ui: &mut Ui, label: &str, curve: &mut Curve, limits: Limits) -> (bool, Response) {
    let size = vec2(ui.available_width().clamp(80.0, 260.0), 74.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Canvas, true, format!("Curve of {label}"))
    });
    let points = match &*curve {
        Curve::Flat(value) => vec![[0.0, *value], [1.0, *value]],
        Curve::Points(points) => points.clone(),
    };
    let (low, high) = curve.range();
    let spare = ((high - low) * 0.15).max(high.abs().max(1.0) * 0.1);
    let floor = if low >= 0.0 {
        (low - spare).max(0.0)
    } else {
        low - spare
    };
    let frame = Frame {
        rect: rect.shrink2(vec2(6.0, 8.0)),
        low: floor,
        high: high + spare,
    };
    let held_id = response.id.with("held");
    let mut points = points;
    let mut changed = false;
    if response.double_clicked() {
        if let Some(at) = response.interact_pointer_pos() {
            let [x, y] = frame.value(at);
            // Positions rise.
            if points.iter().all(|p| (p[0] - x).abs() >= APART) {
                let index = points.partition_point(|p| p[0] < x);
                points.insert(index, [x, y]);
                changed = true;
            }
        }
    } else if response.secondary_clicked() && points.len() > 1 {
        let hit = response
            .interact_pointer_pos()
            .and_then(|at| frame.nearest(&points, at));
        if let Some(index) = hit {
            points.remove(index);
            changed = true;
        }
    }
    if response.drag_started() {
        let hit = response
            .interact_pointer_pos()
            .and_then(|at| frame.nearest(&points, at));
        ui.data_mut(|data| data.insert_temp(held_id, hit));
    }
    if response.dragged()
        && let Some(at) = response.interact_pointer_pos()
        && let Some(index) = ui
            .data(|data| data.get_temp::<Option<usize>>(held_id))
            .flatten()
        && index < points.len()
    {
        let [x, y] = frame.value(at);
        let before = index.checked_sub(1).map_or(0.0, |i| points[i][0] + APART);
        let after = points.get(index + 1).map_or(1.0, |p| p[0] - APART);
        let y = y.clamp(f64::from(limits.min), f64::from(limits.max));
        points[index] = [x.clamp(before.min(after), after.max(before)), y];
        changed = true;
    }
    paint(ui, &frame, &points, response.hovered());
    if changed {
        for point in &mut points {
            *point = point.map(|part| (part * 1000.0).round() / 1000.0);
            point[1] = point[1].clamp(f64::from(limits.min), f64::from(limits.max));
        }
        *curve = Curve::Points(points);
    }
    let hint = "Drag a point; double-click adds one, right-click takes one away.";
    (changed, response.on_hover_text(hint))
}

/// Where values stand on the screen.
struct Frame {
    rect: Rect,
    low: f64,
    high: f64,
}

impl Frame {
    #[expect(clippy::cast_possible_truncation, reason = "places on a screen")]
    fn place(&self, [x, y]: [f64; 2]) -> Pos2 {
        let up = ((y - self.low) / (self.high - self.low)) as f32;
        pos2(
            self.rect.left() + x as f32 * self.rect.width(),
            self.rect.bottom() - up * self.rect.height(),
        )
    }

    fn value(&self, at: Pos2) -> [f64; 2] {
        let x = f64::from((at.x - self.rect.left()) / self.rect.width());
        let up = f64::from((self.rect.bottom() - at.y) / self.rect.height());
        [x.clamp(0.0, 1.0), self.low + up * (self.high - self.low)]
    }

    fn nearest(&self, points: &[[f64; 2]], at: Pos2) -> Option<usize> {
        let distance = |p: &[f64; 2]| self.place(*p).distance(at);
        let near = points.iter().enumerate().map(|(i, p)| (i, distance(p)));
        let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (nearest.1 <= REACH).then_some(nearest.0)
    }
}

fn paint(ui: &Ui, frame: &Frame, points: &[[f64; 2]], hovered: bool) {
    let visuals = ui.visuals();
    let painter = ui.painter();
    let outer = frame.rect.expand2(vec2(6.0, 8.0));
    painter.rect_filled(outer, 3.0, visuals.extreme_bg_color);
    let weak = visuals.weak_text_color();
    let zero = frame.place([0.0, 0.0]).y;
    if frame.rect.y_range().contains(zero) {
        painter.hline(frame.rect.x_range(), zero, Stroke::new(0.5, weak));
    }
    let mut line: Vec<Pos2> = points.iter().map(|p| frame.place(*p)).collect();
    // Beyond the first and the last point the curve goes on level.
    if let (Some(first), Some(last)) = (line.first().copied(), line.last().copied()) {
        line.insert(0, pos2(frame.rect.left(), first.y));
        line.push(pos2(frame.rect.right(), last.y));
    }
    let colour = visuals.hyperlink_color;
    painter.line(line, Stroke::new(1.5, colour));
    let radius = if hovered { 4.0 } else { 3.0 };
    for point in points {
        painter.circle(
            frame.place(*point),
            radius,
            colour,
            Stroke::new(1.0, Color32::WHITE),
        );
    }
    for (value, align) in [
        (frame.high, egui::Align2::LEFT_TOP),
        (frame.low, egui::Align2::LEFT_BOTTOM),
    ] {
        let corner = align.pos_in_rect(&outer.shrink(2.0));
        let font = egui::FontId::proportional(9.0);
        painter.text(
            corner,
            align,
            number((value * 100.0).round() / 100.0),
            font,
            weak,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::species::syntax;

    #[test]
    fn curves_are_read_and_written_as_scripts_have_them() {
        for text in ["0.5", "[(0, 1), (1, 0.15)]", "[(0.5, -20)]"] {
            let node = syntax::parse(text).0.unwrap();
            assert_eq!(Curve::of(&node).unwrap().text(), text);
        }
        for text in ["\"x\"", "[]", "[1, 2]", "[(0, \"x\")]"] {
            assert_eq!(Curve::of(&syntax::parse(text).0.unwrap()), None, "{text}");
        }
        let curve = Curve::Points(vec![[0.2, 1.0], [0.6, 3.0]]);
        let values = [0.0, 0.2, 0.4, 0.6, 1.0].map(|x| curve.at(x));
        assert_eq!(values, [1.0, 1.0, 2.0, 3.0, 3.0]);
        assert_eq!(
            ["0", "1.25", "-3"],
            [number(-0.0), number(1.25), number(-3.0)]
        );
    }
}
