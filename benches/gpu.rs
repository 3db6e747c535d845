//! All captures and the nine shadows of three trees, as they are baked again after an edit: by the processor, and by
//! whatever adapter there is. First both in turn, so that a machine whose speed changes is as fair to one as to the
//! other, with what the adapter is asked for; then each by itself, unless only `in_turn` is asked for.

use divan::{Bencher, black_box};
use pleach::capture::{self, ALPHA_CUTOFF, LeafArtwork, Plan};
use pleach::gpu::Gpu;
use pleach::gpu_bake::Baker;
use pleach::image::{Image, Texel, mips};
use pleach::impostor::cross_quad::CrossQuads;
use pleach::lod::Selector;
use pleach::math::byte_from_unit;
use pleach::mesh::{Coat, Flattener, Mesh};
use pleach::report::Quiet;
use pleach::shadow;
use pleach::species::schema::{Bark, LeafLook, Species};
use pleach::species::{self, Beside};
use pleach::texture;
use pleach::tree::{Limits, Tree, grow};
use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

/// A crown of many small cards, a larger one, and fronds of long ones.
const SPECIES: [&str; 3] = ["olive", "english_oak", "palm"];

/// Rounds of the processor and the adapter in turn.
const ROUNDS: usize = 7;

fn main() {
    match baker() {
        Some(baker) => {
            println!("adapter: {}", baker.gpu().describe());
            let mut asked = std::env::args().skip(1).filter(|a| a != "--bench");
            if asked.next().is_none_or(|only| only == "in_turn") {
                for slug in SPECIES {
                    in_turn(slug, baker);
                }
            }
        }
        None => println!("no adapter: the processor alone"),
    }
    divan::main();
}

/// Medians of both, and how many times as long as the processor the adapter takes.
fn in_turn(slug: &str, baker: &Baker) {
    let subject = Subject::new(slug);
    let (baked, asked) = subject.captures(baker);
    println!("{slug}: captures: {asked:?}");
    subject.shadows(baker, &baked);
    println!("{slug}: shadows: {:?}", baker.take_tally());
    let mut times: [Vec<f64>; 6] = Default::default();
    for _ in 0..ROUNDS {
        let captures = [
            timed(|| subject.captures(&capture::Cpu)),
            timed(|| subject.captures(baker)),
        ];
        let shadows = [
            timed(|| subject.shadows(&shadow::Cpu, &baked)),
            timed(|| subject.shadows(baker, &baked)),
        ];
        let both = [captures[0] + shadows[0], captures[1] + shadows[1]];
        for (times, time) in times.iter_mut().zip([captures, shadows, both].concat()) {
            times.push(time);
        }
    }
    let medians = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    });
    let (pairs, _) = medians.as_chunks::<2>();
    for (what, [processor, adapter]) in ["captures", "shadows", "both"].iter().zip(pairs) {
        let ratio = adapter / processor;
        println!("{slug}: {what}: processor {processor:.3} s, adapter {adapter:.3} s: {ratio:.2}");
    }
}

/// Seconds that something takes.
fn timed<T>(work: impl FnOnce() -> T) -> f64 {
    let begun = Instant::now();
    black_box(work());
    begun.elapsed().as_secs_f64()
}

/// The adapter, if there is one, with its shaders compiled.
fn baker() -> Option<&'static Baker> {
    static BAKER: OnceLock<Option<Baker>> = OnceLock::new();
    let open = || Baker::new(&Gpu::headless()?);
    BAKER
        .get_or_init(|| open().inspect_err(|e| eprintln!("{e}")).ok())
        .as_ref()
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

/// A tree with all that does not change from bake to bake.
struct Subject {
    species: Species,
    tree: Tree,
    plan: Plan,
    leaves: Drawn,
    bark: Vec<Image<Texel>>,
}

impl Subject {
    fn new(slug: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("species");
        let name = format!("{slug}.ron");
        let text = std::fs::read_to_string(folder.join(&name)).expect("a script that is shipped");
        let species = species::parse(&name, &text, &Beside(folder)).expect("a sound script");
        let tree = grow(&species, 2, &Limits::default()).expect("within the limits");
        let card = |kind: &species::schema::LeafKind| {
            let LeafLook::Drawn(art) = &kind.look else {
                panic!("all leaves are drawn");
            };
            let aspect = kind.width_m / kind.length_m;
            (aspect, texture::leaf(kind, art, art.state, 2, 256, 256))
        };
        let Bark::Drawn(art) = &species.bark else {
            panic!("all bark is drawn");
        };
        Self {
            plan: Plan::of(&tree),
            leaves: Drawn(species.leaves.iter().map(card).collect()),
            bark: mips::chain(texture::bark(art, 2, 512), 10, ALPHA_CUTOFF),
            tree,
            species,
        }
    }

    fn captures(
        &self,
        backend: &dyn capture::Backend,
    ) -> (capture::Baked, pleach::gpu_bake::Tally) {
        let settings = capture::Settings::default();
        let bark = (&self.bark[..], Coat::plain(self.species.bark.height_m()));
        let (tree, plan) = (&self.tree, &self.plan);
        let baked = capture::bake_with(backend, tree, plan, &self.leaves, bark, &settings, &Quiet);
        let tally = baker().map(Baker::take_tally).unwrap_or_default();
        (baked.expect("fits, and nobody cancels"), tally)
    }

    /// What casts the shadows of a pack.
    fn caster(&self, quads: &CrossQuads) -> Mesh {
        let chain = Selector::new(&self.tree, &self.species.lod).chain(&[60_000], false);
        let form = quads.form(
            &self.tree,
            &chain.lods[0].state,
            Coat::plain(self.species.bark.height_m()),
        );
        Flattener::new(&self.tree, &form).tree().expect("small")
    }

    fn shadows(&self, backend: &dyn shadow::Backend, baked: &capture::Baked) -> shadow::Shadows {
        let alpha = baked.atlas.map(|t| byte_from_unit(t.alpha));
        let alpha = (&alpha, byte_from_unit(ALPHA_CUTOFF));
        let caster = self.caster(&baked.quads);
        let settings = shadow::Settings::default();
        shadow::bake_with(backend, &caster, alpha, &settings, &Quiet).expect("nobody cancels")
    }
}

#[divan::bench(args = SPECIES, sample_count = 10)]
fn captures_by_the_processor(bencher: Bencher, slug: &str) {
    let subject = Subject::new(slug);
    bencher.bench(|| black_box(&subject).captures(&capture::Cpu));
}

#[divan::bench(args = SPECIES, sample_count = 10)]
fn captures_by_the_adapter(bencher: Bencher, slug: &str) {
    let subject = Subject::new(slug);
    if let Some(baker) = baker() {
        bencher.bench(|| black_box(&subject).captures(baker));
    }
}

#[divan::bench(args = SPECIES, sample_count = 10)]
fn shadows_by_the_processor(bencher: Bencher, slug: &str) {
    let subject = Subject::new(slug);
    let (baked, _) = subject.captures(&capture::Cpu);
    bencher.bench(|| subject.shadows(&shadow::Cpu, black_box(&baked)));
}

#[divan::bench(args = SPECIES, sample_count = 10)]
fn shadows_by_the_adapter(bencher: Bencher, slug: &str) {
    let subject = Subject::new(slug);
    let (baked, _) = subject.captures(&capture::Cpu);
    if let Some(baker) = baker() {
        bencher.bench(|| subject.shadows(baker, black_box(&baked)));
    }
}
