//! A person beside the tree, by whom one sees how large it is.

use super::projection::Projection;
use crate::math::{TAU, Vec3, float};
use eframe::egui::{Color32, Pos2, Shape, Stroke, Ui};

/// Height of the person, metres.
const HEIGHT: f32 = 1.75;

/// Below so many points of the screen a person is a speck, and is left out.
const LEAST: f32 = 6.0;

/// How far the person stands from the trunk toward the camera, metres: at about the tree's own distance, so that
/// both are seen at one scale.
const BEFORE: f32 = 0.6;

/// How far to the side of the trunk, metres.
const ASIDE: f32 = 1.3;

/// Colour of the figure: dark, without a part in the light of the scene.
const COLOUR: Color32 = Color32::from_rgb(38, 42, 50);

/// Corners of the head's outline.
const ROUND: u32 = 20;

/// The head: its middle and its half axes, metres.
const HEAD: ([f32; 2], [f32; 2]) = ([0.0, 1.635], [0.086, 0.115]);

/// Parts that stand in the middle: neck, chest, hips. Parts overlap a little, so that no seam is seen.
const MIDDLE: [&[[f32; 2]]; 3] = [
    &[[-0.052, 1.58], [0.052, 1.58], [0.07, 1.42], [-0.07, 1.42]],
    &[
        [-0.06, 1.485],
        [0.06, 1.485],
        [0.17, 1.45],
        [0.21, 1.4],
        [0.155, 1.02],
        [-0.155, 1.02],
        [-0.21, 1.4],
        [-0.17, 1.45],
    ],
    &[
        [-0.155, 1.06],
        [0.155, 1.06],
        [0.178, 0.9],
        [0.172, 0.82],
        [-0.172, 0.82],
        [-0.178, 0.9],
    ],
];

/// Parts that there are on both sides: thigh, shin, foot, upper and lower arm, hand.
const SIDES: [&[[f32; 2]]; 6] = [
    &[[0.175, 0.88], [0.004, 0.86], [0.03, 0.46], [0.142, 0.46]],
    &[[0.145, 0.5], [0.032, 0.5], [0.048, 0.04], [0.118, 0.04]],
    &[
        [0.046, 0.07],
        [0.118, 0.07],
        [0.172, 0.02],
        [0.168, 0.0],
        [0.046, 0.0],
    ],
    &[
        [0.15, 1.45],
        [0.205, 1.42],
        [0.232, 1.35],
        [0.262, 1.08],
        [0.198, 1.08],
    ],
    &[[0.2, 1.12], [0.261, 1.12], [0.272, 0.84], [0.226, 0.84]],
    &[
        [0.224, 0.88],
        [0.274, 0.88],
        [0.272, 0.76],
        [0.25, 0.73],
        [0.228, 0.77],
    ],
];

/// Where the person stands: before the tree as it is looked at, a little to the left.
fn stand(view: &Projection) -> Vec3 {
    let eye = view.camera.eye.with_y(0.0);
    let toward = eye.normalize_or(Vec3::Z);
    let [right, _] = view.camera.sides();
    toward * BEFORE - right * ASIDE
}

/// Convex outlines of the figure, metres from its feet to the right and up.
fn outlines() -> Vec<Vec<[f32; 2]>> {
    let ([x, y], [wide, high]) = HEAD;
    let head = (0..ROUND).map(|corner| {
        let (sine, cosine) = libm::sincosf(TAU * float(corner) / float(ROUND));
        [x + wide * cosine, y + high * sine]
    });
    let middle = MIDDLE.iter().map(|part| part.to_vec());
    let mirrored = |part: &&[[f32; 2]]| part.iter().map(|[x, y]| [-x, *y]).collect();
    let sides = SIDES.iter().map(|part| part.to_vec());
    let all = sides.chain(SIDES.iter().map(mirrored)).chain(middle);
    all.chain([head.collect()]).collect()
}

/// Where outlines in the upright plane that faces the camera are seen; `None` if a part is behind the camera.
fn seen(view: &Projection, feet: Vec3, outline: &[[f32; 2]]) -> Option<Vec<Pos2>> {
    let [right, _] = view.camera.sides();
    let place = |[x, y]: &[f32; 2]| view.place(feet + right * *x + Vec3::Y * *y);
    outline.iter().map(place).collect()
}

/// Draws the person over the picture of a tree.
pub(super) fn draw(ui: &Ui, view: &Projection) {
    let feet = stand(view);
    let ends = [feet, feet + Vec3::Y * HEIGHT].map(|point| view.place(point));
    let [Some(low), Some(high)] = ends else {
        return;
    };
    if low.distance(high) < LEAST {
        return;
    }
    let painter = ui.painter_at(view.rect);
    let shadow = (0..ROUND).map(|corner| {
        let (sine, cosine) = libm::sincosf(TAU * float(corner) / float(ROUND));
        view.place(feet + Vec3::new(cosine, 0.0, sine) * 0.3)
    });
    if let Some(shadow) = shadow.collect::<Option<Vec<Pos2>>>() {
        let dark = Color32::from_black_alpha(70);
        painter.add(Shape::convex_polygon(shadow, dark, Stroke::NONE));
    }
    for outline in outlines() {
        if let Some(points) = seen(view, feet, &outline) {
            painter.add(Shape::convex_polygon(points, COLOUR, Stroke::NONE));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{Camera, Lens};
    use eframe::egui::{Rect, pos2, vec2};

    #[test]
    fn the_figure_is_as_high_as_it_says_and_all_its_parts_are_convex() {
        let outlines = outlines();
        let heights = outlines.iter().flatten().map(|[_, y]| *y);
        let (low, high) = heights.fold((9.0_f32, 0.0_f32), |(l, h), y| (l.min(y), h.max(y)));
        assert!(low.abs() < 0.001 && (high - HEIGHT).abs() < 0.001);
        for part in &outlines {
            let turn = |i: usize| {
                let [a, b, c] = [0, 1, 2].map(|step| part[(i + step) % part.len()]);
                (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
            };
            let turns: Vec<f32> = (0..part.len()).map(turn).collect();
            let same = turns.iter().all(|t| *t > 0.0) || turns.iter().all(|t| *t < 0.0);
            assert!(same, "{part:?}");
        }
    }

    #[test]
    fn the_person_stands_before_the_trunk_and_left_of_it_from_all_sides() {
        for eye in [
            Vec3::new(0.0, 2.0, 20.0),
            Vec3::new(-20.0, 2.0, 0.0),
            Vec3::new(9.0, 6.0, -9.0),
        ] {
            let camera = Camera {
                eye,
                target: Vec3::Y * 4.0,
                lens: Lens::Perspective(0.7),
            };
            let rect = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 300.0));
            let view = Projection::new(camera, rect);
            let feet = stand(&view);
            assert!(feet.distance(eye) < eye.length() && feet.y == 0.0);
            assert!(view.place(feet).unwrap().x < view.place(Vec3::ZERO).unwrap().x);
        }
    }
}
