//! The same script, seed and version make the same bytes in every file, at any number of threads.

mod common;

use common::{Sketch, small};
use pleach::pack::{self, Options, PackFile};
use pleach::pipeline::{self, Settings};
use pleach::report::Quiet;
use pleach::species::Beside;
use pleach::{capture, shadow};

/// A pack of a small tree that uses all that could differ: variants, tropism, stems, roots, captures of
/// captures.
fn built(threads: usize, source: capture::Source, seed: u64) -> Vec<PackFile> {
    let mut sketch = Sketch {
        stems: Some(3),
        roots: true,
        ..small()
    };
    sketch.branches[1].variants = 2;
    sketch.branches[2].tropism = -0.2;
    let settings = Settings {
        seed: Some(seed),
        budgets: Some(vec![6000, 500, 4]),
        full: true,
        captures: capture::Settings {
            atlas_size: 256,
            source,
            ..capture::Settings::default()
        },
        bark_size: 64,
        shadows: shadow::Settings {
            size: 64,
            bands: 2,
            samples: 6,
            ..shadow::Settings::default()
        },
        ..Settings::default()
    };
    let options = Options {
        embed: true,
        mips: true,
        no_wind: false,
    };
    let build = || {
        let images = Beside(std::path::PathBuf::new());
        let asset = pipeline::generate(&sketch.species(), &settings, &images, &Quiet)
            .expect("a small tree is made");
        pack::build(&asset, b"the script", options).expect("a small pack is built")
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads can be started")
        .install(build)
}

fn same(a: &[PackFile], b: &[PackFile]) {
    let names = |files: &[PackFile]| files.iter().map(|f| f.path.clone()).collect::<Vec<_>>();
    assert_eq!(names(a), names(b));
    for (a, b) in a.iter().zip(b) {
        assert!(a.bytes == b.bytes, "{} differs", a.path);
    }
}

#[test]
fn a_pack_is_the_same_bytes_at_any_number_of_threads_and_every_time() {
    let one = built(1, capture::Source::Direct, 5);
    assert!(one.len() > 12, "{} files", one.len());
    assert!(one.iter().all(|file| !file.bytes.is_empty()));
    same(&one, &built(2, capture::Source::Direct, 5));
    same(&one, &built(5, capture::Source::Direct, 5));
    same(&one, &built(1, capture::Source::Direct, 5));
}

#[test]
fn captures_of_captures_are_the_same_bytes_at_any_number_of_threads() {
    same(
        &built(1, capture::Source::Hierarchical, 5),
        &built(2, capture::Source::Hierarchical, 5),
    );
}

#[test]
fn another_seed_makes_another_pack() {
    let [five, six] = [5, 6].map(|seed| built(2, capture::Source::Direct, seed));
    let differ = |path: &str| {
        let of = |files: &[PackFile]| {
            let file = files.iter().find(|f| f.path == path);
            file.expect("a file of every pack").bytes.clone()
        };
        of(&five) != of(&six)
    };
    assert!(differ("sketch_LOD0.glb") && differ("textures/foliage_albedo.png"));
}
