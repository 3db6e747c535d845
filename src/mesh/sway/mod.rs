//! How every vertex of a mesh sways: the data that [`crate::wind`] reads, worked out when the tree is built.
//!
//! Home of: Candussi et al. 2005, section 2.2, the part that is precomputed. Each branch has a flexibility
//! (`tree::flex`); a vertex moves with every branch that carries it, as far as that branch has bent where the
//! way to the vertex leaves it. A walk in the order of flattening gathers the sums, beside the vertices and
//! after them, so that the walk which writes vertices stays as fast as it is.
//!
//! Where a node is closed, what stands for it sways as the leaves that it shows (`inside.rs`): neighbouring
//! LODs sway together. Limbs inside one stand-in swing out of step, and the less their sum swings; that part
//! of their lean is spread over the three bands, whose different frequencies keep its swing small.
//!
//! Guarantees: the base of the first level and of what the ground holds stays; no joint opens, since children
//! follow the line that their parent is drawn as; the same bytes at any number of threads.

mod drawn;
mod inside;

use self::drawn::Drawn;
use self::inside::{BANDS, OWN, PHASOR, Way};
use super::template::{Material, Template};
use super::{Form, Mesh, Wardrobe};
use crate::math::{Similarity, TAU, Vec3, byte_from_unit};
use crate::rng::{Key, Parameter};
use crate::tree::{Kind, Link, Part, Tree, flex};
use crate::wind::{Rig, Sway};

/// Limbs swing out of step by at most this part of a turn: a crown never cancels its own sway.
const PHASES: f32 = 0.5;

/// Frequency of a branch of one metre, hertz; it falls with the root of the length, as a pendulum's.
const HZ_AT_1_M: f32 = 1.2;

/// Largest turn of a leaf of one metre in the reference wind, radians; it falls with the root of its size.
const LEAF_ANGLE: f32 = 0.12;

/// Wood counts this much less than leaves where a stand-in's samples are spread.
const WOOD: f64 = 0.3;

/// Vertices of a first-level stand-in below this part of its height are its foot.
const FOOT: f32 = 0.02;

/// What all nodes need to know of a tree.
struct Shared<'a> {
    tree: &'a Tree,
    /// By level: band in which its own branches move.
    bands: Vec<usize>,
    /// By level: its number in the script, where there is no level of stools.
    numbers: Vec<u8>,
    /// By level and prototype: [`flex::flexure`].
    flexures: Vec<Vec<f32>>,
    /// By level and prototype: area of all its leaves, and a part of that of its wood, at scale 1.
    areas: Vec<Vec<f64>>,
}

impl<'a> Shared<'a> {
    fn new(tree: &'a Tree) -> Self {
        let mut ranks: Vec<usize> = Vec::new();
        for level in &tree.levels {
            let above = level.parent.map_or(0, |p| {
                ranks[p] + usize::from(tree.levels[p].kind == Kind::Branch)
            });
            ranks.push(above);
        }
        let flexures = tree.levels.iter();
        let stools = tree.levels.iter().filter(|l| l.kind == Kind::Stool).count();
        let number = |level: usize| u8::try_from(level.saturating_sub(stools)).unwrap_or(u8::MAX);
        let mut shared = Self {
            tree,
            numbers: (0..tree.levels.len()).map(number).collect(),
            bands: ranks.into_iter().map(|r| r.min(2)).collect(),
            flexures: flexures
                .map(|l| l.prototypes.iter().map(flex::flexure).collect())
                .collect(),
            areas: tree
                .levels
                .iter()
                .map(|l| vec![0.0; l.prototypes.len()])
                .collect(),
        };
        for level in (0..tree.levels.len()).rev() {
            for prototype in 0..tree.levels[level].prototypes.len() {
                let links = &tree.prototype(level, prototype).links;
                let area = shared.own_area((level, prototype))
                    + links.iter().map(|l| shared.area_of(l)).sum::<f64>();
                shared.areas[level][prototype] = area;
            }
        }
        shared
    }

    fn own_area(&self, (level, prototype): (usize, usize)) -> f64 {
        match &self.tree.prototype(level, prototype).part {
            Part::Stool => 0.0,
            Part::Branch(branch) => WOOD * f64::from(2.0 * branch.radius * branch.length),
            Part::Leaf { length, width, .. } => f64::from(length * width),
        }
    }

    fn area_of(&self, link: &Link) -> f64 {
        let scale = f64::from(link.place.scale);
        scale * scale * self.areas[link.level as usize][link.prototype as usize]
    }

    /// Way of the tip of a node's own branch in the reference wind, metres.
    fn tip_m(&self, (level, prototype): (usize, usize), scale: f32, thickness: f32) -> f32 {
        match &self.tree.prototype(level, prototype).part {
            Part::Branch(branch) => {
                let part = flex::tip_part(self.flexures[level][prototype], thickness);
                scale * branch.length * part
            }
            Part::Stool | Part::Leaf { .. } => 0.0,
        }
    }

    /// Phase of a child, parts of a turn: limbs have their own, what grows on them has theirs.
    fn phase(&self, (level, _): (usize, usize), link: usize, parent: f32) -> f32 {
        let first = self.bands[level] == 0 && self.tree.levels[level].kind == Kind::Branch;
        if first {
            let key = Key::of_seed(self.tree.seed).level(&self.tree.levels[level].name);
            PHASES * key.with(link as u64).unit(Parameter::Sway)
        } else {
            parent
        }
    }
}

/// Works out how the meshes of one tree sway.
pub struct Swayer<'a> {
    shared: Shared<'a>,
    rig: Rig,
}

/// What one prototype is drawn as, and how the vertices of that sway.
struct Outfit<'t> {
    template: Option<&'t Template>,
    open: bool,
    motion: Motion,
}

/// How the vertices of a template sway.
#[derive(Clone, Debug, Default)]
enum Motion {
    /// Nothing drawn, or not used.
    #[default]
    None,
    /// With the prototype's own branch: its bend at each vertex, and the line through them.
    Along(Vec<f32>, Drawn),
    /// As what is inside.
    Inside(Vec<Way>),
}

/// By level, prototype and choice.
type Closet<'t> = Vec<Vec<Vec<Outfit<'t>>>>;

/// Tells the choice of the next node, given its level.
type Choices<'c> = dyn FnMut(usize) -> Option<usize> + 'c;

/// How the place sways at which a node is fixed.
#[derive(Clone, Copy, Debug, Default)]
struct Lineage {
    /// Metres by band.
    bands: [f32; 3],
    /// Phase of the limb, parts of a turn.
    phase: f32,
    /// Hash of the way from the root, the same in all LODs.
    path: u32,
}

/// A node on the walk.
#[derive(Clone, Copy)]
struct Node {
    seat: (usize, usize),
    place: Similarity,
    thickness: f32,
    base: Lineage,
}

impl<'a> Swayer<'a> {
    /// Gathers what all meshes of the tree share.
    #[must_use]
    pub fn new(tree: &'a Tree) -> Self {
        let shared = Shared::new(tree);
        let rig = rig(&shared);
        Self { shared, rig }
    }

    /// What the attributes stand for, the same for all meshes of the tree.
    #[must_use]
    pub fn rig(&self) -> Rig {
        self.rig
    }

    /// Adds its sway to the mesh that a [`super::Flattener`] made of a form.
    pub fn form(&self, form: &Form, mesh: &mut Mesh) {
        let levels = form.templates.iter().zip(&form.open);
        let closet = levels.map(|(prototypes, &open)| {
            let outfits = prototypes.iter();
            outfits.map(|t| vec![outfit(t.as_ref(), open)]).collect()
        });
        self.add(closet.collect(), &mut || |_| Some(0), mesh);
    }

    /// Adds its sway to the mesh that [`super::front()`] made of a wardrobe and choices.
    pub fn front(&self, wardrobe: &Wardrobe, choices: &[u16], mesh: &mut Mesh) {
        let dressed = wardrobe.offers.iter().map(|prototypes| {
            let offers = prototypes.iter().map(|offers| {
                let outfits = offers.iter();
                outfits
                    .map(|d| outfit(d.template.as_ref(), d.open))
                    .collect()
            });
            offers.collect()
        });
        let begin = || {
            let mut choices = choices.iter().map(|&c| usize::from(c));
            let levels = &self.shared.tree.levels;
            move |level: usize| match levels[level].kind {
                Kind::Leaf => Some(0),
                Kind::Stool | Kind::Branch => choices.next(),
            }
        };
        self.add(dressed.collect(), &mut || begin(), mesh);
    }

    fn add<C>(&self, mut closet: Closet<'_>, begin: &mut dyn FnMut() -> C, mesh: &mut Mesh)
    where
        C: FnMut(usize) -> Option<usize>,
    {
        let mut used: Vec<Vec<Vec<bool>>> = closet
            .iter()
            .map(|l| l.iter().map(|o| vec![false; o.len()]).collect())
            .collect();
        self.mark((0, 0), &closet, &mut begin(), &mut used);
        for (level, prototypes) in closet.iter_mut().enumerate() {
            for (prototype, outfits) in prototypes.iter_mut().enumerate() {
                for (index, outfit) in outfits.iter_mut().enumerate() {
                    if used[level][prototype][index] {
                        outfit.motion = self.motion((level, prototype), outfit);
                    }
                }
            }
        }
        for primitive in [&mut mesh.bark, &mut mesh.foliage] {
            primitive.sway.clear();
            primitive.sway.reserve_exact(primitive.vertices.len());
            primitive.levels.clear();
            primitive.levels.reserve_exact(primitive.vertices.len());
        }
        let root = Node {
            seat: (0, 0),
            place: Similarity::IDENTITY,
            thickness: 1.0,
            base: Lineage::default(),
        };
        self.node(&root, &closet, &mut begin(), mesh);
    }

    /// Finds the outfits that are worn.
    fn mark(
        &self,
        seat: (usize, usize),
        closet: &Closet<'_>,
        choices: &mut Choices<'_>,
        used: &mut [Vec<Vec<bool>>],
    ) {
        let outfits = &closet[seat.0][seat.1];
        let Some((choice, outfit)) = choices(seat.0).and_then(|c| Some((c, outfits.get(c)?)))
        else {
            return;
        };
        used[seat.0][seat.1][choice] = true;
        if outfit.open {
            for link in &self.shared.tree.prototype(seat.0, seat.1).links {
                self.mark(
                    (link.level as usize, link.prototype as usize),
                    closet,
                    choices,
                    used,
                );
            }
        }
    }

    /// How the vertices of an outfit sway, apart from where its nodes stand.
    fn motion(&self, seat: (usize, usize), outfit: &Outfit<'_>) -> Motion {
        let Some(template) = outfit.template else {
            return Motion::None;
        };
        match &self.shared.tree.prototype(seat.0, seat.1).part {
            Part::Branch(branch) if outfit.open => {
                let places: Vec<f32> = template
                    .vertices
                    .iter()
                    .map(|v| nearest(branch, v.axis))
                    .collect();
                let drawn = Drawn::new(places.iter().copied());
                Motion::Along(places.iter().map(|&t| drawn.at(t)).collect(), drawn)
            }
            Part::Leaf { .. } => Motion::None,
            Part::Stool | Part::Branch(_) => {
                let tops = template.vertices.iter().map(|v| v.axis.y);
                let foot = FOOT * tops.fold(0.0, f32::max);
                let first = self.shared.bands[seat.0] == 0;
                let held = |point: Vec3| first && point.y <= foot;
                Motion::Inside(inside::ways(&self.shared, seat, template, held))
            }
        }
    }

    fn node(&self, node: &Node, closet: &Closet<'_>, choices: &mut Choices<'_>, mesh: &mut Mesh) {
        let (level, prototype) = node.seat;
        let Some(outfit) = choices(level).and_then(|c| closet[level][prototype].get(c)) else {
            return;
        };
        let tip = self.tip_of(node);
        if let Some(template) = outfit.template {
            let primitive = match template.material {
                Material::Bark => &mut mesh.bark,
                Material::Foliage => &mut mesh.foliage,
            };
            let levels = primitive.levels.len() + template.vertices.len();
            primitive.levels.resize(levels, self.shared.numbers[level]);
            self.write(node, tip, template, &outfit.motion, &mut primitive.sway);
        }
        if !outfit.open {
            return;
        }
        let exact = Drawn::default();
        let drawn = match &outfit.motion {
            Motion::Along(_, drawn) => drawn,
            Motion::None | Motion::Inside(_) => &exact,
        };
        for (index, link) in self
            .shared
            .tree
            .prototype(level, prototype)
            .links
            .iter()
            .enumerate()
        {
            let mut base = node.base;
            base.bands = carried(base.bands, self.shared.bands[level], tip, drawn.at(link.at));
            base.phase = self.shared.phase(node.seat, index, base.phase);
            base.path = follow(base.path, index);
            let child = Node {
                seat: (link.level as usize, link.prototype as usize),
                place: self.shared.tree.place(&node.place, link),
                thickness: link.thickness,
                base,
            };
            self.node(&child, closet, choices, mesh);
        }
    }

    /// Way of the tip of a node's branch, metres; `None` for a root, which the ground holds.
    fn tip_of(&self, node: &Node) -> Option<f32> {
        let part = &self.shared.tree.prototype(node.seat.0, node.seat.1).part;
        match part {
            Part::Branch(branch) => {
                let tip = branch.axis.last().map_or(Vec3::ZERO, |s| s.position);
                if self.shared.bands[node.seat.0] > 0 && node.place.point(tip).y < 0.0 {
                    return None;
                }
                Some(
                    self.shared
                        .tip_m(node.seat, node.place.scale, node.thickness),
                )
            }
            Part::Stool | Part::Leaf { .. } => Some(0.0),
        }
    }

    fn write(
        &self,
        node: &Node,
        tip: Option<f32>,
        template: &Template,
        motion: &Motion,
        out: &mut Vec<Sway>,
    ) {
        let band = self.shared.bands[node.seat.0];
        let Lineage { bands, phase, path } = node.base;
        match motion {
            Motion::None => {
                let wind = self.bytes(bands, phase);
                let swing = 2.0 * inside::unit_of(path) - 1.0;
                let turned = |v: &super::TemplateVertex| {
                    let arm = node.place.vector(v.axis + v.offset * node.thickness);
                    let [x, y, z] = (arm / self.rig.leaf_reach_m.max(1e-6)).to_array();
                    let leaf = [x, y, z, swing].map(signed_byte);
                    Sway { wind, leaf }
                };
                out.extend(template.vertices.iter().map(turned));
            }
            Motion::Along(bends, _) => out.extend(
                bends
                    .iter()
                    .map(|bend| self.still(carried(bands, band, tip, *bend), phase)),
            ),
            Motion::Inside(ways) => out.extend(ways.iter().map(|way| {
                let mut bands = carried(bands, band, tip, way[OWN]);
                for (sum, place) in bands.iter_mut().zip(BANDS) {
                    *sum += node.place.scale * way[place];
                }
                if band > 0 {
                    return self.still(bands, phase);
                }
                let phasor = PHASOR.map(|place| node.place.scale * way[place]);
                let (bands, phase) = out_of_step(bands, phasor);
                self.still(bands, phase)
            })),
        }
    }

    /// What does not turn.
    fn still(&self, bands: [f32; 3], phase: f32) -> Sway {
        Sway {
            wind: self.bytes(bands, phase),
            leaf: [0; 4],
        }
    }

    fn bytes(&self, bands: [f32; 3], phase: f32) -> [u8; 4] {
        let part = |band: usize| byte_from_unit(bands[band] / self.rig.amplitude_m[band].max(1e-9));
        [part(0), part(1), part(2), byte_from_unit(phase)]
    }
}

fn outfit(template: Option<&Template>, open: bool) -> Outfit<'_> {
    Outfit {
        template,
        open,
        motion: Motion::None,
    }
}

/// How a place on a branch sways that has bent by `bend`: with what carries the branch, and with the branch.
/// A root takes leave of what carries it instead, and its tip stays.
fn carried(mut bands: [f32; 3], band: usize, tip: Option<f32>, bend: f32) -> [f32; 3] {
    match tip {
        Some(tip) => bands[band] += tip * bend,
        None => bands = bands.map(|b| b * (1.0 - bend.min(1.0))),
    }
    bands
}

/// The bands and the phase of what swings as a sum of limbs that are out of step: together they swing as far
/// as the sum of their `phasor`s, and lean as far as all of them.
fn out_of_step(bands: [f32; 3], phasor: [f32; 2]) -> ([f32; 3], f32) {
    let outer = bands[1] + bands[2];
    let together = (phasor[0] * phasor[0] + phasor[1] * phasor[1]).sqrt();
    if outer <= 0.0 || together <= 0.0 {
        return (bands, 0.0);
    }
    let kept = (together / outer).min(1.0);
    let rest = outer * (1.0 - kept) / 3.0;
    let turn = libm::atan2f(phasor[1], phasor[0]) / TAU;
    let bands = [
        bands[0] + rest,
        bands[1] * kept + rest,
        bands[2] * kept + rest,
    ];
    (bands, turn - turn.floor())
}

/// The place along a branch that is nearest to a point.
fn nearest(branch: &crate::tree::Branch, point: Vec3) -> f32 {
    let mut best = (f32::INFINITY, 0.0);
    for sample in &branch.axis {
        let away = sample.position.distance_squared(point);
        if away < best.0 {
            best = (away, sample.t);
        }
    }
    best.1
}

/// The hash of the way to a child.
fn follow(path: u32, index: usize) -> u32 {
    let step = u32::try_from(index).unwrap_or(u32::MAX).wrapping_add(1);
    (path.rotate_left(7) ^ step).wrapping_mul(0x85eb_ca6b)
}

/// A part in -1..=1 as a signed byte.
#[expect(clippy::cast_possible_truncation, reason = "clamped to -127..=127")]
fn signed_byte(part: f32) -> i8 {
    (part.clamp(-1.0, 1.0) * 127.0).round() as i8
}

/// Largest figures of a sub-tree at scale 1.
#[derive(Clone, Copy, Debug, Default)]
struct Most {
    /// Metres by band of all that is outside of the prototype's own branch.
    lean: [f32; 3],
    /// Longest branch by band, its own one left out, metres.
    length: [f32; 3],
    /// Farthest corner of a leaf from its hinge, metres.
    reach: f32,
}

/// The figures of a whole tree. The lean is a bound: no vertex moves farther, and few much less.
fn rig(shared: &Shared<'_>) -> Rig {
    let tree = shared.tree;
    let mut most: Vec<Vec<Most>> = tree
        .levels
        .iter()
        .map(|l| vec![Most::default(); l.prototypes.len()])
        .collect();
    for level in (0..tree.levels.len()).rev() {
        for prototype in 0..most[level].len() {
            let mut all = Most::default();
            for link in &tree.prototype(level, prototype).links {
                let seat = (link.level as usize, link.prototype as usize);
                let inner = most[seat.0][seat.1];
                let found = with_own(shared, seat, inner, link.place.scale, link.thickness);
                for band in 0..3 {
                    all.lean[band] = all.lean[band].max(found.lean[band]);
                    all.length[band] = all.length[band].max(found.length[band]);
                }
                all.reach = all.reach.max(found.reach);
            }
            most[level][prototype] = all;
        }
    }
    let whole = with_own(shared, (0, 0), most[0][0], 1.0, 1.0);
    let [first, second, outer] = whole.lean;
    let angle = LEAF_ANGLE / whole.reach.max(1e-3).sqrt();
    Rig {
        // What swings out of step is spread over all three.
        amplitude_m: [
            first.max((second + outer) / 3.0),
            second.max(outer / 3.0),
            outer.max(second / 3.0),
        ],
        leaf_reach_m: whole.reach,
        frequency_hz: whole
            .length
            .map(|l| HZ_AT_1_M / if l > 0.0 { l.sqrt() } else { 1.0 }),
        leaf_angle: if whole.reach > 0.0 {
            angle.clamp(0.05, 0.35)
        } else {
            0.0
        },
    }
}

/// The figures of a node, from those of what is on its prototype.
fn with_own(
    shared: &Shared<'_>,
    seat: (usize, usize),
    inner: Most,
    scale: f32,
    thickness: f32,
) -> Most {
    let band = shared.bands[seat.0];
    let mut all = Most {
        lean: inner.lean.map(|l| l * scale),
        length: inner.length.map(|l| l * scale),
        reach: inner.reach * scale,
    };
    match &shared.tree.prototype(seat.0, seat.1).part {
        Part::Stool => {}
        Part::Branch(branch) => {
            all.lean[band] += shared.tip_m(seat, scale, thickness);
            all.length[band] = all.length[band].max(branch.length * scale);
        }
        Part::Leaf { length, width, .. } => {
            all.reach = all.reach.max(libm::hypotf(*length, 0.5 * width) * scale);
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limbs_out_of_step_lean_as_far_and_swing_less() {
        let (bands, phase) = out_of_step([0.1, 0.4, 0.2], [0.0, 0.3]);
        assert!((bands.iter().sum::<f32>() - 0.7).abs() < 1e-6, "{bands:?}");
        assert!((phase - 0.25).abs() < 1e-6);
        // Half of the outer 0.6 m swings together; the other half goes to all three bands alike.
        for (band, expected) in bands.iter().zip([0.2, 0.3, 0.2]) {
            assert!((band - expected).abs() < 1e-6, "{bands:?}");
        }
        assert_eq!(
            out_of_step([0.3, 0.0, 0.0], [0.0; 2]),
            ([0.3, 0.0, 0.0], 0.0)
        );
    }
}
