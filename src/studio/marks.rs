//! What is drawn over the picture of a tree: outlines, the lines of a level, handles.

use super::picking::{Items, Point};
use crate::math::Vec3;
use crate::viewer::projection::Projection;
use eframe::egui::epaint::PathShape;
use eframe::egui::{Color32, Painter, Pos2, Shape, Stroke, Ui, vec2};

/// Colour of what is selected: that of selections in a dark window, since it stands on the picture in any theme.
pub(super) const SELECTED: Color32 = Color32::from_rgb(125, 200, 255);

/// Colour of what is under the pointer.
pub(super) const HOVERED: Color32 = Color32::from_rgb(255, 236, 170);

/// Colour of outlines.
const DARK: Color32 = Color32::from_rgb(16, 34, 52);

/// Most lines of a level.
const LINES: usize = 4000;

/// How much of the picture lines leave to be seen: of a few, and of as many as there can be.
const ALPHA: [f32; 2] = [0.9, 0.3];

/// Draws a polyline of the world, so far as it is before the camera.
pub(super) fn line(painter: &Painter, view: &Projection, points: &[Vec3], stroke: Stroke) {
    let mut seen = Vec::with_capacity(points.len());
    for point in points.iter().map(|p| view.place(*p)).chain([None]) {
        match point {
            Some(at) => seen.push(at),
            None if seen.len() > 1 => {
                painter.add(Shape::line(std::mem::take(&mut seen), stroke));
            }
            None => seen.clear(),
        }
    }
}

/// Draws the axes of all nodes of a level, evenly sampled, and that of one more strongly.
pub(super) fn level(
    ui: &Ui,
    view: &Projection,
    items: &Items,
    (level, bearer): (usize, Option<usize>),
) {
    let painter = ui.painter_at(view.rect);
    let of_level = || items.all().iter().filter(|item| item.level == level);
    let count = of_level().count();
    let step = count.div_ceil(LINES).max(1);
    // Many lines cover the tree as a few do if each is fainter.
    #[expect(clippy::cast_precision_loss, reason = "a count of lines")]
    let crowd = ((count / step) as f32 / 600.0).min(1.0);
    let alpha = ALPHA[0] + (ALPHA[1] - ALPHA[0]) * crowd;
    let colour = SELECTED.gamma_multiply(alpha);
    for item in of_level().step_by(step) {
        let axis = items.axis(item);
        if let [leaf] = axis {
            if let Some(at) = view.seen(leaf.place) {
                painter.circle_filled(at, 1.6, colour);
            }
            continue;
        }
        let points: Vec<Vec3> = axis.iter().map(|p| p.place).collect();
        line(&painter, view, &points, Stroke::new(1.25, colour));
    }
    if let Some(item) = bearer.and_then(|bearer| items.all().get(bearer)) {
        let points: Vec<Vec3> = items.axis(item).iter().map(|p| p.place).collect();
        line(&painter, view, &points, Stroke::new(2.0, SELECTED));
    }
}

/// Draws the outline of a tube, or of a ball if that has one point.
pub(super) fn outline(ui: &Ui, view: &Projection, axis: &[Point]) {
    let painter = ui.painter_at(view.rect);
    let stroke = Stroke::new(1.5, HOVERED);
    let seen = |point: &Point| {
        let wide = view.metres_a_point(point.place).max(1e-6);
        Some((view.place(point.place)?, point.radius / wide + 1.5))
    };
    let points: Option<Vec<(Pos2, f32)>> = axis.iter().map(seen).collect();
    match points.as_deref() {
        Some([(at, radius)]) => {
            painter.circle_stroke(*at, radius.max(3.0), stroke);
        }
        Some(points) if points.len() > 1 => {
            painter.add(PathShape::closed_line(sides(points), stroke));
        }
        _ => {}
    }
}

/// Both sides of a tube as it is seen, from the base to the tip and back.
fn sides(points: &[(Pos2, f32)]) -> Vec<Pos2> {
    let last = points.len() - 1;
    let side = |index: usize, sign: f32| {
        let (at, radius) = points[index];
        let before = points[index.saturating_sub(1)].0;
        let after = points[(index + 1).min(last)].0;
        let along = (after - before).normalized();
        at + vec2(-along.y, along.x) * (radius * sign)
    };
    let there = (0..=last).map(|index| side(index, 1.0));
    there
        .chain((0..=last).rev().map(|index| side(index, -1.0)))
        .collect()
}

/// Shapes of handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shaped {
    Round,
    Diamond,
}

/// Draws a handle, larger where a hand is on it.
pub(super) fn handle(painter: &Painter, at: Pos2, shaped: Shaped, is_active: bool) {
    let fill = if is_active { Color32::WHITE } else { SELECTED };
    let radius = if is_active { 6.5 } else { 5.0 };
    let stroke = Stroke::new(1.5, DARK);
    match shaped {
        Shaped::Round => {
            painter.circle(at, radius, fill, stroke);
        }
        Shaped::Diamond => {
            let reach = radius + 1.0;
            let corners = [
                vec2(0.0, -reach),
                vec2(reach, 0.0),
                vec2(0.0, reach),
                vec2(-reach, 0.0),
            ];
            let corners = corners.map(|corner| at + corner).to_vec();
            painter.add(Shape::convex_polygon(corners, fill, stroke));
        }
    }
}

/// Draws a polyline with dark sides, to be seen on the sky, on leaves and on handles.
pub(super) fn cased(painter: &Painter, view: &Projection, points: &[Vec3], colour: Color32) {
    line(
        painter,
        view,
        points,
        Stroke::new(4.0, DARK.gamma_multiply(0.6)),
    );
    line(painter, view, points, Stroke::new(2.0, colour));
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::pos2;

    #[test]
    fn an_outline_goes_up_on_one_side_and_down_on_the_other() {
        let points = [(pos2(10.0, 30.0), 4.0), (pos2(10.0, 10.0), 2.0)];
        let expected = [(14.0, 30.0), (12.0, 10.0), (8.0, 10.0), (6.0, 30.0)];
        assert_eq!(sides(&points), expected.map(|(x, y)| pos2(x, y)));
    }
}
