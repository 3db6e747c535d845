//! Draws and compares: every model, from every held-out view, at every height.
//!
//! Views and heights are independent, and their results are put together by index, so the figures are the
//! same at any thread count.

use super::compare::{Difference, Outline, compare};
use super::entrants::{self, Entrant};
use super::light::Light;
use super::motion::Motion;
use super::picture::{Picture, Sitter, Skin};
use super::resample::Resamples;
use super::{Evaluation, Model, Plate, Score, Scores, Subject, plates};
use crate::capture::View;
use crate::math::{Bounds, Vec3, float, floor_to_u32};
use crate::measure::silhouette::{fragments, seen_bounds};
use crate::measure::views::{Direction, held_out_aerial, held_out_side};
use crate::mesh::Mesh;
use crate::report::{Cancelled, Progress};
use rayon::prelude::*;

/// What is measured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Number of held-out views from -5 to 30 degrees above the horizon.
    pub side_views: usize,
    /// Number of held-out views from 35 to 80 degrees.
    pub aerial_views: usize,
    /// Heights of the tree in the pictures, pixels, falling.
    pub heights: Vec<u32>,
    /// True to keep pictures of the LODs for the report.
    pub plates: bool,
    /// True to add the rivals of the feature `rivals`; without the feature there are none to add. Leaves left
    /// out by chance are compared without it, too.
    pub rivals: bool,
    /// True to look at still pictures of the LODs alone: no rival at all, and nothing that moves.
    pub only_lods: bool,
}

impl Settings {
    /// A first look at the LODs, some hundred times quicker than the whole of it: few and small pictures.
    #[must_use]
    pub fn quick() -> Self {
        Self {
            side_views: 4,
            aerial_views: 2,
            heights: vec![128, 64, 32, 16],
            only_lods: true,
            ..Self::default()
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            side_views: 24,
            aerial_views: 12,
            heights: vec![512, 128, 64, 32, 16],
            plates: false,
            rivals: false,
            only_lods: false,
        }
    }
}

/// From this height on a pixel has fewer samples: enough of them are on a leaf then.
const LARGE: u32 = 256;

/// Samples along each edge of a pixel of a small and of a large picture.
const SUPERSAMPLES: [u32; 2] = [4, 2];

/// The same for outlines: odd, so that most of a pixel's samples are covered or most are not.
const OUTLINE_SAMPLES: [u32; 2] = [5, 3];

/// Beside the largest height, rivals are measured at this one.
const RIVAL_HEIGHT: u32 = 64;

/// Pixels of background around all models: the rim of the mask, and one that nothing touches.
const MARGIN: u32 = 4;

/// Half of the longest edge of a picture, as heights of the tree: the full tree never reaches as far, and the
/// leaves of a rival that do are cut there.
const LARGEST_HALF: u32 = 3;

/// Compares the LODs of a tree, and rivals, with the full tree.
///
/// Models are drawn without perspective, `height` pixels for the height of the full tree (or a quarter of its
/// width, if that is more), with 2 by 2 samples to the pixel from 256 pixels on and 4 by 4 below;
/// outlines, which decide silhouettes and coverage, with 3 by 3 and 5 by 5 that read the finest texels. Rivals are
/// measured at the largest height, where without `rivals` only their outlines are drawn, and at 64 pixels only. Where the full tree covers no pixel and a model covers
/// some, its coverage counts as 100 % too much.
///
/// # Errors
/// If `progress` was cancelled.
pub fn evaluate(
    subject: &Subject<'_>,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Evaluation, Cancelled> {
    let (skin, full_skin) = rayon::join(
        || skin(&subject.look),
        || (!same_look(subject)).then(|| skin(&subject.full_look)),
    );
    let full_skin = full_skin.as_ref().unwrap_or(&skin);
    let entrants = entrants::all(subject, settings, full_skin, progress)?;
    let set = Set {
        settings,
        light: Light::of(subject.full),
        full: Sitter::new(subject.full, full_skin),
        sitters: entrants
            .iter()
            .map(|e| Sitter::new(&e.mesh, if e.is_lod { &skin } else { full_skin }))
            .collect(),
        entrants: &entrants,
        stands: stands(subject, settings, &entrants),
        tall: tall(subject.full, &entrants),
    };
    let jobs: Vec<(usize, usize)> = (0..set.stands.len())
        .flat_map(|view| (0..settings.heights.len()).map(move |height| (view, height)))
        .collect();
    progress.begin("comparing", jobs.len() as u64);
    let shots: Result<Vec<Shot>, Cancelled> = jobs
        .par_iter()
        .map(|&(view, height)| {
            let shot = set.shot(view, height, progress)?;
            progress.step();
            Ok(shot)
        })
        .collect();
    let shots = shots?;
    let motion = if settings.only_lods {
        Motion::default()
    } else {
        Motion::of(&set, progress)?
    };
    Ok(evaluation(subject, settings, &entrants, shots, motion))
}

fn skin(look: &super::Look<'_>) -> Skin {
    Skin::of(look.foliage, look.bark, look.reliefs)
}

/// True if both looks are one, as they are for a tree that was just made.
fn same_look(subject: &Subject<'_>) -> bool {
    let (a, b) = (&subject.look, &subject.full_look);
    core::ptr::eq(a.foliage, b.foliage)
        && core::ptr::eq(a.bark, b.bark)
        && core::ptr::eq(a.reliefs, b.reliefs)
}

/// A held-out view with what is seen from it, metres from the middle of the full tree as seen.
pub(super) struct Stand {
    pub(super) direction: Direction,
    is_side: bool,
    full: Bounds,
    all: Bounds,
}

fn stands(subject: &Subject<'_>, settings: &Settings, entrants: &[Entrant<'_>]) -> Vec<Stand> {
    let side = held_out_side(settings.side_views).into_iter();
    let aerial = held_out_aerial(settings.aerial_views).into_iter();
    let directions: Vec<(Direction, bool)> = side
        .map(|d| (d, true))
        .chain(aerial.map(|d| (d, false)))
        .collect();
    directions
        .par_iter()
        .map(|&(direction, is_side)| {
            let full = seen_bounds(subject.full, &direction);
            let seen = entrants.iter().map(|e| seen_bounds(&e.mesh, &direction));
            Stand {
                direction,
                is_side,
                full,
                all: seen.fold(full, |all, one| all.union(&one)),
            }
        })
        .collect()
}

/// Height of the full tree, or a quarter of its width, metres; of all models if the full tree is nothing.
fn tall(full: &Mesh, entrants: &[Entrant<'_>]) -> f32 {
    let all = || entrants.iter().map(|e| e.mesh.bounds());
    let bounds = match full.bounds() {
        empty if empty.is_empty() => all().fold(empty, |all, one| all.union(&one)),
        bounds => bounds,
    };
    let size = bounds.size();
    size.y.max(size.max_element() * 0.25).max(f32::MIN_POSITIVE)
}

/// Everything that one shot, or a look at motion, needs.
pub(super) struct Set<'a> {
    settings: &'a Settings,
    pub(super) light: Light,
    pub(super) full: Sitter<'a>,
    /// By model.
    pub(super) sitters: Vec<Sitter<'a>>,
    pub(super) entrants: &'a [Entrant<'a>],
    pub(super) stands: Vec<Stand>,
    /// What counts as the tree's height, metres.
    pub(super) tall: f32,
}

/// All models from one view at one height.
struct Shot {
    /// By model; none if it is not measured at this height.
    differences: Vec<Option<Difference>>,
    /// By model, at the largest height.
    layers: Vec<f32>,
    plate: Option<Plate>,
}

impl Set<'_> {
    fn is_largest(&self, height: usize) -> bool {
        self.settings.heights.iter().max() == self.settings.heights.get(height)
    }

    fn is_measured(&self, model: &Model, height: usize) -> bool {
        !model.rival || self.is_largest(height) || self.settings.heights[height] == RIVAL_HEIGHT
    }

    /// Metres along the edge of a pixel.
    fn pixel(&self, height: usize) -> f32 {
        self.tall / float(self.settings.heights[height].max(1))
    }

    /// The grid of pixels is fixed to the full tree, so that no model moves that of another.
    fn view(&self, stand: &Stand, height: usize) -> View {
        let pixel = self.pixel(height);
        let [right, up, toward] = stand.direction.axes();
        let middle = stand.full.centre();
        let reach = (stand.all.max - middle).max(middle - stand.all.min);
        let most = LARGEST_HALF.saturating_mul(self.settings.heights[height].max(1));
        let half = |reach: f32| floor_to_u32((reach.max(0.0) / pixel).ceil()).min(most) + MARGIN;
        let (x, y) = (half(reach.x), half(reach.y));
        View {
            centre: right * middle.x + up * middle.y + toward * middle.z,
            right,
            up,
            half: [float(x) * pixel, float(y) * pixel],
            width: 2 * x,
            height: 2 * y,
        }
    }

    /// Fails if `progress` was cancelled.
    fn shot(&self, view: usize, height: usize, progress: &dyn Progress) -> Result<Shot, Cancelled> {
        go_on(progress)?;
        let stand = &self.stands[view];
        let pixel = self.pixel(height);
        let frame = self.view(stand, height);
        let pixels = self.settings.heights[height];
        let n = SUPERSAMPLES[usize::from(pixels >= LARGE)];
        let full = Picture::draw(&self.full, &self.light, &frame, n);
        let odd = OUTLINE_SAMPLES[usize::from(pixels >= LARGE)];
        let outline = |s: &Sitter<'_>| Outline::draw(s.mesh, &s.skin.cutouts, &frame, odd);
        let full_outline = outline(&self.full);
        let is_shown = self.settings.plates && self.is_shown(view);
        let mut shown = Vec::new();
        let mut differences = Vec::new();
        for (index, entrant) in self.entrants.iter().enumerate() {
            go_on(progress)?;
            if !self.is_measured(&entrant.model, height) {
                differences.push(None);
                continue;
            }
            // Colours of rivals at the largest height would take half of the time.
            let is_lit = entrant.is_lod || self.settings.rivals || !self.is_largest(height);
            let picture =
                is_lit.then(|| Picture::draw(&self.sitters[index], &self.light, &frame, n));
            let test_outline = outline(&self.sitters[index]);
            differences.push(Some(compare(
                (&full, &full_outline),
                (picture.as_ref(), &test_outline),
            )));
            if let Some(picture) = picture.filter(|_| is_shown && entrant.is_lod) {
                shown.push((index, picture));
            }
        }
        let layers = if self.is_largest(height) {
            self.layers(stand, pixel, &frame)
        } else {
            Vec::new()
        };
        let name = if stand.is_side { "side" } else { "above" };
        Ok(Shot {
            differences,
            layers,
            plate: plates::plate(&full, &shown, name, pixels, self.is_largest(height)),
        })
    }

    /// Fragments to the pixel of the full tree's frame, by model.
    fn layers(&self, stand: &Stand, pixel: f32, frame: &View) -> Vec<f32> {
        let Vec3 { x, y, .. } = stand.full.size() / pixel;
        // A tree seen edge on still has a pixel's breadth.
        let pixels = x.max(1.0) * y.max(1.0);
        let layers = |e: &Entrant<'_>| real(fragments(&e.mesh, frame)) / pixels;
        self.entrants.iter().map(layers).collect()
    }

    /// Pictures are kept from the middle of the side views and from a third of the aerial ones.
    fn is_shown(&self, view: usize) -> bool {
        let side = self.settings.side_views;
        let is_middle = side > 0 && view == side / 2;
        is_middle || (view >= side && view == side + self.settings.aerial_views / 3)
    }
}

/// Puts the shots together: views in their order, for each model and height.
fn evaluation(
    subject: &Subject<'_>,
    settings: &Settings,
    entrants: &[Entrant<'_>],
    shots: Vec<Shot>,
    motion: Motion,
) -> Evaluation {
    let heights = &settings.heights;
    let resamples = Resamples::new(settings.side_views, settings.aerial_views);
    let mut models: Vec<Model> = entrants.iter().map(|e| e.model.clone()).collect();
    for (index, model) in models.iter_mut().enumerate() {
        for (h, &height) in heights.iter().enumerate() {
            let all = differences(&shots, index, h, heights.len());
            if !all.is_empty() {
                model
                    .scores
                    .push(scores(height, &all, settings.side_views, &resamples));
            }
        }
        model.layers = mean(shots.iter().filter_map(|s| s.layers.get(index).copied()));
    }
    let moving = motion.pops.into_iter().zip(motion.flickers);
    for (model, (pop, flicker)) in models.iter_mut().zip(moving) {
        (model.pop, model.flicker) = (pop, flicker);
    }
    let largest = (0..heights.len()).max_by_key(|&h| heights[h]).unwrap_or(0);
    let ious: Vec<Vec<f32>> = (0..models.len())
        .map(|index| differences(&shots, index, largest, heights.len()))
        .map(|all| all.iter().map(|d| d.iou).collect())
        .collect();
    for index in 0..models.len() {
        let (loses_to, undecided) = against_rivals(index, &models, &ious, &resamples);
        (models[index].loses_to, models[index].undecided) = (loses_to, undecided);
    }
    let atlas = &subject.look.foliage.albedo;
    Evaluation {
        name: subject.name.to_owned(),
        latin: subject.latin.to_owned(),
        slug: subject.slug.to_owned(),
        seed: subject.seed,
        reference_triangles: subject.full.triangles(),
        texture_bytes: 4 * u64::from(atlas.width()) * u64::from(atlas.height()),
        side_views: settings.side_views,
        aerial_views: settings.aerial_views,
        heights: heights.clone(),
        orbit_flip: motion.orbit_flip,
        models,
        plates: shots.into_iter().filter_map(|s| s.plate).collect(),
    }
}

/// What was measured of one model at one height, by view.
fn differences(shots: &[Shot], model: usize, height: usize, heights: usize) -> Vec<Difference> {
    let at_height = shots.iter().skip(height).step_by(heights.max(1));
    at_height.filter_map(|s| s.differences[model]).collect()
}

fn scores(height: u32, all: &[Difference], side: usize, resamples: &Resamples) -> Scores {
    let (of_side, of_aerial) = all.split_at(side.min(all.len()));
    let interval = |f: fn(&Difference) -> f32| {
        let values: Vec<f32> = all.iter().map(f).collect();
        resamples.interval(&values)
    };
    Scores {
        height,
        all: score(all),
        side: score(of_side),
        aerial: score(of_aerial),
        iou_interval: interval(|d| d.iou),
        flip_interval: interval(|d| d.flip.map_or(f32::NAN, |[a, b]| (a + b) * 0.5)),
    }
}

/// Rivals at a LOD's budget, and with no more triangles: those whose silhouettes are better at the largest
/// height, and those of which the views do not tell. A model that is no worse from any view has not lost.
fn against_rivals(
    index: usize,
    models: &[Model],
    ious: &[Vec<f32>],
    resamples: &Resamples,
) -> (Vec<String>, Vec<String>) {
    let (mut better, mut undecided) = (Vec::new(), Vec::new());
    let model = &models[index];
    if model.rival {
        return (better, undecided);
    }
    for (rival, theirs) in models.iter().zip(ious) {
        if !rival.rival || rival.budget != model.budget || rival.triangles > model.triangles {
            continue;
        }
        let pairs = theirs.iter().zip(&ious[index]);
        let gains: Vec<f32> = pairs.map(|(rival, model)| rival - model).collect();
        let [low, high] = resamples.interval(&gains);
        if low > 0.0 {
            better.push(rival.label.clone());
        } else if high > 0.0 {
            undecided.push(rival.label.clone());
        }
    }
    (better, undecided)
}

/// Means over views; not a number without views.
fn score(differences: &[Difference]) -> Score {
    let of = |f: fn(&Difference) -> f32| mean(differences.iter().map(f));
    let flip_by_light =
        [0, 1].map(|light| mean(differences.iter().filter_map(|d| d.flip.map(|f| f[light]))));
    let [a, b] = flip_by_light;
    Score {
        iou: of(|d| d.iou),
        coverage: of(|d| d.coverage),
        coverage_abs: of(|d| d.coverage.abs()),
        flip: (a + b) * 0.5,
        flip_by_light,
        flip_worst: if a.is_nan() { a } else { a.max(b) },
        normal_deg: mean(differences.iter().filter_map(|d| d.normal_deg)),
    }
}

/// Fails once the work should be given up.
pub(super) fn go_on(progress: &dyn Progress) -> Result<(), Cancelled> {
    if progress.cancelled() {
        return Err(Cancelled);
    }
    Ok(())
}

pub(super) fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (mut sum, mut count) = (0.0_f64, 0);
    for value in values {
        sum += f64::from(value);
        count += 1;
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a mean in single precision"
    )]
    let mean = (sum / f64::from(count)) as f32;
    mean
}

#[expect(clippy::cast_precision_loss, reason = "a ratio needs few digits")]
fn real(count: u64) -> f32 {
    count as f32
}
