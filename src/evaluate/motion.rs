//! What is seen only in motion: LODs that flicker while the viewer moves, and the pop when one takes another's
//! place.

use super::compare::flip_between;
use super::picture::Picture;
use super::run::{Set, go_on, mean};
use super::summary::shown_height;
use super::{Flicker, Pop};
use crate::capture::View;
use crate::math::{PI, Vec3, float, floor_to_u32, round_to_u32};
use crate::measure::views::Direction;
use crate::report::{Cancelled, Progress};
use rayon::prelude::*;

/// Height of the tree in the orbit, pixels: small enough that single leaves and quads are gone and come back.
const ORBIT_HEIGHT: u32 = 64;

/// Arcs of the orbit, spread over the held-out views, and frames in each.
const ARCS: usize = 4;
const FRAMES: u32 = 3;

/// Turn from frame to frame, degrees: half a pixel at the edge of a crown as broad as it is high.
const STEP_DEGREES: f32 = 1.0;

/// Heights at which a switch is looked at, pixels.
const POP_HEIGHTS: [u32; 2] = [8, 512];

/// Views from which a switch is looked at.
const POP_VIEWS: usize = 4;

/// Samples along each edge of a pixel.
const SAMPLES: u32 = 4;

/// Pixels of air around the tree.
const MARGIN: u32 = 4;

/// By LOD; and the mean change of the full tree in the orbit.
pub(super) struct Motion {
    pub(super) pops: Vec<Option<Pop>>,
    pub(super) flickers: Vec<Option<Flicker>>,
    pub(super) orbit_flip: f32,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            pops: Vec::new(),
            flickers: Vec::new(),
            orbit_flip: f32::NAN,
        }
    }
}

impl Motion {
    /// Draws the LODs, which come first among the models, in motion. Fails if `progress` was cancelled.
    pub(super) fn of(set: &Set<'_>, progress: &dyn Progress) -> Result<Self, Cancelled> {
        let lods = set.entrants.iter().take_while(|e| e.is_lod).count();
        let arcs = spread(set, ARCS);
        progress.begin("moving", (arcs.len() + lods) as u64);
        let changes: Result<Vec<Vec<Vec<f32>>>, Cancelled> = arcs
            .par_iter()
            .map(|arc| {
                let changes = changes(set, arc, lods, progress)?;
                progress.step();
                Ok(changes)
            })
            .collect();
        let changes = changes?;
        // By model, the full tree first.
        let of = |model: usize| {
            changes
                .iter()
                .flat_map(move |arc| arc[model].iter().copied())
        };
        let orbit_flip = mean(of(0));
        let flicker = |lod: usize| {
            let flip = mean(of(lod + 1));
            Flicker {
                flip,
                ratio: flip / orbit_flip,
                worst_ratio: of(lod + 1).fold(0.0, f32::max) / orbit_flip,
            }
        };
        let is_moving = !arcs.is_empty();
        let pops: Result<Vec<Option<Pop>>, Cancelled> = (0..lods)
            .into_par_iter()
            .map(|lod| {
                go_on(progress)?;
                let pop = pop(set, lod);
                progress.step();
                Ok(pop)
            })
            .collect();
        Ok(Self {
            pops: pops?,
            flickers: (0..lods)
                .map(|lod| is_moving.then(|| flicker(lod)))
                .collect(),
            orbit_flip,
        })
    }
}

/// Some of the held-out views, evenly spread.
fn spread(set: &Set<'_>, count: usize) -> Vec<Direction> {
    let views = set.stands.len();
    let count = count.min(views);
    (0..count)
        .map(|i| set.stands[(2 * i + 1) * views / (2 * count)].direction)
        .collect()
}

/// FLIP from each frame of an arc to the next: of the full tree, then of each LOD.
fn changes(
    set: &Set<'_>,
    start: &Direction,
    lods: usize,
    progress: &dyn Progress,
) -> Result<Vec<Vec<f32>>, Cancelled> {
    let frames: Vec<View> = (0..FRAMES)
        .map(|i| Direction {
            azimuth: start.azimuth + STEP_DEGREES * float(i) * PI / 180.0,
            ..*start
        })
        .map(|direction| frame(set, &direction, ORBIT_HEIGHT))
        .collect();
    let sitters = core::iter::once(&set.full).chain(&set.sitters[..lods]);
    sitters
        .map(|sitter| {
            go_on(progress)?;
            let draw = |view: &View| Picture::draw(sitter, &set.light, view, SAMPLES);
            let pictures: Vec<Picture> = frames.iter().map(draw).collect();
            let steps = pictures.windows(2);
            Ok(steps.map(|pair| flip_between(&pair[0], &pair[1])).collect())
        })
        .collect()
}

/// The switch to a LOD from the next finer one; none if it has no size.
fn pop(set: &Set<'_>, lod: usize) -> Option<Pop> {
    let [least, most] = POP_HEIGHTS;
    let height = shown_height(&set.entrants[lod].model)?.clamp(float(least), float(most));
    let height = round_to_u32(height);
    let finer = match lod.checked_sub(1) {
        Some(finer) => &set.sitters[finer],
        None => &set.full,
    };
    let directions = spread(set, POP_VIEWS);
    let flips: Vec<f32> = directions
        .par_iter()
        .map(|direction| {
            let view = frame(set, direction, height);
            let draw = |sitter| Picture::draw(sitter, &set.light, &view, SAMPLES);
            flip_between(&draw(finer), &draw(&set.sitters[lod]))
        })
        .collect();
    (!flips.is_empty()).then(|| Pop {
        height,
        flip: mean(flips.iter().copied()),
        worst: flips.iter().copied().fold(0.0, f32::max),
    })
}

/// A view whose middle and size do not change with the direction, so that nothing moves but the tree.
fn frame(set: &Set<'_>, direction: &Direction, height: u32) -> View {
    let pixel = set.tall / float(height.max(1));
    let full = set.full.mesh.bounds();
    let centre = if full.is_empty() {
        Vec3::ZERO
    } else {
        full.centre()
    };
    let radius = if full.is_empty() {
        0.0
    } else {
        full.size().length() * 0.5
    };
    let [right, up, _] = direction.axes();
    let half = floor_to_u32((radius / pixel).ceil()).min(3 * height) + MARGIN;
    View {
        centre,
        right,
        up,
        half: [float(half) * pixel; 2],
        width: 2 * half,
        height: 2 * half,
    }
}
