//! What each prototype's nodes may be drawn as, with the measured error of each form.
//!
//! Sources: Koniaris et al. 2009 (crossed quads, single branches as quads, spline LODs); Garcia et al. 2005
//! (planes fitted to leaves). Which is better depends on the part: crossed quads suit bushy sub-trees, fitted
//! planes suit fronds. So all are tried, and the selector takes what errs least per triangle.
//!
//! The error of a form is the area of silhouette in which it differs from full detail, mean over views, with
//! the form's quads scaled so that they cover as much as what they stand for. It is measured on the nodes of
//! one parent; what the rest of the crown hides is estimated from how much the silhouettes of all parents
//! overlap in the whole tree.

use super::MeasureError;
use super::context::{Gauge, Scene, Scenes, TrialQuad};
use super::silhouette::Cutouts;
use super::trials::{CONTEXT_CARDS, Found};
use crate::impostor::cross_quad::CrossQuads;
use crate::impostor::planes::Plane;
use crate::impostor::planes::strips::Strip;
use crate::lod::cut::{Menu, Offer};
use crate::lod::{Form, State};
use crate::math::{PI, Quat};
use crate::report::Progress;
use crate::species::schema::Lod;
use crate::tree::Tree;
use rayon::prelude::*;

/// In which form a prototype's node is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Look {
    /// Its own branch as a tube of a spline LOD; what it carries for itself.
    Geometry(u8),
    /// Its own branch as two quads; what it carries for itself.
    Quads,
    /// Its own branch left out; what it carries for itself.
    Bare,
    /// All of it as two crossed quads, scaled by a factor at which they cover what they stand for.
    Cross(f32),
    /// All of it as a set of planes.
    Planes(Set),
}

/// A set of planes that shows a prototype with all that grows on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// The planes, in the prototype's frame, or in that of the straightened prototype for strips.
    pub planes: Vec<Plane>,
    /// By plane: factor on its quad's size at which the set covers what it stands for.
    pub scales: Vec<f32>,
    /// In words: `cross+top`, `planes 8`, `strips 2x4`.
    pub name: String,
    /// The planes cut and bent, if they are; empty for planes that stay as they are.
    pub strips: Vec<Strip>,
}

/// All forms of all prototypes.
#[derive(Clone, Debug)]
pub struct Forms {
    /// By level and prototype, in the order of the menu's offers.
    pub looks: Vec<Vec<Vec<Look>>>,
    /// The same in numbers, for the selector.
    pub menu: Menu,
    /// By level and prototype: turn of the crossed quads about +Y, radians.
    pub turns: Vec<Vec<f32>>,
    /// By level and prototype: the sum of its nodes' squared scales.
    pub scales: Vec<Vec<f32>>,
}

impl Forms {
    /// The summed error of a level-wide state, square metres, on the menu's terms.
    #[must_use]
    pub fn error_of(&self, state: &State) -> f32 {
        let mut sum = 0.0;
        for (level, form) in state.forms.iter().enumerate() {
            let is_it = |look: &Look| match (form, look) {
                (Form::Geometry(a), Look::Geometry(b)) => a == b,
                (Form::Quads, Look::Quads) | (Form::Collapsed, Look::Cross(_)) => true,
                _ => false,
            };
            for (prototype, looks) in self.looks[level].iter().enumerate() {
                let offers = &self.menu.offers[level][prototype];
                let found = looks.iter().zip(offers).find(|(look, _)| is_it(look));
                let error = found.map_or(0.0, |(_, offer)| offer.error);
                sum += error * self.scales[level][prototype];
            }
        }
        sum
    }
}

/// Finds and measures all forms.
///
/// `cutouts` holds the leaf kinds, whose places `leaves` gives; `turns` how the mean node of each level
/// stands; `budgets` what the forms are meant for; `atlas_size` the edge of the atlas that will show them, texels. Each prototype is a step of `progress`.
///
/// # Errors
/// If a sub-tree is too large for 32-bit indices, or `progress` says so.
pub fn forms(
    tree: &Tree,
    lod: &Lod,
    leaves: &CrossQuads,
    cutouts: &Cutouts,
    (turns, budgets, atlas_size): (&[Quat], &[u64], u32),
    progress: &dyn Progress,
) -> Result<Forms, MeasureError> {
    let gauge = Gauge {
        tree,
        quads: leaves,
        cutouts,
        turns,
        budgets,
        atlas_size,
        progress,
    };
    let seats: Vec<(usize, usize)> = (0..tree.levels.len())
        .flat_map(|l| (0..tree.levels[l].prototypes.len()).map(move |p| (l, p)))
        .collect();
    progress.begin("measuring forms", seats.len() as u64);
    let scenes = gauge.scenes(CONTEXT_CARDS)?;
    let measure = |&seat: &(usize, usize)| {
        let found = gauge.forms_of(&scenes, seat, lod)?;
        progress.step();
        Ok(found)
    };
    let found: Result<Vec<Found>, MeasureError> = seats.par_iter().map(measure).collect();
    let mut found = found?.into_iter();
    let found: Vec<Vec<Found>> = tree
        .levels
        .iter()
        .map(|l| found.by_ref().take(l.prototypes.len()).collect())
        .collect();
    let seen = seen_parts(&gauge, &scenes, &found)?;
    let mut forms = Forms {
        looks: rows(tree, Vec::new()),
        menu: Menu {
            offers: rows(tree, Vec::new()),
        },
        turns: rows(tree, 0.0),
        scales: squared_scales(tree),
    };
    for (level, found) in found.into_iter().enumerate() {
        for (prototype, found) in found.into_iter().enumerate() {
            forms.turns[level][prototype] = found.turn;
            let shifts = found.shifts.iter().copied().chain(core::iter::repeat(0.0));
            let mut own: Vec<(Look, Offer)> = found
                .forms
                .into_iter()
                .zip(shifts)
                .map(|((look, offer), shift)| {
                    let error = offer.error * seen.parts[level] + seen.inside(level, shift);
                    (look, Offer { error, ..offer })
                })
                .collect();
            keep_the_useful(&mut own);
            for (look, offer) in own {
                forms.looks[level][prototype].push(look);
                forms.menu.offers[level][prototype].push(offer);
            }
        }
    }
    Ok(forms)
}

fn rows<T: Clone>(tree: &Tree, value: T) -> Vec<Vec<T>> {
    tree.levels
        .iter()
        .map(|l| vec![value.clone(); l.prototypes.len()])
        .collect()
}

/// By level: the part of the errors, measured on the nodes of one parent, that is seen in the whole tree.
///
/// Nodes hide each other's errors. How much is measured with all nodes of a level as crossed quads at once,
/// against the sum of what they were found to err one parent at a time; other forms of the level are taken to
/// be hidden alike.
fn seen_parts(
    gauge: &Gauge<'_>,
    scenes: &Scenes,
    found: &[Vec<Found>],
) -> Result<Seen, MeasureError> {
    let scales = squared_scales(gauge.tree);
    let nodes = gauge.tree.nodes();
    let area = scenes.of((0, 0)).map_or(0.0, Scene::area);
    let sums: Vec<f32> = scales.iter().map(|s| s.iter().sum()).collect();
    let counts = nodes.iter().map(|n| n.iter().sum::<u64>());
    let weights = sums.iter().zip(counts).map(|(&sum, count)| {
        #[expect(clippy::cast_precision_loss, reason = "a mean needs few digits")]
        let mean_scale = (sum / (count.max(1) as f32)).sqrt();
        let radius = (area / PI).sqrt().max(1e-9);
        INSIDE * area / sum.max(1e-12) * mean_scale / radius
    });
    let weights: Vec<f32> = weights.collect();
    let mut parts = vec![1.0; found.len()];
    for (level, found) in found.iter().enumerate().skip(1) {
        let crosses: Vec<Option<(&[TrialQuad], f32)>> = found
            .iter()
            .map(|f| {
                f.cross
                    .as_ref()
                    .map(|(quads, _)| (&quads[..], f.cross_scale))
            })
            .collect();
        let expected: f32 = found
            .iter()
            .zip(&scales[level])
            .filter_map(|(f, scale)| f.cross.as_ref().map(|(_, error)| error * scale))
            .sum();
        if expected > 0.0 {
            let error = gauge.level_error(scenes, level, &crosses)?;
            parts[level] = (error / expected).clamp(SEEN[0], SEEN[1]);
        }
    }
    Ok(Seen { parts, weights })
}

/// How errors of single nodes add up in the whole tree.
struct Seen {
    /// By level: the part of a node's error that is seen.
    parts: Vec<f32>,
    /// By level: error inside the crown for each metre that things are shifted, square metres at scale 1.
    weights: Vec<f32>,
}

impl Seen {
    /// Error inside the silhouette: leaves that are shown away from their places are lit and hidden wrongly,
    /// and slide against each other as the view turns. Silhouettes of dense crowns do not show it.
    fn inside(&self, level: usize, shift: f32) -> f32 {
        shift * self.weights[level]
    }
}

/// Weight of the error inside the crown: so much of the visible area counts as wrong where things are shifted
/// by the crown's radius. Set by eye.
const INSIDE: f32 = 0.25;

/// Bounds of the part of errors that is seen.
const SEEN: [f32; 2] = [0.02, 1.5];

/// By level and prototype: the sum of its nodes' squared scales.
fn squared_scales(tree: &Tree) -> Vec<Vec<f32>> {
    let mut sums = rows(tree, 0.0_f32);
    if let Some(first) = sums.first_mut().and_then(|s| s.first_mut()) {
        *first = 1.0;
    }
    for level in 0..tree.levels.len() {
        for (prototype, shared) in tree.levels[level].prototypes.iter().enumerate() {
            let sum = sums[level][prototype];
            for link in &shared.links {
                let scale = link.place.scale;
                sums[link.level as usize][link.prototype as usize] += sum * scale * scale;
            }
        }
    }
    sums
}

/// Closed forms that are hardly better than one with fewer triangles are no use: each takes its part of the
/// atlas. Crossed quads always stay, and full detail of the node's own branch.
fn keep_the_useful(forms: &mut Vec<(Look, Offer)>) {
    let offers: Vec<Offer> = forms.iter().map(|(_, o)| *o).collect();
    forms.retain(|(look, offer)| {
        let gain = if offer.open { 1.0 } else { USEFUL };
        let beaten = offers.iter().any(|other| {
            // Of two that are nearly alike, one must stay.
            let gain = if other.triangles == offer.triangles {
                1.0
            } else {
                gain
            };
            other.open == offer.open
                && other.triangles <= offer.triangles
                && (other.triangles, other.error) != (offer.triangles, offer.error)
                && other.error * gain <= offer.error
        });
        matches!(look, Look::Cross(_) | Look::Geometry(0)) || !beaten
    });
}

/// A form with more triangles must err less than this part of another's error.
const USEFUL: f32 = 0.97;
