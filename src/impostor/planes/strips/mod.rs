//! Strips: planes through a straightened sub-tree, cut across its branch and bent back along it.
//!
//! The way fronds are modelled by hand: a flat picture of the straight frond on a few quads in a row that
//! follow its droop. The sub-tree's own branch is laid along +Y by arc length, and what it carries keeps its
//! turn and its offset against the branch's rotation-minimising frame; so planes fit to a curved frond as well
//! as to a straight one. Wings, half planes that hang together at the branch, are fitted for strips alone: each
//! leaf goes to the wing that is nearest around the branch (Lloyd's algorithm on a circle).
//!
//! A strip's vertices are then placed by least squares: where its picture shows a leaf's corner should be where
//! that corner is. So a strip follows the branch between its cuts in the mean, twists where the leaves' angle
//! around the branch changes, and shears where they lean forward. Cuts go where they bring leaves nearest.
//!
//! Source: modellers' craft; the frames are those of Wang et al. 2008 (`tree::branch`).
//!
//! Guarantee: bending undoes straightening on every cross-section of the branch; leaves that lie in a plane get
//! no cuts. Cost: 2 triangles a plane and segment; a fit is O(leaves + segments^3), a cut some two dozen fits.

mod wings;

pub use wings::{spread, wings};

use super::{Item, Plane};
use crate::math::{Quat, Similarity, Vec3};
use crate::mesh::card::UvRect;
use crate::mesh::{
    Coat, Flattener, Form, Material, Mesh, Template, TemplateVertex, TooLarge, WHITE, tube,
};
use crate::tree::{AxisSample, Branch, Part, Tree};

/// A branch's axis laid along +Y, and the way back.
#[derive(Clone, Debug, PartialEq)]
pub struct Bend<'a> {
    axis: &'a [AxisSample],
    /// Arc length, metres.
    length: f32,
}

impl<'a> Bend<'a> {
    /// The bend of a branch.
    #[must_use]
    pub fn of(branch: &'a Branch) -> Self {
        Self {
            axis: &branch.axis,
            length: branch.length,
        }
    }

    /// A point of the straightened space, where it belongs; straight on beyond the branch's ends.
    #[must_use]
    pub fn point(&self, point: Vec3) -> Vec3 {
        let last = self.axis.len() - 1;
        let t = point.y / self.length;
        let (at, frame, along) = if t <= 0.0 {
            (self.axis[0].position, self.axis[0].frame, point.y)
        } else if t >= 1.0 {
            let end = &self.axis[last];
            (end.position, end.frame, point.y - self.length)
        } else {
            let after = self.axis.partition_point(|s| s.t <= t).clamp(1, last);
            let (a, b) = (&self.axis[after - 1], &self.axis[after]);
            let part = ((t - a.t) / (b.t - a.t)).clamp(0.0, 1.0);
            let frame = a.frame.slerp(b.frame, part).normalize();
            (a.position.lerp(b.position, part), frame, 0.0)
        };
        at + frame * Vec3::new(point.x, along, point.z)
    }
}

/// A bent plane: rows of two vertices across the branch, from its base outward.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    rows: Vec<Row>,
    /// Part of the width, from the left, at which the branch runs: widening leaves it in place.
    hinge: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    /// Part of the picture's height, from below.
    part: f32,
    /// Left and right end, metres in the prototype's frame.
    ends: [Vec3; 2],
}

/// How strongly a strip's vertices are drawn to where the bend alone would put them, against the leaves: enough
/// to settle corners that no leaf is near.
const HOLD: f64 = 0.01;

/// Weight of the branch itself against leaves of the same area: a strip beside its stem is soon found out.
const STEM_WEIGHT: f32 = 4.0;

impl Strip {
    /// A plane, cut at some heights and bent. Every `stride`th of its leaves has a say.
    fn of(fit: &Fit<'_>, plane: &Plane, cuts: &[f32], stride: usize) -> Self {
        let [low, high] = heights(plane);
        // A sliver at an end would be triangles for nothing.
        let sliver = (high - low) * 1e-3;
        let inside = cuts
            .iter()
            .filter(|&&y| y > low + sliver && y < high - sliver);
        let inside = inside.map(|&y| (y - low) / (high - low));
        let corner = |part: f32, side: f32| {
            let up = plane.up * (plane.half[1] * (2.0 * part - 1.0));
            fit.bend
                .point(plane.centre + up + plane.right * (side * plane.half[0]))
        };
        let parts = core::iter::once(0.0).chain(inside).chain([1.0]);
        let rows = parts.map(|part| Row {
            part,
            ends: [corner(part, -1.0), corner(part, 1.0)],
        });
        let mut strip = Self {
            rows: rows.collect(),
            hinge: (0.5 - plane.centre.dot(plane.right) / (2.0 * plane.half[0])).clamp(0.0, 1.0),
        };
        strip.settle(fit, plane, stride);
        strip
    }

    /// Moves the vertices so that the picture's leaves are where they belong, in the mean of squares.
    fn settle(&mut self, fit: &Fit<'_>, plane: &Plane, stride: usize) {
        let unknowns = 2 * self.rows.len();
        let mut system = System::new(unknowns);
        for (corner, goal, weight) in fit.corners(plane, stride) {
            system.add(self.shares(plane, corner), goal, f64::from(weight));
        }
        let hold = HOLD * system.weight / f64::from(u32::try_from(unknowns).unwrap_or(1));
        let hold = hold.max(1e-9);
        for (index, end) in self.rows.iter().flat_map(|r| r.ends).enumerate() {
            system.add([(index, 1.0), (index, 0.0), (index, 0.0)], end, hold);
        }
        let ends = self.rows.iter_mut().flat_map(|r| &mut r.ends);
        for (end, solved) in ends.zip(system.solve()) {
            *end = solved;
        }
    }

    /// The three vertices between which a point of the straightened space is shown, with its share of each.
    fn shares(&self, plane: &Plane, point: Vec3) -> [(usize, f32); 3] {
        let away = point - plane.centre;
        let u = (away.dot(plane.right) / plane.half[0] * 0.5 + 0.5).clamp(0.0, 1.0);
        let part = (away.dot(plane.up) / plane.half[1] * 0.5 + 0.5).clamp(0.0, 1.0);
        let above = self.rows.partition_point(|r| r.part <= part);
        let above = above.clamp(1, self.rows.len() - 1);
        let [low, high] = [self.rows[above - 1].part, self.rows[above].part];
        let v = (part - low) / (high - low);
        let first = 2 * (above - 1);
        // The two triangles of a quad share the diagonal from its lower left to its upper right.
        if u >= v {
            [(first, 1.0 - u), (first + 1, u - v), (first + 3, v)]
        } else {
            [(first, 1.0 - v), (first + 3, u), (first + 2, v - u)]
        }
    }

    /// Where a point of the straightened space is shown.
    fn shown(&self, plane: &Plane, point: Vec3) -> Vec3 {
        let shares = self.shares(plane, point);
        let end = |index: usize| self.rows[index / 2].ends[index % 2];
        shares.iter().map(|&(i, share)| end(i) * share).sum()
    }

    /// Triangles.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        2 * (self.rows.len() as u64 - 1)
    }

    /// Adds the strip to a template, with its place in the atlas, widened by `scale` about the branch;
    /// lengthwise it keeps its size, or it would outgrow the branch.
    fn write(&self, uv: &UvRect, scale: f32, template: &mut Template) {
        let base = u32::try_from(template.vertices.len()).unwrap_or(u32::MAX);
        let last = self.rows.len() - 1;
        for (index, row) in self.rows.iter().enumerate() {
            let [left, right] = row.ends;
            let across = (right - left).normalize_or(Vec3::X);
            let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
            let middle = |row: usize| (self.rows[row].ends[0] + self.rows[row].ends[1]) * 0.5;
            let along = middle(after) - middle(before);
            let normal = across.cross(along);
            let normal = normal.normalize_or(across.any_orthonormal_vector());
            let hinge = left.lerp(right, self.hinge);
            for (end, u) in [(left, uv.u0), (right, uv.u1)] {
                template.vertices.push(TemplateVertex {
                    axis: hinge + (end - hinge) * scale,
                    offset: Vec3::ZERO,
                    normal,
                    tangent: across,
                    uv: [u, uv.v1 + (uv.v0 - uv.v1) * row.part],
                    tint: WHITE,
                });
            }
        }
        for segment in 0..u32::try_from(last).unwrap_or(u32::MAX) {
            let first = base + 2 * segment;
            let quad = [0, 1, 3, 0, 3, 2].map(|i| first + i);
            template.indices.extend(quad);
        }
    }
}

/// Strips as one template, each with its place in the atlas and the factor by which it is widened.
#[must_use]
pub fn template(strips: &[Strip], uvs: &[UvRect], scales: &[f32]) -> Template {
    let mut template = Template {
        material: Material::Foliage,
        ..Template::default()
    };
    for ((strip, uv), &scale) in strips.iter().zip(uvs).zip(scales) {
        strip.write(uv, scale, &mut template);
    }
    template
}

/// Planes of a straightened sub-tree on their way to strips.
#[derive(Clone, Copy, Debug)]
pub struct Fit<'a> {
    /// The planes, all with their members.
    pub planes: &'a [Plane],
    /// The way back.
    pub bend: &'a Bend<'a>,
    /// Items of the straightened sub-tree.
    pub items: &'a [Item],
    /// The same items where they belong.
    pub bent: &'a [Item],
}

/// Heights that are tried for a cut.
const PLACES: u16 = 24;

/// Leaves of a plane that have a say where it is cut, about.
const VOICES: usize = 300;

/// A cut must lower the squared distances by this part.
const CUT_GAIN: f64 = 0.01;

/// Leaves that are nearer to where they belong than this part of the branch's length need no cut.
const NEAR: f32 = 1e-3;

/// So few cuts are moved once more when they are complete; of more, each matters little.
const MOVED: usize = 4;

impl Fit<'_> {
    /// The planes cut at some heights, and bent.
    #[must_use]
    pub fn strips(&self, cuts: &[f32]) -> Vec<Strip> {
        let strip = |plane| Strip::of(self, plane, cuts, 1);
        self.planes.iter().map(strip).collect()
    }

    /// Cuts added to others, up to `segments` segments, as long as they bring leaves nearer to their places.
    #[must_use]
    pub fn cut(&self, mut cuts: Vec<f32>, segments: usize) -> Vec<f32> {
        let mut miss = self.miss(&cuts);
        let near = f64::from(self.bend.length * NEAR);
        let mut changed = false;
        while cuts.len() + 1 < segments && miss > near * near {
            let (found, place) = self.best_place(&cuts);
            if found > miss * (1.0 - CUT_GAIN) {
                break;
            }
            cuts.push(place);
            (miss, changed) = (found, true);
        }
        if changed && (2..=MOVED).contains(&cuts.len()) {
            for index in 0..cuts.len() {
                let mut others = cuts.clone();
                others.remove(index);
                let (found, place) = self.best_place(&others);
                if found < miss {
                    (miss, cuts[index]) = (found, place);
                }
            }
        }
        cuts.sort_by(f32::total_cmp);
        cuts
    }

    /// The height at which one more cut helps most, and the squared distance that it leaves.
    fn best_place(&self, cuts: &[f32]) -> (f64, f32) {
        let [low, high] = span(self.planes);
        let mut best = (f64::INFINITY, low);
        for place in 1..PLACES {
            let height = low + (high - low) * f32::from(place) / f32::from(PLACES);
            let close = (high - low) * 0.5 / f32::from(PLACES);
            if cuts.iter().any(|c| (c - height).abs() < close) {
                continue;
            }
            let mut cuts = cuts.to_vec();
            cuts.push(height);
            cuts.sort_by(f32::total_cmp);
            let miss = self.miss(&cuts);
            if miss < best.0 {
                best = (miss, height);
            }
        }
        best
    }

    /// Mean squared distance of corners from where strips with some cuts show them, square metres.
    /// Cuts are chosen to lower it. Of many leaves, some have a say.
    #[must_use]
    pub fn miss(&self, cuts: &[f32]) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        for plane in self.planes {
            let members = plane.members.as_ref().map_or(0, Vec::len);
            let stride = members.div_ceil(VOICES).max(1);
            let strip = Strip::of(self, plane, cuts, stride);
            for (corner, goal, weight) in self.corners(plane, stride) {
                let miss = strip.shown(plane, corner).distance_squared(goal);
                sum += f64::from(miss) * f64::from(weight);
                total += f64::from(weight);
            }
        }
        sum / total.max(1e-12)
    }

    /// Corners of what a plane shows: in straightened space, where they belong, and their weight.
    fn corners(&self, plane: &Plane, stride: usize) -> impl Iterator<Item = (Vec3, Vec3, f32)> {
        let members = plane.members.iter().flatten().step_by(stride);
        members.flat_map(|&member| {
            let (item, goal) = (&self.items[member as usize], &self.bent[member as usize]);
            let weight = item.area * if item.foliage { 1.0 } else { STEM_WEIGHT };
            let pairs = item.corners.into_iter().zip(goal.corners);
            pairs.map(move |(corner, goal)| (corner, goal, weight))
        })
    }

    /// Mean distance of items from where strips show them, by area, metres.
    #[must_use]
    pub fn mean_shift(&self, strips: &[Strip]) -> f32 {
        let (mut sum, mut area) = (0.0, 0.0);
        for (strip, plane) in strips.iter().zip(self.planes) {
            for &member in plane.members.iter().flatten() {
                let (item, goal) = (&self.items[member as usize], &self.bent[member as usize]);
                sum += strip.shown(plane, item.middle()).distance(goal.middle()) * item.area;
                area += item.area;
            }
        }
        if area > 0.0 { sum / area } else { 0.0 }
    }
}

/// Normal equations of a least-squares fit of some points.
struct System {
    /// Rows of a symmetric positive matrix.
    matrix: Vec<Vec<f64>>,
    goals: Vec<[f64; 3]>,
    weight: f64,
}

impl System {
    fn new(unknowns: usize) -> Self {
        Self {
            matrix: vec![vec![0.0; unknowns]; unknowns],
            goals: vec![[0.0; 3]; unknowns],
            weight: 0.0,
        }
    }

    /// Asks that the sum of some unknowns by their shares be `goal`.
    fn add(&mut self, shares: [(usize, f32); 3], goal: Vec3, weight: f64) {
        let goal = goal.to_array().map(f64::from);
        self.weight += weight;
        for (row, a) in shares {
            for (column, b) in shares {
                self.matrix[row][column] += weight * f64::from(a) * f64::from(b);
            }
            for (sum, goal) in self.goals[row].iter_mut().zip(goal) {
                *sum += weight * f64::from(a) * goal;
            }
        }
    }

    /// The unknowns, by Gauss's elimination; a positive matrix needs no pivots.
    fn solve(mut self) -> Vec<Vec3> {
        let count = self.goals.len();
        for pivot in 0..count {
            let row = self.matrix[pivot].clone();
            let goal = self.goals[pivot];
            for below in pivot + 1..count {
                let factor = self.matrix[below][pivot] / row[pivot];
                let entries = self.matrix[below].iter_mut().zip(&row);
                entries.for_each(|(entry, above)| *entry -= factor * above);
                let goals = self.goals[below].iter_mut().zip(goal);
                goals.for_each(|(entry, above)| *entry -= factor * above);
            }
        }
        for pivot in (0..count).rev() {
            let mut solved = self.goals[pivot];
            for column in pivot + 1..count {
                let factor = self.matrix[pivot][column];
                let known = self.goals[column];
                let entries = solved.iter_mut().zip(known);
                entries.for_each(|(entry, known)| *entry -= factor * known);
            }
            self.goals[pivot] = solved.map(|x| x / self.matrix[pivot][pivot]);
        }
        #[expect(clippy::cast_possible_truncation, reason = "metres fit a float")]
        let point = |goal: &[f64; 3]| Vec3::from(goal.map(|x| x as f32));
        self.goals.iter().map(point).collect()
    }
}

/// Lowest and highest height of a plane across the branch.
fn heights(plane: &Plane) -> [f32; 2] {
    let reach = plane.up.y * plane.half[1];
    [plane.centre.y - reach, plane.centre.y + reach]
}

/// Lowest and highest height of some planes across the branch; zeros if there are none.
fn span(planes: &[Plane]) -> [f32; 2] {
    let ends = planes.iter().map(heights);
    let all = ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    all.unwrap_or([0.0; 2])
}

/// The motion that lays what grows at part `t` of a branch where it belongs on the straightened branch.
#[must_use]
pub fn straightening(branch: &Branch, t: f32) -> Similarity {
    let sample = branch.at(t);
    let back = sample.frame.conjugate();
    Similarity {
        rotation: back,
        translation: Vec3::Y * (t * branch.length) - back * sample.position,
        scale: 1.0,
    }
}

/// A sub-tree with its own branch laid along +Y, as a mesh with the items of the bent one in their order.
///
/// `form` says how all levels are drawn, but for the own branch, which is a tube of spline LOD `lod`. `turn` is
/// how the node stands and `thickness` that of its tube. Nothing if the prototype is no branch.
///
/// # Errors
/// If 32-bit indices cannot address the result.
pub fn straightened(
    tree: &Tree,
    form: &Form,
    (level, prototype): (usize, usize),
    (lod, coat): (usize, Coat),
    (turn, thickness): (Quat, f32),
) -> Result<Mesh, TooLarge> {
    let node = tree.prototype(level, prototype);
    let Part::Branch(branch) = &node.part else {
        return Ok(Mesh::default());
    };
    let mut straight = branch.clone();
    for sample in &mut straight.axis {
        sample.position = Vec3::Y * (sample.t * branch.length);
        sample.frame = Quat::IDENTITY;
    }
    let mut mesh = tube(&straight, lod, coat).placed(&Similarity::IDENTITY, thickness);
    let flattener = Flattener::new(tree, form);
    let standing = |rotation: Quat| Similarity {
        rotation,
        ..Similarity::IDENTITY
    };
    let (place, back) = (standing(turn), standing(turn.conjugate()));
    let mut child = Mesh::default();
    for link in &node.links {
        let at = (link.level as usize, link.prototype as usize);
        let place = tree.place(&place, link);
        flattener.write(at.0, at.1, &place, link.thickness, &mut child)?;
        // Rigid from the world to the straightened frame: the child is laid as a whole.
        let motion = straightening(branch, link.at).then_inner(&back);
        append(&mut mesh, &child, &motion)?;
    }
    Ok(mesh)
}

fn append(mesh: &mut Mesh, child: &Mesh, motion: &Similarity) -> Result<(), TooLarge> {
    let pairs = [
        (&mut mesh.bark, &child.bark),
        (&mut mesh.foliage, &child.foliage),
    ];
    for (to, from) in pairs {
        let vertices = to.vertices.len() + from.vertices.len();
        u32::try_from(vertices).map_err(|_| TooLarge { vertices })?;
        let base = u32::try_from(to.vertices.len()).map_err(|_| TooLarge { vertices })?;
        to.vertices.extend(from.vertices.iter().map(|vertex| {
            let [x, y, z, hand] = vertex.tangent;
            let tangent = motion.rotation * Vec3::new(x, y, z);
            let mut moved = *vertex;
            moved.position = motion.point(Vec3::from(vertex.position)).to_array();
            moved.normal = (motion.rotation * Vec3::from(vertex.normal)).to_array();
            moved.tangent = tangent.extend(hand).to_array();
            moved
        }));
        to.indices.extend(from.indices.iter().map(|i| base + i));
    }
    Ok(())
}
