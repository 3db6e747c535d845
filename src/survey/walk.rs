//! What only a walk over all nodes can tell: where things are in the world.

use super::foliage::Foliage;
use super::quantile::Spread;
use crate::math::{Similarity, TAU, Vec3, float, floor_to_u32};
use crate::tree::{Branch, Kind, Part, Tree};

/// Height at which stems are measured, metres.
const BREAST: f32 = 1.3;

/// Directions in which the crown's width is taken, over half a turn.
const DIRECTIONS: usize = 18;

/// Part of the leaf area that may hang below the crown's base, or stand on limbs below it: stray shoots.
const STRAY: f64 = 0.02;

/// Limbs count as leafy from this part of the largest one's leaf area on: what bears fruit only is no frond.
const LEAFY: f64 = 0.25;

/// Steps in which heights are counted, a metre; and angles, a degree.
const STEPS: f32 = 100.0;
const ANGLE_STEPS: f32 = 10.0;

/// Leaf area and blades of every prototype's sub-tree at scale 1. Area goes with the square of the scale.
#[derive(Debug)]
pub(super) struct Below {
    area: Vec<Vec<f64>>,
    blades: Vec<Vec<u64>>,
}

impl Below {
    pub(super) fn of(tree: &Tree, foliage: &[Foliage]) -> Self {
        let zeros = |l: &crate::tree::TreeLevel| l.prototypes.len();
        let mut below = Self {
            area: tree.levels.iter().map(|l| vec![0.0; zeros(l)]).collect(),
            blades: tree.levels.iter().map(|l| vec![0; zeros(l)]).collect(),
        };
        for level in (0..tree.levels.len()).rev() {
            for (index, prototype) in tree.levels[level].prototypes.iter().enumerate() {
                let (mut area, mut blades) = match prototype.part {
                    Part::Leaf { kind, .. } => foliage
                        .get(usize::from(kind))
                        .map_or((0.0, 0), |f| (f64::from(f.area_m2), u64::from(f.blades))),
                    Part::Branch(_) | Part::Stool => (0.0, 0),
                };
                for link in &prototype.links {
                    let (l, p) = (usize::from(link.level), usize::from(link.prototype));
                    let scale = f64::from(link.place.scale);
                    area += below.area[l][p] * scale * scale;
                    blades = u64::saturating_add(blades, below.blades[l][p]);
                }
                below.area[level][index] = area;
                below.blades[level][index] = blades;
            }
        }
        below
    }

    /// Leaf area of the tree, square metres.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "square metres to seven digits"
    )]
    pub(super) fn area(&self) -> f32 {
        self.area
            .first()
            .and_then(|l| l.first())
            .map_or(0.0, |&a| a as f32)
    }

    /// Blades of the tree.
    pub(super) fn blades(&self) -> u64 {
        self.blades
            .first()
            .and_then(|l| l.first())
            .copied()
            .unwrap_or(0)
    }
}

/// Smallest and largest reach along each direction.
#[derive(Debug)]
struct Reach([(f32, f32); DIRECTIONS]);

impl Reach {
    const NONE: Self = Self([(f32::INFINITY, f32::NEG_INFINITY); DIRECTIONS]);

    fn add(&mut self, compass: &[(f32, f32); DIRECTIONS], point: Vec3) {
        for ((low, high), (sine, cosine)) in self.0.iter_mut().zip(compass) {
            let along = point.x * cosine + point.z * sine;
            *low = low.min(along);
            *high = high.max(along);
        }
    }

    fn mean_diameter(&self) -> Option<f32> {
        let sum: f32 = self.0.iter().map(|(low, high)| high - low).sum();
        let count = u32::try_from(DIRECTIONS).unwrap_or(1);
        (sum > 0.0).then(|| sum / float(count))
    }
}

/// All that a walk gathers.
#[derive(Debug)]
pub(super) struct Walked {
    /// Highest point, metres.
    pub(super) height: f32,
    leaves: Reach,
    wood: Reach,
    /// Leaf area by height.
    area_by_height: Vec<f64>,
    /// Height at which each limb leaves its stem, and its leaf area.
    limbs: Vec<(f32, f64)>,
    /// Diameter of each stem at breast height, metres.
    diameters: Vec<f32>,
    /// By order from 1 on: how many branches have each angle.
    angles: Vec<Vec<u64>>,
}

/// Walks all nodes of a tree.
pub(super) fn walk(tree: &Tree, below: &Below, foliage: &[Foliage]) -> Walked {
    let compass = core::array::from_fn(|i| {
        let i = float(u32::try_from(i).unwrap_or(0));
        libm::sincosf(i * TAU * 0.5 / float(u32::try_from(DIRECTIONS).unwrap_or(1)))
    });
    let stool = tree.levels.first().is_some_and(|l| l.kind == Kind::Stool);
    let mut walker = Walker {
        tree,
        below,
        foliage,
        compass,
        first: usize::from(stool),
        found: Walked {
            height: 0.0,
            leaves: Reach::NONE,
            wood: Reach::NONE,
            area_by_height: Vec::new(),
            limbs: Vec::new(),
            diameters: Vec::new(),
            angles: Vec::new(),
        },
    };
    if !tree.levels.is_empty() {
        walker.node(0, 0, &Similarity::IDENTITY, 1.0, false);
    }
    walker.found
}

struct Walker<'a> {
    tree: &'a Tree,
    below: &'a Below,
    foliage: &'a [Foliage],
    compass: [(f32, f32); DIRECTIONS],
    /// Depth of the stems.
    first: usize,
    found: Walked,
}

impl Walker<'_> {
    /// `measured`: the stem that carries this node was measured at breast height.
    fn node(
        &mut self,
        level: usize,
        prototype: usize,
        place: &Similarity,
        thickness: f32,
        mut measured: bool,
    ) {
        let shared = self.tree.prototype(level, prototype);
        let depth = self.tree.levels[level].depth;
        match &shared.part {
            Part::Stool => {}
            Part::Leaf {
                kind,
                length,
                width,
                ..
            } => self.card(usize::from(*kind), *length, *width, place),
            Part::Branch(branch) => {
                self.wood(branch, place, depth > self.first);
                // A stem that ends below breast height is measured on the limbs that go on there.
                if !measured
                    && depth <= self.first + 1
                    && let Some(diameter) = diameter(branch, place, thickness)
                {
                    self.found.diameters.push(diameter);
                    measured = true;
                }
            }
        }
        for link in &shared.links {
            let (l, p) = (usize::from(link.level), usize::from(link.prototype));
            let child = self.tree.place(place, link);
            if let Part::Branch(branch) = &shared.part {
                self.leaves_parent(branch, place, link.at, depth, (l, p), &child);
            }
            self.node(l, p, &child, link.thickness, measured);
        }
    }

    fn card(&mut self, kind: usize, length: f32, width: f32, place: &Similarity) {
        let area = self.foliage.get(kind).map_or(0.0, |f| f.area_m2) * place.scale * place.scale;
        // The four ends of what a blade or a shoot fills; the card's corners are empty.
        let middle = Vec3::Y * (length * 0.5);
        let half = Vec3::X * (width * 0.5);
        for point in [Vec3::ZERO, Vec3::Y * length, middle + half, middle - half] {
            let point = place.point(point);
            self.found.height = self.found.height.max(point.y);
            self.found.leaves.add(&self.compass, point);
        }
        let at = floor_to_u32(place.point(middle).y.max(0.0) * STEPS) as usize;
        if self.found.area_by_height.len() <= at {
            self.found.area_by_height.resize(at + 1, 0.0);
        }
        self.found.area_by_height[at] += f64::from(area);
    }

    fn wood(&mut self, branch: &Branch, place: &Similarity, in_crown: bool) {
        for sample in branch.axis.iter().step_by(8).chain(branch.axis.last()) {
            let point = place.point(sample.position);
            self.found.height = self.found.height.max(point.y);
            if in_crown {
                self.found.wood.add(&self.compass, point);
            }
        }
    }

    /// What is measured where a child leaves a branch.
    fn leaves_parent(
        &mut self,
        parent: &Branch,
        place: &Similarity,
        at: f32,
        depth: usize,
        (level, prototype): (usize, usize),
        child: &Similarity,
    ) {
        if depth == self.first {
            let height = place.point(parent.at(at).position).y;
            let scale = f64::from(child.scale);
            let area = self.below.area[level][prototype] * scale * scale;
            self.found.limbs.push((height, area));
        }
        if let Part::Branch(branch) = &self.tree.prototype(level, prototype).part {
            let axis = place.rotation * (parent.at(at).frame * Vec3::Y);
            let chord = child.rotation * (branch.at(0.1).position - branch.axis[0].position);
            let angle = libm::atan2f(axis.cross(chord).length(), axis.dot(chord)).to_degrees();
            let order = depth - self.first;
            if self.found.angles.len() <= order {
                self.found.angles.resize(order + 1, Vec::new());
            }
            let counts = &mut self.found.angles[order];
            counts.resize(1801, 0);
            let step = crate::math::round_to_u32(angle * ANGLE_STEPS) as usize;
            counts[step.min(1800)] += 1;
        }
    }
}

/// Diameter of a stem where it first rises past breast height, metres.
fn diameter(branch: &Branch, place: &Similarity, thickness: f32) -> Option<f32> {
    let height = |i: usize| place.point(branch.axis[i].position).y;
    let after = (1..branch.axis.len()).find(|&i| height(i - 1) < BREAST && height(i) >= BREAST)?;
    let part = (BREAST - height(after - 1)) / (height(after) - height(after - 1));
    let (a, b) = (branch.axis[after - 1].radius, branch.axis[after].radius);
    Some(2.0 * (a + (b - a) * part) * place.scale * thickness)
}

impl Walked {
    /// Diameter of one stem as thick as all together, metres.
    pub(super) fn dbh(&self) -> Option<f32> {
        let squares: f32 = self.diameters.iter().map(|d| d * d).sum();
        (squares > 0.0).then(|| squares.sqrt())
    }

    /// Stems measured.
    pub(super) fn stems(&self) -> u32 {
        u32::try_from(self.diameters.len()).unwrap_or(u32::MAX)
    }

    pub(super) fn crown_width(&self) -> Option<f32> {
        self.leaves.mean_diameter().or(self.wood.mean_diameter())
    }

    /// Height below which stray leaves hang, metres.
    pub(super) fn crown_base(&self) -> Option<f32> {
        let total: f64 = self.area_by_height.iter().sum();
        let mut passed = 0.0;
        let at = self.area_by_height.iter().position(|area| {
            passed += area;
            total > 0.0 && passed >= total * STRAY
        })?;
        Some(float(u32::try_from(at).ok()?) / STEPS)
    }

    /// Height of the lowest limbs over the tree's.
    pub(super) fn clear_bole(&self) -> Option<f32> {
        let mut limbs = self.limbs.clone();
        limbs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = limbs.iter().map(|limb| limb.1).sum();
        let mut passed = 0.0;
        let lowest = limbs.iter().find(|limb| {
            passed += limb.1;
            total > 0.0 && passed >= total * STRAY
        })?;
        (self.height > 0.0).then(|| (lowest.0 / self.height).clamp(0.0, 1.0))
    }

    /// Limbs that bear leaves.
    pub(super) fn leafy_limbs(&self) -> u32 {
        let largest = self.limbs.iter().map(|limb| limb.1).fold(0.0, f64::max);
        let leafy = self
            .limbs
            .iter()
            .filter(|limb| limb.1 > 0.0 && limb.1 >= largest * LEAFY);
        u32::try_from(leafy.count()).unwrap_or(u32::MAX)
    }

    /// Insertion angles by order, degrees, as far as there are branches.
    pub(super) fn insertion(&self) -> Vec<Spread> {
        let angle = |step: usize| float(u32::try_from(step).unwrap_or(0)) / ANGLE_STEPS;
        self.angles
            .iter()
            .map_while(|counts| {
                let counts = counts.iter().enumerate();
                let angles: Vec<(f32, u64)> = counts.map(|(step, &n)| (angle(step), n)).collect();
                Spread::weighted(&angles)
            })
            .collect()
    }
}
