//! A full set of textures of each species, 1024 by 1024 texels: its bark and its first leaf card, each with albedo,
//! alpha, normal, roughness, occlusion and translucency.

use divan::{Bencher, black_box};
use pleach::species::schema::{Bark, LeafLook, Species};
use pleach::species::{self, NoFiles};
use pleach::texture;
use std::path::Path;

/// Texels along the edge of both.
const SIZE: u32 = 1024;

fn main() {
    divan::main();
}

/// The scripts that need no other file.
fn scripts() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("species");
    let files = std::fs::read_dir(folder).expect("the species");
    let name = |file: std::fs::DirEntry| file.file_name().into_string().expect("a plain name");
    let mut names: Vec<String> = files.map(|f| name(f.expect("a file"))).collect();
    names.retain(|name| name.ends_with(".ron") && name != "palm.ron");
    names.sort();
    names
}

fn read(name: &str) -> Species {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("species")
        .join(name);
    let text = std::fs::read_to_string(path).expect("a script");
    species::parse(name, &text, &NoFiles).expect("a sound script")
}

#[divan::bench(args = scripts(), sample_count = 5, sample_size = 1)]
fn set(bencher: Bencher, name: &str) {
    let species = read(name);
    let kind = &species.leaves[0];
    let (Bark::Drawn(bark), LeafLook::Drawn(leaf)) = (&species.bark, &kind.look) else {
        panic!("{name} draws its textures");
    };
    bencher.bench(|| {
        rayon::join(
            || texture::bark(black_box(bark), 1, SIZE),
            || texture::leaf(black_box(kind), leaf, leaf.state, 1, SIZE, SIZE),
        )
    });
}
