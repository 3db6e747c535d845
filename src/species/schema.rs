//! What a species script says, as plain data. Lengths are metres and angles degrees *here* (they are
//! what the author wrote); growth turns them into radians.

mod leaf;

use crate::math::{float, round_to_u32};

pub use super::bark::{Bark, BarkArt, BarkPattern};
pub use leaf::*;

/// The script format that this version reads and writes.
pub const FORMAT: u32 = 1;

/// The season of a script that says none.
pub const SUMMER: f32 = 1.0;

/// One species: a tree as a hierarchy of branching levels (Koniaris et al., section IV).
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// Common name, such as `Olive`.
    pub name: String,
    /// Botanical name; may be empty.
    pub latin: String,
    /// File-name form of the name: lower-case letters, digits and `-`.
    pub slug: String,
    /// Seed used when none is given on the command line.
    pub seed: u64,
    /// Diameter of the trunk as a part of a mature tree's, 0.05..=1.5: about 0.1 a sapling, 0.4 young, 1 mature,
    /// 1.3 a veteran.
    pub age: f32,
    /// Where it has grown up.
    pub habit: Habit,
    /// 0 spring, 1 summer, 2 autumn, 3 winter, and anything between: what leaves are drawn in that do not say
    /// otherwise, and whether those that turn have fallen.
    pub season: f32,
    /// Trees of the kind that are worth keeping, by name.
    pub variations: Vec<Variation>,
    /// Several stems out of one stool; `None` is a single trunk.
    pub stems: Option<Stems>,
    /// Branching levels, the trunk first. A level hangs on the one before it unless it says `on`.
    pub levels: Vec<Level>,
    /// Named spline shapes.
    pub splines: Vec<Spline>,
    /// Named leaf kinds.
    pub leaves: Vec<LeafKind>,
    /// The bark of every branch.
    pub bark: Bark,
    /// How the LOD chain is made.
    pub lod: Lod,
    /// Files that the script names (splines, images), relative to it, in the order of the script.
    pub files: Vec<String>,
}

/// Where a tree has grown up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Habit {
    /// In the open, with light from all sides: as the levels describe it.
    #[default]
    Open,
    /// Among others: higher on a thinner trunk, with a narrower crown that begins higher.
    Forest,
}

/// A tree of the kind that is worth keeping: what it sets in place of the script's own word.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    /// Unique name; lower-case letters, digits and `-`, as it becomes part of a pack's name.
    pub name: String,
    /// Seed.
    pub seed: u64,
    /// Age, if it is another one.
    pub age: Option<f32>,
    /// Habit, if it is another one.
    pub habit: Option<Habit>,
    /// Season, if it is another one.
    pub season: Option<f32>,
}

/// Stems of a multi-stemmed tree: the whole tree becomes a level of its own above the stems.
#[derive(Clone, Debug, PartialEq)]
pub struct Stems {
    /// How many, 1..=64.
    pub count: u32,
    /// Radius of the ring on which they stand, metres.
    pub spread_m: f32,
    /// Lean outward from the vertical, degrees, by stem (position 0 is the first, 1 the last).
    pub lean: Param,
    /// Size of each stem.
    pub scale: Param,
}

/// One branching level: where its nodes sit on their parents, and what each of them is.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Unique name; also the key of its random draws.
    pub name: String,
    /// Index of the level whose branches carry it; `None` for the trunk.
    pub parent: Option<usize>,
    /// How its nodes sit on a parent. Ignored for the trunk, except `scale` and `around`.
    pub placement: Placement,
    /// Branch or leaf.
    pub kind: LevelKind,
}

/// What the nodes of a level are.
#[derive(Clone, Debug, PartialEq)]
pub enum LevelKind {
    /// Branches, which may carry further levels.
    Branch(BranchParams),
    /// Leaf cards, which carry nothing.
    Leaf(LeafParams),
}

/// How the children of one parent are placed. Positions run over 0..=1 of the parent's arc length.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Places along each parent at which children grow.
    pub links: u32,
    /// Children at each place, evenly spread around the parent: 1 spiral, 2 opposite, more a whorl.
    pub children: u32,
    /// First position on the parent.
    pub start: f32,
    /// Last position on the parent.
    pub end: f32,
    /// Random shift of each place, as a part of the distance between places (0..=1).
    pub jitter: f32,
    /// Bends the even spacing: places sit at `u^crowding` of the way; 1 even, below 1 crowded to the end.
    pub crowding: f32,
    /// Levels that a place skips, by its part of all places (0 the first or only one, 1 the last), rounded: 1 carries a node of
    /// the level after this one at once.
    pub skip: Curve,
    /// y rotation: turn about the parent's axis.
    pub around: Param,
    /// x rotation: angle away from the parent's axis.
    pub down: Param,
    /// z rotation: sideways tilt.
    pub sideways: Param,
    /// Turn about the child's own axis.
    pub spin: Param,
    /// Size of the child with all that grows on it.
    pub scale: Param,
    /// Thickness of the child's own tube, on top of what its parent's thickness there gives it.
    pub thickness: Param,
    /// Rigid turn of each node when it is placed: 1 points it straight up, -1 straight down.
    pub tropism: f32,
    /// Largest distance of a child's tip from the tree's axis, by height of the tip; shrinks children.
    pub envelope: Option<Envelope>,
}

impl Placement {
    /// Levels that place `index` skips.
    #[must_use]
    pub fn skipped(&self, index: u32) -> u32 {
        let last = self.links.saturating_sub(1).max(1);
        round_to_u32(self.skip.at(float(index) / float(last)))
    }

    /// Most levels that a place skips.
    #[must_use]
    pub fn most_skipped(&self) -> u32 {
        (0..self.links).map(|i| self.skipped(i)).max().unwrap_or(0)
    }
}

/// A surface of revolution about the trunk's foot that the tips of a level stay within.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    /// Height of the envelope's top, metres.
    pub height_m: f32,
    /// Radius in metres by height (0 the ground, 1 the top).
    pub radius_m: Curve,
}

/// Parameters of a branch level's prototypes.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchParams {
    /// How many distinct prototypes the level has; 1 is the paper.
    pub variants: u32,
    /// Splines to choose from, by index into [`Species::splines`], with weights.
    pub splines: Vec<(usize, f32)>,
    /// Length along the branch.
    pub length: Size,
    /// Random part of the length (0.1 is 10 % either way), one draw a prototype.
    pub length_vary: f32,
    /// Radius at the base. `OfParent` means of the parent's radius where the branch leaves it.
    pub radius: Size,
    /// Radius along the branch, as a factor of the base radius.
    pub taper: Curve,
    /// Part that the pipe model has in the taper, 0..=1: 1 keeps the cross-section at every fork.
    pub pipe_model: f32,
    /// Sideways wander of the control points, as a part of the length; one draw a control point.
    pub gnarl: f32,
    /// Widening where a branch leaves its parent, as a factor above 1 of its own radius.
    pub collar: f32,
    /// Root flare at the foot.
    pub flare: Option<Flare>,
    /// Flutes: lengthwise lobes of the cross-section.
    pub flutes: Option<Flutes>,
    /// Corners of the cross-section at full detail.
    pub sides: u32,
}

/// A length in metres, or relative to the parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// Metres, at scale 1.
    Metres(f32),
    /// A factor of the parent prototype's.
    OfParent(f32),
}

/// Widening at the foot of a trunk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flare {
    /// Height over which it fades, metres.
    pub height_m: f32,
    /// Extra radius at the ground, as a factor of the base radius.
    pub amount: f32,
    /// Buttresses around the foot; 0 is round.
    pub lobes: u32,
    /// Depth of the buttresses, 0..=1.
    pub depth: f32,
}

/// Lengthwise lobes of a stem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flutes {
    /// How many around the stem.
    pub count: u32,
    /// Depth, as a part of the radius (0..=0.5).
    pub depth: f32,
    /// Turns about the axis over the branch's length.
    pub twist_turns: f32,
}

/// Parameters of a leaf level.
#[derive(Clone, Debug, PartialEq)]
pub struct LeafParams {
    /// Leaf kinds to choose from, by index into [`Species::leaves`], with weights.
    pub kinds: Vec<(usize, f32)>,
}

/// A number that may depend on the position on the parent, on the link, and on chance.
///
/// The value at a link is `at(position) + step * link + vary * r` for angles, and
/// `at(position) * (1 + vary * r)` for sizes (which have no `step`), with `r` in -1..1.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Value by position on the parent.
    pub at: Curve,
    /// Added once more for each link (137.5 makes a spiral).
    pub step: f32,
    /// Random part.
    pub vary: f32,
}

impl Param {
    /// The same value everywhere.
    #[must_use]
    pub fn constant(value: f32) -> Self {
        Self {
            at: Curve::constant(value),
            step: 0.0,
            vary: 0.0,
        }
    }
}

/// A function on 0..=1, straight between its points and flat beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// At least one (position, value), positions strictly rising.
    pub points: Vec<(f32, f32)>,
}

impl Curve {
    /// The same value everywhere.
    #[must_use]
    pub fn constant(value: f32) -> Self {
        Self {
            points: vec![(0.0, value)],
        }
    }

    /// The value at `x`.
    #[must_use]
    pub fn at(&self, x: f32) -> f32 {
        let after = self.points.partition_point(|&(position, _)| position <= x);
        match (
            after.checked_sub(1).and_then(|i| self.points.get(i)),
            self.points.get(after),
        ) {
            (Some(&(x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * ((x - x0) / (x1 - x0)),
            (Some(&(_, y)), None) | (None, Some(&(_, y))) => y,
            (None, None) => 0.0,
        }
    }

    /// Largest value over all positions.
    #[must_use]
    pub fn max(&self) -> f32 {
        self.points
            .iter()
            .map(|&(_, y)| y)
            .fold(f32::NEG_INFINITY, f32::max)
    }
}

/// A named spline shape. Its control points are scaled so that the curve's length is the branch's.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Unique name.
    pub name: String,
    /// At least two control points; the branch starts at the first and grows mainly along +Y.
    pub points: Vec<[f32; 3]>,
    /// Parametrisation.
    pub knots: Knots,
}

/// Spacing of a Catmull-Rom spline's parameter between control points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Knots {
    /// Square root of the distance: no loops or cusps (Yuksel, Schaefer, Keyser 2011).
    #[default]
    Centripetal,
    /// Equal steps: the classic form.
    Uniform,
    /// The distance itself.
    Chordal,
}

/// How the LOD chain is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Lod {
    /// Triangle budgets used when none are given on the command line, falling.
    pub budgets: Vec<u64>,
    /// Order in which simplifications are tried at each collapse depth.
    pub priorities: Vec<Simplification>,
    /// Spline tolerances, as parts of the branch's length, rising; one a geometry LOD.
    pub tolerances: Vec<f32>,
    /// How LODs are chosen under their budgets.
    pub selector: LodSelector,
    /// True to scale each LOD's quads so that it covers as much as full detail.
    pub calibrate: bool,
    /// By name of a branch level, the one closed form that its nodes may take; any fits the others.
    pub forms: Vec<(String, ClosedForm)>,
}

/// How LODs are chosen under their budgets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LodSelector {
    /// Node by node, unless level-wide steps look better.
    #[default]
    Cut,
    /// Level by level, as in the paper.
    Levels,
}

/// The flat stand-in for a node with all that grows on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosedForm {
    /// Two upright crossed quads.
    Cross,
    /// Two upright crossed quads and a level one.
    CrossTop,
    /// Three upright quads, 60 degrees apart, and a level one.
    StarTop,
    /// This many planes, 1..=64, fitted to the node.
    Planes(u32),
    /// This many strips, 1..=4, each of so many segments, 1..=16, along the node's branch.
    Strips(u32, u32),
}

/// The three kinds of simplification of the paper (its section IV.E).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simplification {
    /// Coarser spline geometry.
    Splines,
    /// Branch geometry to textured quads.
    Branches,
    /// A whole level with all below it to textured cross-quads.
    Levels,
}

impl Default for Lod {
    fn default() -> Self {
        Self {
            budgets: vec![10_000, 2_000, 400, 8],
            priorities: vec![
                Simplification::Splines,
                Simplification::Branches,
                Simplification::Levels,
            ],
            tolerances: vec![0.004, 0.01, 0.025, 0.06, 0.15],
            selector: LodSelector::Cut,
            calibrate: true,
            forms: Vec::new(),
        }
    }
}
