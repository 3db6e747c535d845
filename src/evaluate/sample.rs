//! An evaluation made up for tests.

use super::{Evaluation, Flicker, Model, Plate, Pop, Score, Scores, Shown};
use crate::image::{Image, png};

/// Heights of the made-up pictures.
const HEIGHTS: [u32; 5] = [512, 128, 64, 32, 16];

/// Five LODs, two kinds of rivals at two budgets, and pictures of two LODs; `LOD4` loses.
pub(super) fn evaluation() -> Evaluation {
    let mut models: Vec<Model> = [(50_000, 0.97), (10_000, 0.93), (2_500, 0.88), (1_000, 0.80)]
        .into_iter()
        .enumerate()
        .map(|(i, (triangles, iou))| model(&format!("LOD{i}"), triangles, iou))
        .collect();
    let mut coarsest = model("LOD4", 200, 0.55);
    coarsest.loses_to.push("Billboard".to_owned());
    models.push(coarsest);
    for (label, triangles, iou) in [
        ("Quadrics", 2_500, 0.61),
        ("Quadrics", 1_000, 0.48),
        ("Billboard", 1_000, 0.58),
        ("Billboard", 200, 0.57),
    ] {
        models.push(Model {
            rival: true,
            error_m: None,
            screen_size: None,
            pop: None,
            flicker: None,
            state: "8 views".to_owned(),
            ..model(label, triangles, iou)
        });
    }
    Evaluation {
        name: "Olive".to_owned(),
        latin: "Olea europaea".to_owned(),
        slug: "olive".to_owned(),
        seed: 7,
        reference_triangles: 83_000,
        texture_bytes: 4_194_304,
        side_views: 12,
        aerial_views: 8,
        heights: HEIGHTS.to_vec(),
        orbit_flip: 0.1,
        models,
        plates: ["side", "above"]
            .iter()
            .flat_map(|view| HEIGHTS.map(|height| plate(&[0, 1], view, height)))
            .collect(),
    }
}

/// A LOD whose scores at the largest height lie about `iou`.
pub(super) fn model(label: &str, triangles: u64, iou: f32) -> Model {
    let loss = 1.0 - iou;
    let at = |height: u32, worse: f32| {
        let part = worse * loss * if height > 100 { 1.0 } else { 0.5 };
        Score {
            iou: 1.0 - part,
            coverage: part * -0.2,
            coverage_abs: part * 0.25,
            flip: part * 0.4,
            flip_by_light: [part * 0.38, part * 0.42],
            flip_worst: part * 0.42,
            normal_deg: part * 60.0,
        }
    };
    Model {
        label: label.to_owned(),
        rival: false,
        budget: Some(triangles),
        triangles,
        layers: 2.5 + loss,
        error_m: Some(loss * 0.3),
        screen_size: Some(iou * iou * 0.9),
        state: "trunk:spline1 twigs:quads".to_owned(),
        scores: HEIGHTS
            .iter()
            .map(|&height| Scores {
                height,
                all: at(height, 1.0),
                side: at(height, 0.9),
                aerial: at(height, 1.2),
                iou_interval: [iou - 0.01, iou + 0.01],
                flip_interval: [loss * 0.39, loss * 0.41],
            })
            .collect(),
        pop: Some(Pop {
            height: 100,
            flip: loss * 0.3,
            worst: loss * 0.35,
        }),
        flicker: Some(Flicker {
            flip: 0.1 + loss * 0.01,
            ratio: 1.0 + loss * 0.1,
            worst_ratio: 1.2 + loss * 0.1,
        }),
        loses_to: Vec::new(),
        undecided: Vec::new(),
    }
}

fn plate(models: &[usize], view: &'static str, height: u32) -> Plate {
    let grey = |shade: u8| png::encode(&Image::filled(height, height, [shade; 3])).unwrap();
    Plate {
        view,
        height,
        reference: grey(40),
        shown: models
            .iter()
            .map(|&model| Shown {
                model,
                picture: grey(80),
                error: if height == HEIGHTS[0] {
                    grey(120)
                } else {
                    Vec::new()
                },
            })
            .collect(),
    }
}
