//! Flattening a front: each node in a form of its own, where a [`super::Form`] draws all nodes of a level
//! alike.

use super::template::{Material, Template};
use super::{Mesh, Primitive, TooLarge, Vertex};
use crate::math::Similarity;
use crate::tree::{Kind, Tree};

/// What the nodes of each prototype may be drawn as.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wardrobe {
    /// By level and prototype: the offers, in the order that choices count in. Leaf levels have exactly one.
    pub offers: Vec<Vec<Vec<Dress>>>,
}

/// One form of a prototype's nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dress {
    /// Its own part's geometry, or nothing.
    pub template: Option<Template>,
    /// True if its children are drawn too.
    pub open: bool,
}

/// Flattens a front: `choices` are offers of the nodes from the root in the order of links, those of closed
/// nodes' children and of leaves left out. Choices that are missing or do not exist draw nothing.
///
/// # Errors
/// If 32-bit indices cannot address the result.
pub fn front(tree: &Tree, wardrobe: &Wardrobe, choices: &[u16]) -> Result<Mesh, TooLarge> {
    let mut mesh = Mesh::default();
    let mut choices = choices.iter().copied();
    node(
        tree,
        wardrobe,
        (0, 0),
        &Similarity::IDENTITY,
        1.0,
        &mut choices,
        &mut mesh,
    )?;
    Ok(mesh)
}

fn node(
    tree: &Tree,
    wardrobe: &Wardrobe,
    (level, prototype): (usize, usize),
    place: &Similarity,
    thickness: f32,
    choices: &mut dyn Iterator<Item = u16>,
    mesh: &mut Mesh,
) -> Result<(), TooLarge> {
    let is_leaf = tree.levels[level].kind == Kind::Leaf;
    let choice = if is_leaf { Some(0) } else { choices.next() };
    let dress = choice.and_then(|c| wardrobe.offers[level][prototype].get(usize::from(c)));
    let Some(dress) = dress else {
        return Ok(());
    };
    if let Some(template) = &dress.template {
        append(template, place, thickness, mesh)?;
    }
    if dress.open {
        for link in &tree.prototype(level, prototype).links {
            node(
                tree,
                wardrobe,
                (link.level as usize, link.prototype as usize),
                &tree.place(place, link),
                link.thickness,
                choices,
                mesh,
            )?;
        }
    }
    Ok(())
}

fn append(
    template: &Template,
    place: &Similarity,
    thickness: f32,
    mesh: &mut Mesh,
) -> Result<(), TooLarge> {
    let Primitive {
        vertices, indices, ..
    } = match template.material {
        Material::Bark => &mut mesh.bark,
        Material::Foliage => &mut mesh.foliage,
    };
    let (v, i) = (vertices.len(), indices.len());
    let end = v + template.vertices.len();
    let base = u32::try_from(v).map_err(|_| TooLarge { vertices: end })?;
    u32::try_from(end).map_err(|_| TooLarge { vertices: end })?;
    let zero: Vertex = bytemuck::Zeroable::zeroed();
    vertices.resize(end, zero);
    indices.resize(i + template.indices.len(), 0);
    template.write(
        place,
        thickness,
        &mut vertices[v..],
        &mut indices[i..],
        base,
    );
    Ok(())
}
