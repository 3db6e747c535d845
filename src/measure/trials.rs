//! The forms that one prototype may take, each tried in its context.

use super::MeasureError;
use super::context::{Context, Gauge, Scenes, Trial, TrialQuad, cards};
use super::menu::{Look, Set};
use super::silhouette::Cutouts;
use crate::capture::CAPTURE_SPLINE_LOD;
use crate::impostor::cross_quad;
use crate::impostor::planes::{self, Plane, Stem};
use crate::lod::cut::Offer;
use crate::math::{PI, Vec3};
use crate::mesh::{Coat, Mesh, tube};
use crate::species::schema::{ClosedForm, Lod, Simplification};
use crate::tree::{Branch, Part};
use std::borrow::Cow;

/// Names of sets that show everything on each plane.
const CROSS_TOP: &str = "cross+top";
const STAR_TOP: &str = "star+top";

/// Sub-trees of more cards are measured by themselves, not with their siblings.
pub(super) const CONTEXT_CARDS: u64 = 4000;

/// Sub-trees of more cards get crossed quads only: fitting planes to them would cost more than it gives.
pub(super) const FITTED_CARDS: u64 = 2500;

/// Numbers of fitted planes that are tried.
const FITTED: [usize; 7] = [3, 4, 6, 8, 12, 16, 24];

/// Numbers of clumps that are tried, as long as each has [`CLUMP_CARDS`].
const CLUMPS: [usize; 5] = [2, 4, 8, 16, 32];

/// Most clumps of a sub-tree in an atlas of 1024 texels along an edge: more would leave each, and all else in
/// it, too few texels. Other atlases hold as many more or fewer as they have texels.
const MOST_CLUMPS: u64 = 100;

/// Fewest leaf cards of a clump, in the mean.
const CLUMP_CARDS: u64 = 12;

/// Turns of the crossed quads that are tried, over a quarter turn.
const TURNS: u16 = 4;

/// A turn must lower the error by this part to be taken: captures along the axes are easier to read.
const TURN_GAIN: f32 = 0.03;

/// Smallest and largest scale of a form's quads.
const SCALES: [f32; 2] = [0.85, 1.25];

/// What was found for one prototype.
#[derive(Default)]
pub(super) struct Found {
    pub(super) forms: Vec<(Look, Offer)>,
    pub(super) turn: f32,
    /// Trial captures of its crossed quads, and the scale of the error that they were found to have.
    pub(super) cross: Option<(Vec<TrialQuad>, f32)>,
    pub(super) cross_scale: f32,
    /// By form: mean distance of what it shows from where it shows it, metres; missing ones are 0.
    pub(super) shifts: Vec<f32>,
}

impl Gauge<'_> {
    pub(super) fn forms_of(
        &self,
        scenes: &Scenes,
        seat: (usize, usize),
        lod: &Lod,
    ) -> Result<Found, MeasureError> {
        let (level, prototype) = seat;
        let mut found = Found::default();
        let Some(scene) = scenes.of(seat) else {
            return Ok(found);
        };
        match &self.tree.prototype(level, prototype).part {
            Part::Leaf { .. } => return Ok(found),
            Part::Stool => found.forms.push((Look::Bare, open(0, 0.0))),
            Part::Branch(branch) => {
                let context = self.own_part(scene, seat)?;
                self.own_part_forms(seat, branch, lod, (&context, &mut found));
            }
        }
        if self.tree.has_children(level) {
            let name = &self.tree.levels[level].name;
            let forced = lod.forms.iter().find(|(level, _)| level == name);
            let context = self.whole_node(scenes, scene, seat, CONTEXT_CARDS);
            let forced = forced.map(|(_, form)| *form);
            self.closed_forms(seat, forced, (&scene.mesh, &context), &mut found)?;
        }
        Ok(found)
    }

    /// The node's own branch: spline LODs, quads, nothing.
    fn own_part_forms(
        &self,
        (level, _): (usize, usize),
        branch: &Branch,
        lod: &Lod,
        (context, found): (&Context<'_>, &mut Found),
    ) {
        let splines = if lod.priorities.contains(&Simplification::Splines) {
            lod.tolerances.len().max(1)
        } else {
            1
        };
        let place = crate::math::Similarity::IDENTITY;
        let mesh = |lod: usize| tube(branch, lod, Coat::plain(1.0)).placed(&place, 1.0);
        for lod in 0..splines {
            let error = match lod {
                0 => 0.0,
                _ => context.try_mesh(Some(&mesh(lod)), self.cutouts).error,
            };
            let look = Look::Geometry(u8::try_from(lod).unwrap_or(u8::MAX));
            found.forms.push((look, open(branch.triangles(lod), error)));
        }
        // The trunk must stand, and a branch that carries nothing must be seen.
        let carries = self.tree.has_children(level);
        if lod.priorities.contains(&Simplification::Branches) {
            let own = mesh(0);
            let quads = crossed(
                &own,
                &own,
                cross_quad::mean_axis(branch),
                0.0,
                self.cutouts,
                context.sample,
            );
            let error = context.try_quads(&quads, 1.0).error;
            found.forms.push((Look::Quads, open(4, error)));
        }
        if carries && level > 0 {
            let error = context.try_mesh(None, self.cutouts).error;
            found.forms.push((Look::Bare, open(0, error)));
        }
        // Errors of coarser tubes never fall, or the selector would prefer them for the noise's sake.
        let mut floor = 0.0_f32;
        for (look, offer) in &mut found.forms {
            if matches!(look, Look::Geometry(_)) {
                floor = floor.max(offer.error);
                offer.error = floor;
            }
        }
    }

    /// The stem of the whole tree; branches inside a crown are not seen beside themselves.
    fn stem(&self, (level, prototype): (usize, usize)) -> Option<Stem> {
        match &self.tree.prototype(level, prototype).part {
            part @ Part::Branch(branch) if level == 0 => Some(Stem {
                axis: branch.axis.iter().map(|s| s.position).collect(),
                radius: branch.radius,
                triangles: self
                    .quads
                    .geometry(part, CAPTURE_SPLINE_LOD, Coat::plain(1.0))
                    .map_or(0, |t| t.indices.len() / 3),
            }),
            _ => None,
        }
    }

    /// Numbers of clumps to try for a sub-tree of so many leaf cards.
    fn clump_counts(&self, level: usize, leaves: u64) -> Vec<usize> {
        let mut counts = CLUMPS.to_vec();
        if level == 0 {
            // As many as a budget allows, where no sub-trees fill it.
            let of_budgets = self.budgets.iter().map(|b| b / 6);
            let fitting = of_budgets.filter(|c| (12..=MOST_CLUMPS).contains(c));
            counts.extend(fitting.filter_map(|c| usize::try_from(c).ok()));
            counts.sort_unstable();
            counts.dedup();
        }
        let fits = |count: u64| count << 20 <= MOST_CLUMPS * u64::from(self.atlas_size).pow(2);
        counts.retain(|&count| CLUMP_CARDS * count as u64 <= leaves && fits(count as u64));
        counts
    }

    /// The whole node: crossed quads in their best turn, with a level plane, fitted planes.
    ///
    /// With a `forced` form, that one alone.
    fn closed_forms(
        &self,
        seat: (usize, usize),
        forced: Option<ClosedForm>,
        (own, context): (&Mesh, &Context<'_>),
        found: &mut Found,
    ) -> Result<(), MeasureError> {
        let (level, prototype) = seat;
        let items = planes::items(own);
        let through = match &self.tree.prototype(level, prototype).part {
            Part::Branch(branch) => cross_quad::mean_axis(branch),
            _ => own.bounds().centre(),
        };
        let trial = |planes: &[Plane]| -> Vec<TrialQuad> {
            let planes = planes.iter();
            planes
                .take_while(|_| self.go_on().is_ok())
                .map(|plane| {
                    let part = match plane.members {
                        Some(_) => Cow::Owned(planes::part(own, &items, plane)),
                        None => Cow::Borrowed(own),
                    };
                    TrialQuad::of(&part, plane, self.cutouts, context.sample)
                })
                .collect()
        };
        let attempt = |planes: Vec<Plane>, name: String| -> (Set, f32, Vec<TrialQuad>) {
            let quads = trial(&planes);
            let (scale, error) = best_scale(|scale| context.try_quads(&quads, scale));
            let mut scales = vec![scale; planes.len()];
            let mut error = error;
            let is_level: Vec<bool> = planes.iter().map(|p| p.normal().y.abs() > 0.9).collect();
            if level == 0 && is_level.contains(&true) && planes.len() <= 4 {
                (scales, error) = balanced(context, &quads, scales, &is_level);
            }
            (
                Set {
                    planes,
                    scales,
                    name,
                    strips: Vec::new(),
                },
                error,
                quads,
            )
        };
        let stem = self.stem(seat);
        let star = |upright: u16, turn: f32, level: bool| {
            planes::star(own, stem.as_ref(), (through, upright), turn, level)
        };
        let mut best = attempt(star(2, 0.0, false), String::new());
        for turn in 1..TURNS {
            let turn = PI * 0.5 * f32::from(turn) / f32::from(TURNS);
            let other = attempt(star(2, turn, false), String::new());
            if other.1 < best.1 * (1.0 - TURN_GAIN) {
                found.turn = turn;
                best = other;
            }
        }
        let turn = found.turn;
        found.cross = Some((best.2, best.1));
        found.cross_scale = best.0.scales[0];
        let others_only = !matches!(forced, None | Some(ClosedForm::Cross));
        if !others_only {
            found
                .forms
                .push((Look::Cross(best.0.scales[0]), closed(4, best.1)));
        }
        let sets: Vec<(Set, f32, Vec<TrialQuad>)> = match forced {
            Some(ClosedForm::Cross | ClosedForm::Strips(..)) => Vec::new(),
            Some(ClosedForm::CrossTop) => vec![attempt(star(2, turn, true), CROSS_TOP.to_owned())],
            Some(ClosedForm::StarTop) => vec![attempt(star(3, turn, true), STAR_TOP.to_owned())],
            Some(ClosedForm::Planes(count)) => {
                let set = planes::fitted(&items, count as usize);
                vec![attempt(set, format!("planes {count}"))]
            }
            None => {
                let leaves = cards(self.tree, level, prototype);
                let mut sets = vec![attempt(star(2, turn, true), CROSS_TOP.to_owned())];
                if level == 0 {
                    sets.push(attempt(star(3, turn, true), STAR_TOP.to_owned()));
                }
                for count in self.clump_counts(level, leaves) {
                    self.go_on()?;
                    let set = planes::clumps(&items, count, turn, (true, level == 0));
                    sets.push(attempt(set, format!("clumps {count}")));
                }
                // More planes than leaves are the leaves themselves.
                let useful =
                    |count: &&usize| leaves <= FITTED_CARDS && 2 * **count as u64 <= leaves;
                for &count in FITTED.iter().filter(useful) {
                    self.go_on()?;
                    let set = planes::fitted(&items, count);
                    sets.push(attempt(set, format!("planes {count}")));
                }
                sets
            }
        };
        let shift = |planes: &[Plane]| planes::mean_shift(&items, planes);
        let open = found.forms.iter().filter(|(_, o)| o.open).count();
        found.shifts = vec![0.0; open];
        if !others_only {
            found.shifts.push(shift(&best.0.planes));
        }
        for (set, error, _) in sets {
            let triangles = 2 * set.planes.len() as u64;
            found.shifts.push(shift(&set.planes));
            found
                .forms
                .push((Look::Planes(set), closed(triangles, error)));
        }
        for strip in self.strips(seat, forced, context, &items)? {
            found.shifts.push(strip.shift);
            let offer = closed(strip.triangles, strip.error);
            found.forms.push((Look::Planes(strip.set), offer));
        }
        // What was tried after a cancel is not whole.
        Ok(self.go_on()?)
    }
}

/// The scale at which quads cover as much as full detail, within bounds, and the error there.
pub(super) fn best_scale(attempt: impl Fn(f32) -> Trial) -> (f32, f32) {
    let plain = attempt(1.0);
    let [low, high] = SCALES;
    // Area goes with the square of the scale where nothing overlaps; crowns overlap.
    let guess = (1.0 / plain.coverage.max(0.1)).sqrt().clamp(low, high);
    if (guess - 1.0).abs() < 0.005 {
        return (1.0, plain.error);
    }
    let second = attempt(guess);
    let slope = (second.coverage - plain.coverage) / (guess - 1.0);
    let scale = if slope > 1e-3 {
        (1.0 + (1.0 - plain.coverage) / slope).clamp(low, high)
    } else {
        guess
    };
    let third = attempt(scale);
    (scale, third.error)
}

/// Scales of a whole tree's upright and level quads at which it covers as much from the side and from above.
fn balanced(
    context: &Context<'_>,
    quads: &[TrialQuad],
    mut scales: Vec<f32>,
    is_level: &[bool],
) -> (Vec<f32>, f32) {
    /// Rounds; each takes most of what is left.
    const ROUNDS: usize = 4;
    /// A level quad that reaches out of the crown is seen as a line across the tree.
    const WIDEST_LEVEL: f32 = 1.0;
    let [low, high] = SCALES;
    for _ in 0..ROUNDS {
        let seen = context.try_scaled(quads, &scales);
        for (scale, &is_level) in scales.iter_mut().zip(is_level) {
            let part = seen.parts[usize::from(is_level)];
            let most = if is_level { WIDEST_LEVEL } else { high };
            *scale = (*scale * (1.0 + 0.7 * (1.0 - part))).clamp(low, most);
        }
    }
    let error = context.try_scaled(quads, &scales).error;
    (scales, error)
}

/// Trial captures of crossed quads.
fn crossed(
    shown: &Mesh,
    framed: &Mesh,
    through: Vec3,
    turn: f32,
    cutouts: &Cutouts,
    sample: f32,
) -> Vec<TrialQuad> {
    planes::star(framed, None, (through, 2), turn, false)
        .iter()
        .map(|plane| TrialQuad::of(shown, plane, cutouts, sample))
        .collect()
}

fn open(triangles: u64, error: f32) -> Offer {
    Offer {
        triangles,
        error,
        open: true,
    }
}

fn closed(triangles: u64, error: f32) -> Offer {
    Offer {
        triangles,
        error,
        open: false,
    }
}
