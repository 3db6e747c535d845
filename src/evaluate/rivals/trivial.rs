//! The trivial rival: leaves and branches left out by chance.
//!
//! Home of: Cook, Halstead, Planck, Ryu 2007, "Stochastic Simplification of Aggregate Detail": elements are
//! left out in a random order, and those that stay are made larger so that the area stays.
//!
//! Changes versus the paper: one subset for a whole tree instead of one that fades with the distance; only
//! leaves are made larger, as longer branches would leave the crown; no correction of the contrast.

use super::parts::{Parts, bark_budget, scale_about_centres};
use crate::mesh::{Mesh, Primitive};
use crate::rng::{Key, Parameter};

/// Keeps branches and leaves of `full` by chance, each whole or not at all, up to a budget of so many
/// triangles, and scales the leaves by `scale` about their centres.
///
/// The bark gets its share of the full tree's triangles, the leaves what it leaves over. A branch or leaf
/// that no longer fits is passed over; if the bark's share is less than every branch, there is no bark.
/// What is kept does not depend on `scale`, so a caller may count leaves first and scale afterwards
/// ([`leaf_scale`]).
#[must_use]
pub fn random(full: &Mesh, budget: u64, seed: u64, scale: f32) -> Mesh {
    let key = Key::of_seed(seed);
    let share = bark_budget(full, budget);
    let bark = by_chance(&full.bark, share, key.level("random rival: bark"));
    let left = budget - bark.triangles();
    let mut foliage = by_chance(&full.foliage, left, key.level("random rival: leaves"));
    scale_about_centres(&mut foliage, scale);
    Mesh { bark, foliage }
}

/// Parts kept in the order of their draws, as far as they fit.
fn by_chance(primitive: &Primitive, budget: u64, key: Key) -> Primitive {
    let parts = Parts::of(primitive);
    let draw = |part: usize| key.with(part as u64).unit(Parameter::Position);
    let mut order: Vec<(f32, usize)> = (0..parts.triangles().len())
        .map(|part| (draw(part), part))
        .collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut keep = vec![false; order.len()];
    let mut left = budget;
    for (_, part) in order {
        if let Some(rest) = left.checked_sub(parts.triangles()[part]) {
            left = rest;
            keep[part] = true;
        }
    }
    parts.kept(primitive, &keep)
}

/// The factor that keeps the leaves' area when `kept` of `all` leaves are left: sqrt(`all` / `kept`); 1 if
/// there is none. It makes crowns too dense, because leaves that hid each other no longer do: calibrate it by
/// the covered area where that counts.
#[must_use]
#[expect(
    clippy::cast_precision_loss,
    reason = "a scale is good to a part in ten million"
)]
pub fn leaf_scale(kept: u64, all: u64) -> f32 {
    if kept == 0 {
        1.0
    } else {
        (all as f32 / kept as f32).sqrt()
    }
}

/// Number of leaves of a mesh: connected parts of its foliage.
#[must_use]
pub fn leaves(mesh: &Mesh) -> u64 {
    Parts::of(&mesh.foliage).triangles().len() as u64
}

#[cfg(test)]
mod tests {
    use super::super::samples::{cards, is_subset, olive};
    use super::*;
    use crate::math::round_to_u32;
    use crate::mesh::check;

    #[test]
    fn chance_never_goes_over_the_budget_and_hardly_stays_below() {
        for budget in [0, 1, 4, 5, 248, 836, 10_640] {
            let mesh = random(olive(), budget, 7, 1.0);
            check::mesh(&mesh).expect("sound");
            assert!((budget.saturating_sub(3)..=budget).contains(&mesh.triangles()));
        }
        assert!(random(olive(), u64::MAX, 7, 1.0) == *olive());
        assert!(random(&Mesh::default(), 4, 7, 2.0) == Mesh::default());
    }

    #[test]
    fn what_is_kept_is_whole_and_to_the_bit() {
        let mesh = random(olive(), 10_640, 7, 1.0);
        assert!(is_subset(&mesh, olive()));
        let all = Parts::of(&olive().foliage).triangles()[0];
        assert!(
            Parts::of(&mesh.foliage)
                .triangles()
                .iter()
                .all(|&t| t == all)
        );
        let share = bark_budget(olive(), 10_640);
        assert!(mesh.bark.triangles() <= share && mesh.bark.triangles() > share / 2);
    }

    #[test]
    fn the_seed_alone_chooses_what_is_kept() {
        let mesh = random(olive(), 836, 7, 1.0);
        assert!(mesh == random(olive(), 836, 7, 1.0));
        assert!(mesh != random(olive(), 836, 8, 1.0));
        let large = random(olive(), 836, 7, 2.0);
        assert!(mesh.foliage.vertices != large.foliage.vertices);
        assert_eq!(mesh.foliage.indices, large.foliage.indices);
        let uvs = |mesh: &Mesh| mesh.foliage.vertices.iter().map(|v| v.uv).collect();
        let (plain, scaled): (Vec<_>, Vec<_>) = (uvs(&mesh), uvs(&large));
        assert_eq!(plain, scaled);
    }

    #[test]
    fn each_leaf_is_as_likely_to_stay() {
        let mesh = cards(&[2; 10]);
        let mut hits = [0_u32; 10];
        for seed in 0..2000 {
            let kept = random(&mesh, 6, seed, 1.0);
            assert_eq!(leaves(&kept), 3);
            // The card number stands in u, as `cards` says.
            for card in kept.foliage.vertices.chunks(4) {
                hits[round_to_u32(card[0].uv[0] * 10.0) as usize] += 1;
            }
        }
        assert!(
            hits.iter().all(|hits| (500..700).contains(hits)),
            "{hits:?}"
        );
    }

    #[test]
    fn the_scale_keeps_the_area() {
        assert_eq!(leaf_scale(25, 100), 2.0);
        assert_eq!(leaf_scale(7, 7), 1.0);
        assert_eq!(leaf_scale(0, 7), 1.0);
        assert_eq!(leaves(&cards(&[2, 4, 4])), 3);
    }
}
