//! Meshes for the tests of rivals.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use crate::impostor::cross_quad::CrossQuads;
use crate::lod::State;
use crate::math::{Vec3, float};
use crate::mesh::{Coat, Flattener, Mesh, Primitive, Vertex, WHITE};
use crate::species::{self, NoFiles};
use crate::tree::{Limits, grow};

/// The olive of `species/`, every leaf a card.
pub(super) fn olive() -> &'static Mesh {
    static OLIVE: LazyLock<Mesh> = LazyLock::new(|| {
        let text = include_str!("../../../species/olive.ron");
        let species = species::parse("olive.ron", text, &NoFiles).expect("a sound script");
        let tree = grow(&species, species.seed, &Limits::default()).expect("it grows");
        let coat = Coat::plain(species.bark.height_m());
        let form = CrossQuads::none(&tree, Vec::new()).form(&tree, &State::full(&tree), coat);
        Flattener::new(&tree, &form).tree().expect("small")
    });
    &OLIVE
}

/// Leaf cards of 2 or 4 triangles each, 0.1 m wide and up to a metre apart; the u of the first vertex of
/// each is its number as a part of all.
pub(super) fn cards(triangles: &[u32]) -> Mesh {
    let mut foliage = Primitive::default();
    let count = float(u32::try_from(triangles.len()).expect("few"));
    for (card, &triangles) in (0..).zip(triangles) {
        // Steps of the golden ratio: nowhere two cards at one place, nowhere a row.
        let place = |ratio: f32| (float(card) * ratio).fract() * 3.0;
        let corner = Vec3::new(place(0.618_034), place(0.754_878), place(0.569_84));
        let base = u32::try_from(foliage.vertices.len()).expect("few");
        for column in 0..=triangles / 2 {
            for y in [0.0, 1.0] {
                let at = corner + Vec3::new(float(column), y, 0.0) * 0.1;
                foliage.vertices.push(Vertex {
                    position: at.to_array(),
                    normal: [0.0, 0.0, 1.0],
                    tangent: [1.0, 0.0, 0.0, 1.0],
                    uv: [float(card) / count, y],
                    tint: WHITE,
                });
            }
            if column > 0 {
                let a = base + 2 * (column - 1);
                foliage.indices.extend([a, a + 2, a + 3, a, a + 3, a + 1]);
            }
        }
    }
    Mesh {
        foliage,
        ..Mesh::default()
    }
}

/// The vertices of a primitive as bits.
pub(super) fn vertices_of(primitive: &Primitive) -> BTreeSet<[u32; 13]> {
    primitive.vertices.iter().map(bits).collect()
}

/// True if every triangle's three vertices, to the bit, are a triangle of `full` in the same material.
/// Simplified bark is not asked for its triangles, only its vertices.
pub(super) fn is_subset(mesh: &Mesh, full: &Mesh) -> bool {
    let triangles = |primitive: &Primitive| -> BTreeSet<[[u32; 13]; 3]> {
        let corner = |i: &u32| bits(&primitive.vertices[*i as usize]);
        let triangles = primitive.indices.chunks_exact(3);
        triangles
            .map(|t| [corner(&t[0]), corner(&t[1]), corner(&t[2])])
            .collect()
    };
    triangles(&mesh.foliage).is_subset(&triangles(&full.foliage))
        && vertices_of(&mesh.bark).is_subset(&vertices_of(&full.bark))
}

fn bits(vertex: &Vertex) -> [u32; 13] {
    bytemuck::cast(*vertex)
}
