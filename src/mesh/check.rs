//! Invariant checkers. They return a reason, and run over every species at every LOD in the tests.

use super::{Mesh, Primitive};
use crate::math::Vec3;
use crate::tree::{Part, Tree};

/// Checks both primitives: whole triangles, indices in range, no vertex unused, finite positions, unit
/// normals and tangents at right angles, handedness 1 or -1, foliage uv in 0..=1.
///
/// # Errors
/// The first fault found, in words.
pub fn mesh(mesh: &Mesh) -> Result<(), String> {
    primitive(&mesh.bark).map_err(|fault| format!("bark: {fault}"))?;
    primitive(&mesh.foliage).map_err(|fault| format!("foliage: {fault}"))?;
    for (index, vertex) in mesh.foliage.vertices.iter().enumerate() {
        if vertex.uv.iter().any(|c| !(-1e-6..=1.000_001).contains(c)) {
            return Err(format!(
                "foliage: vertex {index} has uv {:?} outside the atlas",
                vertex.uv
            ));
        }
    }
    Ok(())
}

fn primitive(primitive: &Primitive) -> Result<(), String> {
    let count = primitive.vertices.len();
    if !primitive.indices.len().is_multiple_of(3) {
        return Err(format!(
            "{} indices are not whole triangles",
            primitive.indices.len()
        ));
    }
    if !primitive.sway.is_empty() && primitive.sway.len() != count {
        let sway = primitive.sway.len();
        return Err(format!("{sway} of {count} vertices sway"));
    }
    let mut used = vec![false; count];
    for &index in &primitive.indices {
        match used.get_mut(index as usize) {
            Some(slot) => *slot = true,
            None => return Err(format!("index {index} is past the {count} vertices")),
        }
    }
    if let Some(index) = used.iter().position(|&u| !u) {
        return Err(format!("vertex {index} belongs to no triangle"));
    }
    for (index, vertex) in primitive.vertices.iter().enumerate() {
        let [x, y, z, handedness] = vertex.tangent;
        let (normal, tangent) = (Vec3::from(vertex.normal), Vec3::new(x, y, z));
        let finite = vertex
            .position
            .iter()
            .chain(&vertex.uv)
            .all(|c| c.is_finite());
        let unit = |v: Vec3| (v.length() - 1.0).abs() < 2e-3;
        if !finite || !unit(normal) || !unit(tangent) || handedness.abs() != 1.0 {
            return Err(format!("vertex {index} is broken: {vertex:?}"));
        }
        if normal.dot(tangent).abs() > 5e-3 {
            return Err(format!(
                "vertex {index}: tangent leans on the normal: {vertex:?}"
            ));
        }
    }
    Ok(())
}

/// Checks every junction of the graph for an open crack: the first ring of a branch must lie inside the
/// tube of its parent, even where that parent's node is at its thinnest and its cross-section is the
/// triangle of the coarsest LOD.
///
/// # Errors
/// The first open junction, in words.
pub fn junctions(tree: &Tree) -> Result<(), String> {
    for (level, shared) in tree.levels.iter().enumerate() {
        for (index, prototype) in shared.prototypes.iter().enumerate() {
            let Part::Branch(parent) = &prototype.part else {
                continue;
            };
            let thinnest = tree
                .levels
                .iter()
                .flat_map(|l| &l.prototypes)
                .flat_map(|p| &p.links)
                .filter(|l| l.level as usize == level && l.prototype as usize == index)
                .map(|l| l.thickness)
                .fold(f32::INFINITY, f32::min);
            let thinnest = if thinnest.is_finite() { thinnest } else { 1.0 };
            for link in &prototype.links {
                let child = tree.prototype(link.level as usize, link.prototype as usize);
                let Part::Branch(child) = &child.part else {
                    continue;
                };
                let ring = child.axis[0].radius * link.place.scale * link.thickness;
                // A regular triangle's inscribed circle has half the radius of its corners; that both tubes' corners
                // stand off alike leaves a little more.
                let room = parent.at(link.at).radius * thinnest * 0.5;
                if ring > room {
                    return Err(format!(
                        "level `{}`: a ring of {ring} m on `{}` at {} has only {room} m to hide in",
                        tree.levels[link.level as usize].name, shared.name, link.at
                    ));
                }
            }
        }
    }
    Ok(())
}
