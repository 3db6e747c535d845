//! What a user would write in an afternoon: fewer and larger leaves, and a simplified wood.

use super::parts::{Parts, bark_budget, scale_about_centres};
use super::{leaf_scale, simplify};
use crate::mesh::Mesh;

/// Simplifies the bark to its share of the full tree's triangles by meshoptimizer (Prune and Permissive),
/// and thins the leaves evenly into what the bark leaves of a budget of so many triangles.
///
/// Leaves are scaled about their centres by `scale`; if that is `None`, by [`leaf_scale`], which keeps their
/// area. Over the budget only if the bark alone is stuck above it.
#[must_use]
pub fn script(full: &Mesh, budget: u64, scale: Option<f32>) -> Mesh {
    let bark = simplify::bark(&full.bark, bark_budget(full, budget));
    let parts = Parts::of(&full.foliage);
    let keep = evenly(parts.triangles(), budget.saturating_sub(bark.triangles()));
    let mut foliage = parts.kept(&full.foliage, &keep);
    let kept = keep.iter().filter(|kept| **kept).count() as u64;
    let scale = scale.unwrap_or_else(|| leaf_scale(kept, keep.len() as u64));
    scale_about_centres(&mut foliage, scale);
    Mesh { bark, foliage }
}

/// Which parts to keep so that their triangles fit a budget and those kept lie evenly among all: credit grows
/// with each part by its share of the budget and is spent on whole parts.
fn evenly(triangles: &[u64], budget: u64) -> Vec<bool> {
    let all: u64 = triangles.iter().sum();
    let budget = u128::from(budget.min(all));
    let mut credit = 0;
    let keep = |&triangles: &u64| {
        let cost = u128::from(triangles) * u128::from(all);
        credit += u128::from(triangles) * budget;
        let kept = credit >= cost;
        if kept {
            credit -= cost;
        }
        kept
    };
    triangles.iter().map(keep).collect()
}

#[cfg(test)]
mod tests {
    use super::super::samples::{cards, is_subset, olive};
    use super::*;
    use crate::mesh::{Primitive, check};

    #[test]
    fn the_script_uses_the_budget_and_no_more() {
        for budget in [0, 1, 4, 248, 836, 10_640] {
            let mesh = script(olive(), budget, None);
            check::mesh(&mesh).expect("sound");
            assert!((budget.saturating_sub(3)..=budget).contains(&mesh.triangles()));
            assert!(mesh == script(olive(), budget, None));
        }
        assert!(script(olive(), u64::MAX, None) == *olive());
        assert!(script(&Mesh::default(), 4, None) == Mesh::default());
    }

    #[test]
    fn leaves_are_thinned_evenly() {
        let gaps = |keep: &[bool]| -> Vec<usize> {
            let kept: Vec<usize> = (0..keep.len()).filter(|&i| keep[i]).collect();
            kept.windows(2).map(|pair| pair[1] - pair[0]).collect()
        };
        let keep = evenly(&[2; 100], 61);
        assert_eq!(keep.iter().filter(|kept| **kept).count(), 30);
        assert!(gaps(&keep).iter().all(|gap| [3, 4].contains(gap)));
        let mixed: Vec<u64> = (0..100).map(|i| if i % 3 == 0 { 2 } else { 4 }).collect();
        for budget in [0, 1, 7, 50, 331, 332, 999] {
            let keep = evenly(&mixed, budget);
            let sum: u64 = (0..100).filter(|&i| keep[i]).map(|i| mixed[i]).sum();
            assert!((budget.min(332).saturating_sub(3)..=budget).contains(&sum));
        }
        assert!(evenly(&[], 4).is_empty());
    }

    #[test]
    fn kept_leaves_are_the_full_trees_but_for_their_size() {
        let mesh = script(olive(), 836, Some(1.0));
        assert!(
            is_subset(&mesh, olive()),
            "unscaled leaves are the same to the bit"
        );
        let large = script(olive(), 836, None);
        assert_eq!(mesh.bark, large.bark);
        assert_eq!(mesh.foliage.indices, large.foliage.indices);
        for (a, b) in mesh.foliage.vertices.iter().zip(&large.foliage.vertices) {
            assert_eq!((a.normal, a.tangent, a.uv), (b.normal, b.tangent, b.uv));
        }
    }

    #[test]
    fn the_leaves_area_stays() {
        let full = cards(&[2; 64]);
        let area = |primitive: &Primitive| -> f32 {
            let corner = |i: u32| crate::math::Vec3::from(primitive.vertices[i as usize].position);
            let areas = primitive.indices.chunks_exact(3).map(|t| {
                let (a, b, c) = (corner(t[0]), corner(t[1]), corner(t[2]));
                (b - a).cross(c - a).length() * 0.5
            });
            areas.sum()
        };
        let part = script(&full, 32, None);
        assert_eq!(part.triangles(), 32);
        assert!((area(&part.foliage) / area(&full.foliage) - 1.0).abs() < 1e-3);
    }
}
