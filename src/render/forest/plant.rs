//! Where the trees of a forest stand.
//!
//! A grid whose trees are shifted by chance within their cells: as even as a planted wood, without its rows. Kinds
//! stand together in groups tens of metres wide, as they do where each seeds itself.

use super::ForestTree;
use crate::math::{TAU, Vec2, Vec3, float, floor_to_u32, smoothstep};
use crate::rng::{Key, Parameter};
use rayon::prelude::*;

/// How a forest is planted.
#[derive(Clone, Debug, PartialEq)]
pub struct Planting {
    /// Number of trees.
    pub trees: u32,
    /// Seed.
    pub seed: u64,
    /// For each model, its share of the trees.
    pub shares: Vec<f32>,
    /// Metres from tree to tree, about.
    pub spacing_m: f32,
    /// Largest shift of a tree within its cell, as a part of the spacing, 0..=0.5.
    pub shift: f32,
    /// Largest part by which trees are larger or smaller than their model, 0..1.
    pub vary: f32,
    /// Largest part by which their colours differ, 0..1.
    pub tint: f32,
    /// Width of groups of one kind, metres; 0 for none.
    pub group_m: f32,
    /// How much light a tree's neighbours take from its foot, 0..=1.
    pub crowded: f32,
    /// Ground without trees.
    pub clearings: Vec<Clearing>,
}

/// Round ground without trees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearing {
    /// Its middle (x, z), metres.
    pub middle: Vec2,
    /// Metres.
    pub radius: f32,
}

impl Default for Planting {
    fn default() -> Self {
        Self {
            trees: 5_929,
            seed: 1,
            shares: vec![1.0],
            spacing_m: 7.0,
            shift: 0.42,
            vary: 0.15,
            tint: 0.12,
            group_m: 45.0,
            crowded: 0.75,
            clearings: Vec::new(),
        }
    }
}

impl Planting {
    /// Trees along an edge of the square that they fill.
    fn side(&self) -> u32 {
        let full = float(self.trees);
        let bare: f32 = self
            .clearings
            .iter()
            .map(|c| c.radius * c.radius * core::f32::consts::PI)
            .sum();
        let cells = full + bare / (self.spacing_m * self.spacing_m).max(1e-6);
        floor_to_u32(cells.sqrt().ceil()).max(1)
    }

    /// Half the edge of the square that its trees fill, metres.
    #[must_use]
    pub fn half_edge_m(&self) -> f32 {
        float(self.side()) * self.spacing_m * 0.5
    }
}

/// The trees of a forest, around the origin: exactly as many as asked for, unless clearings outside of it make it
/// too small.
#[must_use]
pub fn plant(planting: &Planting) -> Vec<ForestTree> {
    let key = Key::of_seed(planting.seed).level("forest");
    // A clearing takes a few cells more or less than its area says.
    let side = planting.side() + u32::from(!planting.clearings.is_empty()) * 2;
    let mut trees: Vec<ForestTree> = (0..u64::from(side) * u64::from(side))
        .into_par_iter()
        .filter_map(|cell| tree(planting, key, side, cell))
        .collect();
    trees.truncate(planting.trees as usize);
    trees
}

fn tree(planting: &Planting, key: Key, side: u32, cell: u64) -> Option<ForestTree> {
    let [x, z] = [cell % u64::from(side), cell / u64::from(side)]
        .map(|at| float(u32::try_from(at).unwrap_or(u32::MAX)) + 0.5 - float(side) * 0.5);
    let own = key.with(cell);
    let shift = [own.with(0), own.with(1)].map(|k| k.signed(Parameter::Planted) * planting.shift);
    let at = Vec2::new(x + shift[0], z + shift[1]) * planting.spacing_m;
    // Trees at a clearing's rim have light from its side.
    let room = planting
        .clearings
        .iter()
        .map(|c| c.middle.distance(at) - c.radius)
        .fold(f32::INFINITY, f32::min);
    if room < 0.0 {
        return None;
    }
    let model = kind(planting, key, own, at)?;
    let size = 1.0 + planting.vary * own.signed(Parameter::Scale);
    let place = Vec3::new(at.x, 0.0, at.y);
    let mut tree = ForestTree::at(place, own.unit(Parameter::Spin) * TAU, size, model);
    // Greener or yellower, and lighter or darker.
    let light = 1.0 + planting.tint * own.with(2).signed(Parameter::Tinted);
    let warm = 1.0 + 0.4 * planting.tint * own.with(3).signed(Parameter::Tinted);
    tree = tree.with_look(
        [light * warm, light, light * (2.0 - warm)],
        own.unit(Parameter::Sway),
    );
    tree.crowded = planting.crowded * smoothstep(0.0, planting.spacing_m * 2.5, room);
    Some(tree)
}

/// The model of a tree: by its share, more likely where its group is.
fn kind(planting: &Planting, key: Key, own: Key, at: Vec2) -> Option<u32> {
    let mut weights = planting.shares.clone();
    if planting.group_m > 0.0 && weights.len() > 1 {
        for (index, weight) in weights.iter_mut().enumerate() {
            let field = key.with(1 << 40).with(index as u64);
            let dense = smooth_noise(field, at / planting.group_m);
            // Between groups, kinds mix.
            *weight *= libm::powf(40.0, dense * 2.0 - 1.0);
        }
    }
    let picked = own.pick(Parameter::Prototype, &weights)?;
    u32::try_from(picked).ok()
}

/// Value noise, 0..1, on a grid of edge 1.
fn smooth_noise(key: Key, at: Vec2) -> f32 {
    let cell = at.floor();
    let f = at - cell;
    let corner = |x: f32, y: f32| {
        let bits = |v: f32| u64::from((v + 65_536.0).max(0.0).to_bits());
        key.with(bits(cell.x + x))
            .with(bits(cell.y + y))
            .unit(Parameter::Planted)
    };
    let [u, v] = [f.x, f.y].map(|t| smoothstep(0.0, 1.0, t));
    let row = |y: f32| corner(0.0, y) * (1.0 - u) + corner(1.0, y) * u;
    row(0.0) * (1.0 - v) + row(1.0) * v
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mixed() -> Planting {
        Planting {
            trees: 900,
            shares: vec![2.0, 1.0],
            clearings: vec![Clearing {
                middle: Vec2::new(10.0, -20.0),
                radius: 18.0,
            }],
            ..Planting::default()
        }
    }

    #[test]
    fn a_wood_has_as_many_trees_as_asked_for_and_none_in_a_clearing() {
        let planting = mixed();
        let trees = plant(&planting);
        assert_eq!(trees.len(), 900);
        for tree in &trees {
            let at = Vec2::new(tree.place[0], tree.place[2]);
            let [clearing] = planting.clearings[..] else {
                unreachable!()
            };
            assert!(at.distance(clearing.middle) >= clearing.radius);
            assert!((0.85..=1.15).contains(&tree.size) && tree.place[1] == 0.0);
        }
        let second = trees.iter().filter(|t| t.model == 1).count();
        assert!((150..450).contains(&second), "{second} of the second kind");
    }

    #[test]
    fn neighbours_keep_their_distance_and_stand_in_no_rows() {
        let planting = Planting {
            trees: 400,
            ..Planting::default()
        };
        let trees = plant(&planting);
        let at = |t: &ForestTree| Vec2::new(t.place[0], t.place[2]);
        let mut offsets: Vec<f32> = Vec::new();
        for (i, a) in trees.iter().enumerate() {
            let nearest = trees
                .iter()
                .enumerate()
                .filter(|&(j, _)| j != i)
                .map(|(_, b)| at(a).distance(at(b)))
                .fold(f32::INFINITY, f32::min);
            assert!(nearest > 0.1 * planting.spacing_m, "{nearest} m apart");
            offsets.push((a.place[0] / planting.spacing_m).rem_euclid(1.0));
        }
        // Places within the cells are spread over all of them.
        for part in 0..4_u8 {
            let low = f32::from(part) * 0.25;
            let inside = offsets.iter().filter(|&&o| (low..low + 0.25).contains(&o));
            assert!(inside.count() > 50, "columns are seen");
        }
    }

    #[test]
    fn more_trees_leave_those_of_a_like_square_where_they_are() {
        let a = plant(&mixed());
        let b = plant(&mixed());
        assert_eq!(a, b);
        let other = plant(&Planting { seed: 2, ..mixed() });
        assert_ne!(a, other);
    }
}
