//! The costly stages for the olive: all captures, from meshes and from captures, the measured menu of forms,
//! fronts under budgets, and everything from the species to the finished asset, without a disk.

use divan::{AllocProfiler, Bencher, black_box};
use pleach::capture::{self, LeafArtwork, Plan, Source, bake};
use pleach::image::{Image, Texel, mips};
use pleach::impostor::cross_quad::CrossQuads;
use pleach::lod::cut::Cutter;
use pleach::math::float;
use pleach::measure::menu::{self, Forms};
use pleach::measure::silhouette::Cutouts;
use pleach::pipeline;
use pleach::report::Quiet;
use pleach::species::schema::{Bark, LeafLook, Species};
use pleach::species::{self, NoFiles};
use pleach::texture;
use pleach::tree::{Limits, Tree, grow};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

fn olive() -> Species {
    let text = include_str!("../species/olive.ron");
    species::parse("olive.ron", text, &NoFiles).expect("a sound script")
}

/// Leaf cards drawn before the clock starts, and resized as asked.
struct Drawn(Vec<(f32, Image<Texel>)>);

impl LeafArtwork for Drawn {
    fn aspect(&self, kind: usize) -> f32 {
        self.0[kind].0
    }

    fn draw(&self, kind: usize, width: u32, height: u32) -> Image<Texel> {
        texture::resized(&self.0[kind].1, width, height)
    }

    fn kinds(&self) -> usize {
        self.0.len()
    }
}

fn drawn(species: &Species) -> Drawn {
    let card = |kind: &species::schema::LeafKind| {
        let aspect = kind.width_m / kind.length_m;
        let LeafLook::Drawn(art) = &kind.look else {
            panic!("the olive names no image");
        };
        let width = pleach::math::round_to_u32(float(512) * aspect);
        (aspect, texture::leaf(kind, art, art.state, 1, width, 512))
    };
    Drawn(species.leaves.iter().map(card).collect())
}

/// All captures, with an atlas whose largest capture has 512 texels.
fn captures(bencher: Bencher, source: Source) {
    let species = olive();
    let tree = grow(&species, 1, &Limits::default()).expect("within the limits");
    let plan = Plan::of(&tree);
    let leaves = drawn(&species);
    let Bark::Drawn(art) = &species.bark else {
        panic!("the olive's bark is drawn");
    };
    let bark = mips::chain(texture::bark(art, 1, 512), 10, capture::ALPHA_CUTOFF);
    let settings = capture::Settings {
        source,
        ..capture::Settings::default()
    };
    bencher.bench(|| {
        let bark = (
            &bark[..],
            pleach::mesh::Coat::plain(species.bark.height_m()),
        );
        bake(black_box(&tree), &plan, &leaves, bark, &settings, &Quiet)
    });
}

#[divan::bench(sample_count = 10)]
fn captures_as_by_default(bencher: Bencher) {
    captures(bencher, capture::Settings::default().source);
}

#[divan::bench(sample_count = 10)]
fn captures_from_meshes(bencher: Bencher) {
    captures(bencher, Source::Direct);
}

#[divan::bench(sample_count = 10)]
fn captures_from_captures(bencher: Bencher) {
    captures(bencher, Source::Hierarchical);
}

#[divan::bench(sample_count = 5)]
fn generate(bencher: Bencher) {
    let species = olive();
    let settings = pipeline::Settings::default();
    bencher.bench(|| pipeline::generate(black_box(&species), &settings, &NoFiles, &Quiet));
}

/// The menu of the seed's tree, measured.
fn forms(species: &Species, tree: &Tree) -> Forms {
    let sheet = capture::leaf_sheet(&drawn(species)).expect("one kind fits");
    let leaves = CrossQuads::none(tree, sheet.panes);
    let cutouts = Cutouts::of(&sheet.image);
    let turns = capture::standing(tree);
    let budgets = &species.lod.budgets;
    let meant_for = (&turns[..], &budgets[..], 1024);
    menu::forms(tree, &species.lod, &leaves, &cutouts, meant_for, &Quiet).expect("small enough")
}

/// What the studio waits for after an edit that changes no texture: growing, meshing and swaying at full detail.
#[divan::bench(sample_count = 40)]
fn sketch_after_an_edit(bencher: Bencher) {
    let (species, settings) = (olive(), pipeline::Settings::default());
    let mut sketcher = pipeline::Sketcher::default();
    let mut sketch = || sketcher.sketch(black_box(&species), &settings, &NoFiles);
    sketch().expect("it grows");
    bencher.bench_local(sketch);
}

#[divan::bench(sample_count = 5)]
fn measure_all_forms(bencher: Bencher) {
    let species = olive();
    let tree = grow(&species, 2, &Limits::default()).expect("within the limits");
    bencher.bench(|| forms(&species, black_box(&tree)));
}

#[divan::bench(args = [400, 2_000, 10_000], sample_count = 20)]
fn cut_a_front(bencher: Bencher, budget: u64) {
    let species = olive();
    let tree = grow(&species, 2, &Limits::default()).expect("within the limits");
    let forms = forms(&species, &tree);
    let cutter = Cutter::new(&tree, &forms.menu);
    bencher.bench(|| cutter.cut(black_box(budget)));
}
