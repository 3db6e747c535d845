//! Strips on the menu of forms: which are tried, and what they err.
//!
//! Technique and geometry: `impostor::planes::strips`. A set of planes is captured once, and its strips are
//! measured with more and more segments for as long as that helps.

use super::context::{Context, Gauge, TrialQuad, cards};
use super::menu::Set;
use super::trials::{FITTED_CARDS, best_scale};
use crate::impostor::planes::strips::{self, Bend, Fit};
use crate::impostor::planes::{self, Item, Plane};
use crate::mesh::{Mesh, TooLarge};
use crate::species::schema::ClosedForm;
use crate::tree::{Branch, Part};

/// Numbers of segments that are tried.
const SEGMENTS: [usize; 7] = [1, 2, 3, 4, 6, 8, 12];

/// Numbers of strips that are tried.
const STRIPS: [usize; 4] = [1, 2, 3, 4];

/// A branch's collar, against its radius: what lies within is the branch itself.
const STEM: f32 = 1.7;

/// Leaves that stray from their wings by more than this part of what leaves evenly around the branch would are
/// left to other forms: strips of bushy twigs would be thin slices.
const FLAT: f32 = 0.6;

/// More segments must lower the error by this part, or no more are tried.
const GAIN: f32 = 0.03;

/// One kind of strips with what was measured.
pub(super) struct Strip {
    pub(super) set: Set,
    pub(super) error: f32,
    pub(super) triangles: u64,
    /// Mean distance of what it shows from where it shows it, metres.
    pub(super) shift: f32,
}

impl Gauge<'_> {
    /// The strips of a prototype that are worth trying, or those that a script asks for.
    pub(super) fn strips(
        &self,
        (level, prototype): (usize, usize),
        forced: Option<ClosedForm>,
        context: &Context<'_>,
        bent: &[Item],
    ) -> Result<Vec<Strip>, TooLarge> {
        let counts: Vec<(usize, Vec<usize>)> = match forced {
            None => STRIPS.iter().map(|&n| (n, SEGMENTS.to_vec())).collect(),
            Some(ClosedForm::Strips(n, m)) => vec![(n as usize, vec![m as usize])],
            Some(_) => return Ok(Vec::new()),
        };
        let Part::Branch(branch) = &self.tree.prototype(level, prototype).part else {
            return Ok(Vec::new());
        };
        if forced.is_none() && (level == 0 || cards(self.tree, level, prototype) > FITTED_CARDS) {
            return Ok(Vec::new());
        }
        let mesh = self.straightened(level, prototype)?;
        let straight = Straight {
            gauge: self,
            branch,
            context,
            bent,
            items: planes::items(&mesh),
            mesh,
        };
        let mut found = Vec::new();
        for (count, segments) in counts {
            let wings = strips::wings(&straight.items, count, branch.radius * STEM);
            if forced.is_none() && strips::spread(&straight.items, &wings) > FLAT {
                continue;
            }
            found.extend(straight.measured(wings, &segments));
        }
        Ok(found)
    }
}

/// A straightened sub-tree, and where its strips are measured.
struct Straight<'a> {
    gauge: &'a Gauge<'a>,
    branch: &'a Branch,
    context: &'a Context<'a>,
    mesh: Mesh,
    items: Vec<Item>,
    /// The same items where they belong.
    bent: &'a [Item],
}

impl Straight<'_> {
    /// Measures planes with rising numbers of segments.
    fn measured(&self, planes: Vec<Plane>, segments: &[usize]) -> Vec<Strip> {
        let trial = |plane: &Plane| {
            let part = planes::part(&self.mesh, &self.items, plane);
            TrialQuad::of(&part, plane, self.gauge.cutouts, self.context.sample)
        };
        let quads: Vec<TrialQuad> = planes.iter().map(trial).collect();
        let fit = Fit {
            planes: &planes,
            bend: &Bend::of(self.branch),
            items: &self.items,
            bent: self.bent,
        };
        let mut found: Vec<Strip> = Vec::new();
        let mut cuts = Vec::new();
        if planes.is_empty() {
            return found;
        }
        for &segments in segments {
            cuts = fit.cut(cuts, segments);
            let strips = fit.strips(&cuts);
            let triangles = strips.iter().map(strips::Strip::triangles).sum();
            if found.last().is_some_and(|s| s.triangles == triangles) {
                break;
            }
            let (scale, error) = best_scale(|s| self.context.try_strips(&quads, &strips, s));
            let before = found.last().map_or(f32::INFINITY, |s| s.error);
            let shift = fit.mean_shift(&strips);
            found.push(Strip {
                set: Set {
                    planes: planes.clone(),
                    scales: vec![scale; planes.len()],
                    name: format!("strips {}x{}", planes.len(), cuts.len() + 1),
                    strips,
                },
                error,
                triangles,
                shift,
            });
            if error > before * (1.0 - GAIN) {
                break;
            }
        }
        found
    }
}
