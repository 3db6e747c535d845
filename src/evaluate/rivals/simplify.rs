//! The general mesh simplifier, as engines ship it: meshoptimizer 1.3, by the crate `meshopt`.
//!
//! Home of: Garland, Heckbert 1997, "Surface Simplification Using Quadric Error Metrics" (`simplify`);
//! Rossignac, Borrel 1993, "Multi-resolution 3D approximations for rendering complex scenes"
//! (`simplifySloppy`).
//!
//! Changes versus the papers: meshoptimizer's; seams are kept, and vertices stay where they are, so that
//! every corner of the result is a vertex of the full mesh with its own normal and texture coordinates.
//!
//! The same input gives the same output on one machine; the C++ compiler of another may round otherwise.

use super::parts::compact;
use crate::mesh::{Mesh, Primitive};
use meshopt::{SimplifyOptions, VertexDataAdapter};

/// meshoptimizer keeps vertex numbers in 28 bits.
const MOST_VERTICES: usize = 1 << 28;

/// Any error is allowed: only the budget counts.
const UNBOUNDED: f32 = f32::MAX;

/// `simplify` without options.
pub(super) fn plain(full: &Mesh, budget: u64) -> Mesh {
    whole(full, budget, |indices, vertices, target| {
        edge_collapses(indices, vertices, target, SimplifyOptions::None)
    })
}

/// `simplify` that may remove small parts and collapse across seams.
pub(super) fn prune_permissive(full: &Mesh, budget: u64) -> Mesh {
    whole(full, budget, |indices, vertices, target| {
        edge_collapses(indices, vertices, target, prune_and_permissive())
    })
}

/// `simplifySloppy`: vertices in one cell of a grid become one, be they of one leaf or of several.
///
/// It is asked for more triangles than the budget as long as those that are of one material fit: where twigs
/// stand among leaves, half of what it makes is of both.
pub(super) fn sloppy(full: &Mesh, budget: u64) -> Mesh {
    let asked = |target: u64| {
        whole(full, target, |indices, vertices, target| {
            meshopt::simplify_sloppy(indices, vertices, target, UNBOUNDED, None)
        })
    };
    let mut best = asked(budget);
    let (mut fits, mut over) = (budget, full.triangles());
    for _ in 0..SLOPPY_TRIES {
        if over.saturating_sub(fits) < 2 {
            break;
        }
        let target = fits + (over - fits) / 2;
        let mesh = asked(target);
        if mesh.triangles() > budget {
            over = target;
            continue;
        }
        fits = target;
        if mesh.triangles() > best.triangles() {
            best = mesh;
        }
    }
    best
}

/// Halvings of the range of targets; meshoptimizer has a thousand grids to choose from.
const SLOPPY_TRIES: u32 = 12;

/// Bark alone, by `simplify` as in [`prune_permissive`].
pub(super) fn bark(bark: &Primitive, budget: u64) -> Primitive {
    let positions: Vec<[f32; 3]> = bark.vertices.iter().map(|v| v.position).collect();
    let indices = reduced(
        &bark.indices,
        &positions,
        budget,
        |indices, vertices, target| {
            edge_collapses(indices, vertices, target, prune_and_permissive())
        },
    );
    compact(&bark.vertices, indices)
}

fn prune_and_permissive() -> SimplifyOptions {
    SimplifyOptions::Prune | SimplifyOptions::Permissive
}

fn edge_collapses(
    indices: &[u32],
    vertices: &VertexDataAdapter<'_>,
    target: usize,
    options: SimplifyOptions,
) -> Vec<u32> {
    meshopt::simplify(indices, vertices, target, UNBOUNDED, options, None)
}

/// Both materials in one index buffer, the bark's vertices first, and apart again afterwards. A triangle
/// whose corners are of both is left out: neither texture fits it.
fn whole(
    full: &Mesh,
    budget: u64,
    method: impl FnOnce(&[u32], &VertexDataAdapter<'_>, usize) -> Vec<u32>,
) -> Mesh {
    let vertices = full.bark.vertices.iter().chain(&full.foliage.vertices);
    let positions: Vec<[f32; 3]> = vertices.map(|v| v.position).collect();
    // Below, this many vertices are refused anyway.
    let border = u32::try_from(full.bark.vertices.len()).unwrap_or(0);
    let foliage = full
        .foliage
        .indices
        .iter()
        .map(|i| i.saturating_add(border));
    let indices: Vec<u32> = full.bark.indices.iter().copied().chain(foliage).collect();
    if positions.len() >= MOST_VERTICES {
        return full.clone();
    }
    let (mut bark, mut foliage) = (Vec::new(), Vec::new());
    for corners in reduced(&indices, &positions, budget, method).chunks_exact(3) {
        if corners.iter().all(|&i| i < border) {
            bark.extend_from_slice(corners);
        } else if corners.iter().all(|&i| i >= border) {
            foliage.extend(corners.iter().map(|i| i - border));
        }
    }
    Mesh {
        bark: compact(&full.bark.vertices, bark),
        foliage: compact(&full.foliage.vertices, foliage),
    }
}

/// The triangles that a method leaves; all of them where the budget asks for no fewer.
fn reduced(
    indices: &[u32],
    positions: &[[f32; 3]],
    budget: u64,
    method: impl FnOnce(&[u32], &VertexDataAdapter<'_>, usize) -> Vec<u32>,
) -> Vec<u32> {
    let target = usize::try_from(budget.saturating_mul(3)).unwrap_or(usize::MAX);
    // meshoptimizer asserts that the target is no larger than the input.
    if target >= indices.len() {
        return indices.to_vec();
    }
    let bytes = bytemuck::cast_slice(positions);
    match VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0) {
        Ok(vertices) => method(indices, &vertices, target),
        // The bytes are whole positions, so there is no such case; a stuck rival is what it would be.
        Err(_) => indices.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{cards, olive, vertices_of};
    use super::*;
    use crate::mesh::check;

    type Method = fn(&Mesh, u64) -> Mesh;

    const METHODS: [(&str, Method); 3] = [
        ("plain", plain),
        ("prune_permissive", prune_permissive),
        ("sloppy", sloppy),
    ];

    #[test]
    fn simplified_olives_are_sound_and_within_the_budget() {
        for (name, method) in METHODS {
            for budget in [0, 4, 248, 836, 10_640] {
                let mesh = method(olive(), budget);
                check::mesh(&mesh).unwrap_or_else(|fault| panic!("{name} at {budget}: {fault}"));
                assert!(mesh == method(olive(), budget), "{name} at {budget}");
                let vertices = vertices_of(&olive().bark);
                assert!(vertices_of(&mesh.bark).is_subset(&vertices), "{name}");
                let vertices = vertices_of(&olive().foliage);
                assert!(vertices_of(&mesh.foliage).is_subset(&vertices), "{name}");
                // The trunk and limbs cannot all go: see below.
                let stuck = name == "plain" && budget <= 248 && mesh.triangles() <= 340;
                assert!(
                    stuck || mesh.triangles() <= budget,
                    "{name}: {}",
                    mesh.triangles()
                );
            }
            assert!(method(olive(), 10_640).triangles() > 9_000, "{name}");
        }
    }

    #[test]
    fn a_simplifier_that_is_stuck_shows_it_by_its_count() {
        let stuck = plain(olive(), 4);
        assert!(stuck.triangles() > 4, "{}", stuck.triangles());
        check::mesh(&stuck).expect("sound");
    }

    #[test]
    fn a_budget_that_is_met_already_changes_nothing() {
        for (name, method) in METHODS {
            for budget in [olive().triangles(), u64::MAX] {
                assert!(method(olive(), budget) == *olive(), "{name} at {budget}");
            }
            for budget in [0, 4, u64::MAX] {
                assert!(method(&Mesh::default(), budget) == Mesh::default());
                assert!(
                    method(&cards(&[4]), budget).triangles() <= 4,
                    "foliage alone"
                );
            }
        }
    }

    #[test]
    fn a_triangle_between_bark_and_leaf_is_left_out() {
        let mut mesh = cards(&[2, 2]);
        mesh.bark = cards(&[4]).foliage;
        // Six vertices of bark, then those of the leaves.
        let method = |indices: &[u32], _: &VertexDataAdapter<'_>, target: usize| {
            assert_eq!((indices.len(), target), (24, 21));
            assert_eq!(indices[12..15], [6, 8, 9]);
            vec![0, 2, 3, 5, 6, 7, 10, 12, 13, 4, 5, 13]
        };
        let mixed = whole(&mesh, 7, method);
        check::mesh(&mixed).expect("sound");
        let vertices = |primitive: &Primitive, numbers: [usize; 3]| {
            numbers.map(|number| primitive.vertices[number]).to_vec()
        };
        assert_eq!(mixed.bark.vertices, vertices(&mesh.bark, [0, 2, 3]));
        assert_eq!(mixed.foliage.vertices, vertices(&mesh.foliage, [4, 6, 7]));
        assert_eq!(mixed.triangles(), 2);
    }

    #[test]
    fn bark_alone_stays_within_its_budget() {
        for budget in [0, 4, 100, 1000, u64::MAX] {
            let primitive = bark(&olive().bark, budget);
            assert!(primitive.triangles() <= budget);
            check::mesh(&Mesh {
                bark: primitive,
                ..Mesh::default()
            })
            .expect("sound");
        }
        assert!(bark(&Primitive::default(), 4) == Primitive::default());
    }
}
