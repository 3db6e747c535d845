//! The graph and what is made of it: growing ten million leaves, choosing a LOD, flattening.
//!
//! Flattening stands beside a plain fill of the same buffers with a running value: the most that the
//! memory gives. Both reuse their buffers.

use divan::counter::BytesCount;
use divan::{AllocProfiler, Bencher, black_box};
use pleach::impostor::cross_quad::CrossQuads;
use pleach::lod::{Selector, State};
use pleach::math::Similarity;
use pleach::mesh::{Flattener, Form, Mesh, Vertex};
use pleach::species::schema::{Curve, Species};
use pleach::species::{self, NoFiles};
use pleach::tree::{Limits, Tree, grow};
use rayon::prelude::*;

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

fn main() {
    let tree = millions();
    let leaves: u64 = tree.nodes()[4].iter().sum();
    eprintln!("{leaves} leaves in {} bytes", tree.bytes());
    let (tree, form) = full();
    let flattener = Flattener::new(&tree, &form);
    let mesh = flattener.tree().expect("the tree can be flattened");
    eprintln!(
        "flattened: {} vertices, {} bytes",
        mesh.bark.vertices.len() + mesh.foliage.vertices.len(),
        bytes(&mesh)
    );
    divan::main();
}

/// The olive without its two outermost levels of branches, and with its links multiplied: `[limbs, branches,
/// branchlets, sprigs]`.
fn olive(links: [u32; 4]) -> Species {
    let text = include_str!("../species/olive.ron");
    let mut species = species::parse("olive.ron", text, &NoFiles).expect("a sound script");
    species.levels.drain(4..6);
    species.levels[4].parent = Some(3);
    for (level, links) in species.levels[1..].iter_mut().zip(links) {
        level.placement.links = links;
        level.placement.children = 1;
        level.placement.skip = Curve::constant(0.0);
    }
    species
}

fn grown(species: &Species) -> Tree {
    let limits = Limits::default();
    grow(species, 1, &limits).expect("within the limits")
}

/// Ten million leaves: 40 limbs of 50 branches of 100 branchlets of 50 sprigs.
fn millions() -> Tree {
    grown(&olive([40, 50, 100, 50]))
}

#[divan::bench]
fn grow_ten_million_leaves(bencher: Bencher) {
    let species = olive([40, 50, 100, 50]);
    bencher.bench(|| grown(black_box(&species)));
}

#[divan::bench]
fn grow_count_and_bound_ten_million_leaves(bencher: Bencher) {
    let species = olive([40, 50, 100, 50]);
    bencher.bench(|| {
        let tree = grown(black_box(&species));
        (tree.nodes(), tree.extents(), tree)
    });
}

#[divan::bench]
fn select_one_budget(bencher: Bencher) {
    let species = olive([40, 50, 100, 50]);
    let tree = grown(&species);
    let selector = Selector::new(&tree, &species.lod);
    bencher.bench(|| selector.chain(black_box(&[10_000]), false));
}

#[divan::bench]
fn select_a_whole_chain_with_its_selector(bencher: Bencher) {
    let species = olive([40, 50, 100, 50]);
    let tree = grown(&species);
    bencher.bench(|| {
        let selector = Selector::new(black_box(&tree), &species.lod);
        selector.chain(&[50_000, 10_000, 2_000, 400, 4], false)
    });
}

/// An olive of more than a million vertices at full detail, and its geometry.
fn full() -> (Tree, Form) {
    let species = olive([14, 24, 32, 20]);
    let tree = grown(&species);
    let quads = CrossQuads::none(&tree, Vec::new());
    let form = quads.form(
        &tree,
        &State::full(&tree),
        pleach::mesh::Coat::plain(species.bark.height_m()),
    );
    (tree, form)
}

fn bytes(mesh: &Mesh) -> usize {
    let of =
        |p: &pleach::mesh::Primitive| size_of_val(&p.vertices[..]) + size_of_val(&p.indices[..]);
    of(&mesh.bark) + of(&mesh.foliage)
}

fn pool(threads: usize) -> rayon::ThreadPool {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().expect("threads can be started")
}

#[divan::bench(args = [1, 2])]
fn flatten(bencher: Bencher, threads: usize) {
    let (tree, form) = full();
    let flattener = Flattener::new(&tree, &form);
    let mut mesh = flattener.tree().expect("not too large");
    let bytes = BytesCount::new(bytes(&mesh));
    let pool = pool(threads);
    bencher.counter(bytes).bench_local(|| {
        pool.install(|| flattener.write(0, 0, &Similarity::IDENTITY, 1.0, black_box(&mut mesh)))
    });
}

#[divan::bench(args = [1, 2])]
fn fill_as_many_bytes(bencher: Bencher, threads: usize) {
    let (tree, form) = full();
    let mut mesh = Flattener::new(&tree, &form).tree().expect("not too large");
    let bytes = BytesCount::new(bytes(&mesh));
    let pool = pool(threads);
    bencher
        .counter(bytes)
        .bench_local(|| pool.install(|| fill(black_box(&mut mesh))));
}

/// Writes a running value into every vertex and index.
fn fill(mesh: &mut Mesh) {
    const CHUNK: usize = 16_384;
    for primitive in [&mut mesh.bark, &mut mesh.foliage] {
        let vertices = primitive.vertices.par_chunks_mut(CHUNK).enumerate();
        vertices.for_each(|(chunk, vertices)| {
            let mut value = chunk as f32;
            for vertex in vertices {
                value += 1.0;
                *vertex = Vertex {
                    position: [value; 3],
                    normal: [value; 3],
                    tangent: [value; 4],
                    uv: [value; 2],
                    tint: pleach::mesh::WHITE,
                };
            }
        });
        let indices = primitive.indices.par_chunks_mut(CHUNK).enumerate();
        indices.for_each(|(chunk, indices)| {
            let mut value = u32::try_from(chunk).unwrap_or(0);
            for index in indices {
                *index = value;
                value = value.wrapping_add(1);
            }
        });
    }
}

#[divan::bench]
fn prepare_to_flatten(bencher: Bencher) {
    let (tree, form) = full();
    bencher.bench(|| Flattener::new(black_box(&tree), &form).size(0, 0));
}
