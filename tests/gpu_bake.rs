//! Captures and shadows drawn by a graphics adapter, held against the processor's.

mod common;

use common::adapter::{self, Outcome};
use common::{Script, all_scripts, scripts, small};
use pleach::capture::{
    self, ALPHA_CUTOFF, Backend, BakeError, Foliage, LeafArtwork, Occlusion, Pass, Picture, Plan,
    Scene, Shot, Source, Textures, View,
};
use pleach::gpu::Gpu;
use pleach::gpu_bake::Baker;
use pleach::image::atlas::Rect;
use pleach::image::{Image, Texel, mips};
use pleach::math::{Vec3, float};
use pleach::mesh::{Coat, Mesh, Primitive, Vertex};
use pleach::pack;
use pleach::pipeline::{self, Bakers, GenerateError, Settings};
use pleach::report::{Cancelled, Progress, Quiet};
use pleach::shadow::{self, Work};
use pleach::species::Beside;
use std::process::{Command, ExitCode};
use std::sync::{Mutex, OnceLock};

fn main() -> ExitCode {
    adapter::run(&[
        (
            "captures_and_shadows_of_every_species_are_the_processors",
            every_species,
        ),
        ("captures_from_captures_are_the_processors", hierarchical),
        (
            "one_leaf_bare_wood_and_nothing_at_all_are_drawn",
            degenerate,
        ),
        (
            "no_thread_has_too_much_to_draw",
            no_thread_has_too_much_to_draw,
        ),
        (
            "more_than_a_sheet_holds_is_drawn_on_several",
            several_sheets,
        ),
        ("one_adapter_draws_the_same_twice", same_twice),
        ("what_no_adapter_can_hold_is_refused_in_words", too_large),
        ("a_lost_device_is_told_and_not_a_panic", lost),
        ("cancelling_ends_the_work", cancelled),
        ("a_pack_says_that_an_adapter_drew_it", manifest_says),
    ])
}

/// Largest mean error of any channel over covered texels, and of shadows over texels that are not lit: 2 of 255.
const MEAN_ERROR: f64 = 2.0;

/// Least intersection over union of what is covered.
const IOU: f64 = 0.99;

fn baker() -> Result<&'static Baker, String> {
    static BAKER: OnceLock<Result<Baker, String>> = OnceLock::new();
    let open = || Baker::new(&Gpu::headless()?);
    let opened = BAKER.get_or_init(|| open().map_err(|e: pleach::gpu::GpuError| e.to_string()));
    opened.as_ref().map_err(Clone::clone)
}

/// Sums of differences, in 255ths.
#[derive(Clone, Debug, Default)]
struct Tally {
    /// By channel: sRGB albedo, normal, occlusion, roughness, translucency, depth in parts of the longer side.
    sums: [f64; 10],
    /// Of alpha, over all that either covers.
    alpha: f64,
    /// Texels that both cover in part, that either does, and those that both and either have at the cutoff.
    both: f64,
    either: f64,
    inter: f64,
    union: f64,
    /// The worst picture's intersection over union, among those of more than a few texels.
    worst: Option<f64>,
    pictures: usize,
    /// Shadows: sum of differences where either is dark, and their texels; the largest difference.
    shade: f64,
    shaded: f64,
    most: f64,
}

const NAMES: [&str; 10] = [
    "red",
    "green",
    "blue",
    "normal x",
    "normal y",
    "normal z",
    "occlusion",
    "roughness",
    "translucency",
    "depth",
];

impl Tally {
    fn pictures(&mut self, ours: &[Picture], theirs: &[Picture]) {
        assert_eq!(ours.len(), theirs.len(), "one picture a shot");
        for (a, b) in ours.iter().zip(theirs) {
            assert_eq!(a.shot, b.shot);
            self.picture(a, b);
        }
    }

    fn picture(&mut self, a: &Picture, b: &Picture) {
        let [width, height] = a.shot.texels;
        assert_eq!((b.image.width(), b.image.height()), (width, height));
        let view = &a.shot.view;
        let longer = 2.0 * view.half[0].max(view.half[1]);
        let (mut inter, mut union) = (0.0, 0.0);
        for (a, b) in a.image.texels().iter().zip(b.image.texels()) {
            let covers = [a, b].map(|t| t.alpha >= ALPHA_CUTOFF);
            inter += f64::from(u8::from(covers == [true; 2]));
            union += f64::from(u8::from(covers != [false; 2]));
            if a.alpha > 0.0 || b.alpha > 0.0 {
                self.either += 1.0;
                self.alpha += f64::from((a.alpha - b.alpha).abs()) * 255.0;
            }
            if a.alpha > 0.0 && b.alpha > 0.0 {
                self.both += 1.0;
                let [a, b] = [a, b].map(|t| channels(t, longer));
                for (sum, (a, b)) in self.sums.iter_mut().zip(a.into_iter().zip(b)) {
                    *sum += (a - b).abs();
                }
            }
        }
        self.pictures += 1;
        self.inter += inter;
        self.union += union;
        if union > 64.0 {
            let iou = inter / union;
            self.worst = Some(self.worst.map_or(iou, |w| w.min(iou)));
        }
    }

    fn shadows(&mut self, ours: &[Vec<u16>], theirs: &[Vec<u16>]) {
        assert_eq!(ours.len(), theirs.len(), "one map a light");
        for (a, b) in ours.iter().zip(theirs) {
            assert_eq!(a.len(), b.len());
            for (a, b) in a.iter().zip(b).filter(|(a, b)| (**a, **b) != (0, 0)) {
                let off = f64::from(a.abs_diff(*b)) / 256.0;
                self.shade += off;
                self.shaded += 1.0;
                self.most = self.most.max(off);
            }
        }
    }

    fn means(&self) -> [f64; 10] {
        self.sums.map(|sum| sum / self.both.max(1.0))
    }

    /// Prints and judges.
    fn judge(&self, what: &str) -> Outcome {
        let means = self.means();
        let all = means.iter().sum::<f64>() / 10.0;
        let alpha = self.alpha / self.either.max(1.0);
        let iou = if self.union > 0.0 {
            self.inter / self.union
        } else {
            1.0
        };
        let shade = self.shade / self.shaded.max(1.0);
        let named: Vec<String> = NAMES
            .iter()
            .zip(means)
            .map(|(name, mean)| format!("{name} {mean:.3}"))
            .collect();
        eprintln!(
            "{what}: {} pictures, {} covered texels; of 255: mean {all:.3}, alpha {alpha:.3}, {}; IoU {iou:.5}, worst \
             {:.5}; shadows {shade:.4}, at most {:.2}",
            self.pictures,
            self.both,
            named.join(", "),
            self.worst.unwrap_or(1.0),
            self.most,
        );
        let worst = means.into_iter().chain([alpha, shade]).fold(0.0, f64::max);
        if worst > MEAN_ERROR || iou < IOU {
            return Err(format!("{what}: a mean error of {worst:.3} of 255, IoU {iou:.4}").into());
        }
        Ok(())
    }
}

fn channels(texel: &Texel, longer: f32) -> [f64; 10] {
    let [r, g, b, _] = texel.albedo_bytes().map(f64::from);
    let [x, y, z] = texel.normal.map(|n| f64::from(n) * 127.5);
    let unit = |x: f32| f64::from(x) * 255.0;
    [
        r,
        g,
        b,
        x,
        y,
        z,
        unit(texel.occlusion),
        unit(texel.roughness),
        unit(texel.translucency),
        f64::from(texel.depth / longer) * 127.5,
    ]
}

/// Draws everything with both, compares, and hands on what the processor drew.
struct Both {
    gpu: &'static Baker,
    tally: Mutex<Tally>,
}

impl Both {
    fn new() -> Result<Self, String> {
        Ok(Self {
            gpu: baker()?,
            tally: Mutex::default(),
        })
    }

    fn tally(&self) -> Tally {
        self.tally.lock().expect("not poisoned").clone()
    }
}

impl Backend for Both {
    fn draw(
        &self,
        pass: &Pass<'_>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Picture>>, BakeError> {
        let ours = capture::Cpu.draw(pass, progress)?;
        let theirs = Backend::draw(self.gpu, pass, progress)?;
        assert_eq!(ours.len(), theirs.len(), "one list a scene");
        let mut tally = self.tally.lock().expect("not poisoned");
        for (ours, theirs) in ours.iter().zip(&theirs) {
            tally.pictures(ours, theirs);
        }
        Ok(ours)
    }
}

impl shadow::Backend for Both {
    fn sums(
        &self,
        work: &Work<'_>,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<u16>>, shadow::BakeError> {
        let ours = shadow::Cpu.sums(work, progress)?;
        let theirs = shadow::Backend::sums(self.gpu, work, progress)?;
        let mut tally = self.tally.lock().expect("not poisoned");
        tally.shadows(&ours, &theirs);
        Ok(ours)
    }
}

fn settings(atlas_size: u32) -> Settings {
    let mut settings = Settings {
        bark_size: 256,
        ..Settings::default()
    };
    settings.captures.atlas_size = atlas_size;
    settings
}

/// A tree of one of the scripts, made with something else than the processor.
fn made(
    script: &Script,
    captures: &dyn Backend,
    shadows: &dyn shadow::Backend,
    progress: &dyn Progress,
) -> Result<pleach::asset::TreeAsset, GenerateError> {
    let files = Beside(script.folder.clone());
    let bakers = Bakers { captures, shadows };
    pipeline::generate_with(bakers, &script.species, &settings(512), &files, progress)
}

/// The three scripts that are measured everywhere, or with `PLEACH_EVERY_SPECIES` all that are shipped.
fn every_species() -> Outcome {
    let all = std::env::var_os("PLEACH_EVERY_SPECIES").is_some();
    let scripts = if all { all_scripts() } else { scripts() };
    for script in scripts {
        let both = Both::new()?;
        made(&script, &both, &both, &Quiet).map_err(|e| e.to_string())?;
        let tally = both.tally();
        assert!(tally.pictures > 8 && tally.shaded > 1000.0, "{tally:?}");
        tally.judge(&script.slug)?;
    }
    Ok(())
}

/// An ellipse on each card, paler toward its tip.
struct Ellipses;

impl LeafArtwork for Ellipses {
    fn aspect(&self, _kind: usize) -> f32 {
        0.5
    }

    fn draw(&self, _kind: usize, width: u32, height: u32) -> Image<Texel> {
        let texel = |x: u32, y: u32| {
            let part = |at: u32, size: u32| (float(at) + 0.5) / float(size) * 2.0 - 1.0;
            let (x, y) = (part(x, width), part(y, height));
            Texel {
                albedo: [0.1, 0.3 - 0.1 * y, 0.05],
                alpha: if x * x + y * y < 0.9 { 1.0 } else { 0.0 },
                normal: [x * 0.4, 0.0, (1.0 - x * x * 0.16).sqrt()],
                translucency: 0.4,
                roughness: 0.6,
                ..Texel::EMPTY
            }
        };
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| texel(x, y)));
        Image::from_texels(width, height, texels.collect())
    }

    fn kinds(&self) -> usize {
        3
    }
}

fn bark() -> Vec<Image<Texel>> {
    let texels = (0..64 * 64).map(|i| Texel {
        albedo: [0.2, 0.12, 0.06].map(|c| c * (0.6 + 0.4 * float(i % 64 / 8 % 2))),
        alpha: 1.0,
        roughness: 0.9,
        ..Texel::EMPTY
    });
    // Longer than a chain of 64 texels can be: what is beyond is one texel again and again.
    mips::chain(
        Image::from_texels(64, 64, texels.collect()),
        10,
        ALPHA_CUTOFF,
    )
}

fn hierarchical() -> Outcome {
    let tree = small().tree();
    for (source, supersample) in [
        (Source::Hierarchical, 2),
        (Source::DirectUpTo(100), 1),
        (Source::Direct, 3),
    ] {
        let both = Both::new()?;
        let settings = capture::Settings {
            atlas_size: 512,
            supersample,
            source,
        };
        let bark = bark();
        let bark = (&bark[..], Coat::plain(0.5));
        capture::bake_with(
            &both,
            &tree,
            &Plan::of(&tree),
            &Ellipses,
            bark,
            &settings,
            &Quiet,
        )
        .map_err(|e| e.to_string())?;
        both.tally().judge(&format!("{source:?}"))?;
    }
    Ok(())
}

/// A view of a square metre about the origin.
fn view(samples: u32) -> View {
    View {
        centre: Vec3::ZERO,
        right: Vec3::X,
        up: Vec3::Y,
        half: [0.5, 0.5],
        width: samples,
        height: samples,
    }
}

fn card(half: f32, z: f32) -> Primitive {
    let vertex = |x: f32, y: f32| Vertex {
        position: [x * half, y * half, z],
        normal: [0.0, 0.0, 1.0],
        tangent: [1.0, 0.0, 0.0, 1.0],
        uv: [x * 0.5 + 0.5, 0.5 - y * 0.5],
        tint: pleach::mesh::WHITE,
    };
    Primitive {
        vertices: vec![
            vertex(-1.0, -1.0),
            vertex(1.0, -1.0),
            vertex(1.0, 1.0),
            vertex(-1.0, 1.0),
        ],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    }
}

/// Draws scenes of one mesh and shot each with both.
fn scenes(meshes: &[Mesh], texels: u32) -> Result<Tally, String> {
    scenes_of(meshes, &[texels])
}

/// The same with shots of several sizes in every scene.
fn scenes_of(meshes: &[Mesh], texels: &[u32]) -> Result<Tally, String> {
    let both = Both::new()?;
    let atlas = Ellipses.draw(0, 128, 128);
    let (bark, foliage) = (bark(), Foliage::of(atlas, 4));
    let parts = [Rect {
        x: 4,
        y: 4,
        width: 120,
        height: 120,
    }];
    let scene = |index: usize| {
        let mesh = meshes[index].clone();
        Ok(Scene {
            occlusion: Occlusion::unlit(&mesh),
            meshes: vec![mesh],
            shots: texels
                .iter()
                .map(|&texels| Shot::new(0, view(texels * 2), [texels; 2]))
                .collect(),
        })
    };
    let pass = Pass {
        textures: Textures {
            bark: &bark,
            foliage: &foliage,
            reliefs: &[],
        },
        parts: &parts,
        supersample: 2,
        scenes: meshes.len(),
        scene: &scene,
    };
    both.draw(&pass, &Quiet).map_err(|e| e.to_string())?;
    Ok(both.tally())
}

fn degenerate() -> Outcome {
    let leaf = Mesh {
        foliage: card(0.4, 0.1),
        ..Mesh::default()
    };
    let wood = Mesh {
        bark: card(0.3, -0.2),
        ..Mesh::default()
    };
    let mut flat = leaf.clone();
    flat.foliage
        .vertices
        .iter_mut()
        .for_each(|v| v.position = [0.1; 3]);
    let mut broken = wood.clone();
    broken.bark.vertices[0].position[1] = f32::NAN;
    let tally = scenes(&[leaf.clone(), wood, Mesh::default(), flat], 61)?;
    assert_eq!(tally.pictures, 4);
    assert!(tally.both > 1000.0, "{tally:?}");
    tally.judge("one leaf, bare wood, nothing, a point")?;
    scenes(&[broken], 8)?;
    scenes(&[], 8)?.judge("no scene")?;
    for mesh in [Mesh::default(), leaf] {
        let both = Both::new()?;
        let alpha = Image::filled(8, 8, 255);
        let settings = shadow::Settings {
            size: 50,
            ..shadow::Settings::default()
        };
        shadow::bake_with(&both, &mesh, (&alpha, 128), &settings, &Quiet)
            .map_err(|e| e.to_string())?;
        both.tally().judge("shadow of a leaf, and of nothing")?;
    }
    Ok(())
}

/// A software driver ends threads that go through too many loops.
fn no_thread_has_too_much_to_draw() -> Outcome {
    let alpha = Image::filled(8, 8, 255);
    let leaves = |foliage| Mesh {
        foliage,
        ..Mesh::default()
    };
    let both_kinds = Mesh {
        foliage: field(5, 0.19),
        bark: field(5, 0.19),
    };
    for (what, mesh) in [
        (
            "shadow of a card as wide as the map",
            leaves(card(2.0, 0.1)),
        ),
        ("shadow of many small cards", leaves(field(100, 0.006))),
        ("shadow of large cards and as much bark", both_kinds),
    ] {
        let both = Both::new()?;
        let settings = shadow::Settings::default();
        shadow::bake_with(&both, &mesh, (&alpha, 128), &settings, &Quiet)
            .map_err(|e| e.to_string())?;
        both.tally().judge(what)?;
    }
    Ok(())
}

/// Level cards apart from each other over two metres squared, as many along each side.
fn field(side: u16, half: f32) -> Primitive {
    let mut all = Primitive::default();
    for index in 0..side * side {
        let mut one = card(half, 0.0);
        let at = [index % side, index / side].map(|i| f32::from(i) * 2.0 / f32::from(side));
        for vertex in &mut one.vertices {
            let [x, y, _] = vertex.position;
            vertex.position = [at[0] + x, 0.1, at[1] + y];
        }
        let first = u32::try_from(all.vertices.len()).expect("few vertices");
        all.indices.extend(one.indices.iter().map(|i| i + first));
        all.vertices.extend(one.vertices);
    }
    all
}

fn several_sheets() -> Outcome {
    let mesh = |index: u8| Mesh {
        foliage: card(0.02 * f32::from(index) + 0.1, 0.0),
        bark: card(0.01, 0.1),
    };
    // Pictures of 2048 samples squared; a sheet holds one.
    let tally = scenes(&(0..3).map(mesh).collect::<Vec<_>>(), 1024)?;
    assert_eq!(tally.pictures, 3);
    tally.judge("three large pictures")?;
    // Pictures of several sizes; a sheet holds two scenes.
    let tally = scenes_of(&(0..5).map(mesh).collect::<Vec<_>>(), &[300, 30, 500])?;
    assert_eq!(tally.pictures, 15);
    tally.judge("fifteen pictures of three sizes")?;
    // Two pictures of one scene are more than sheets hold otherwise.
    let tally = scenes_of(&[mesh(3)], &[1100, 1100])?;
    assert_eq!(tally.pictures, 2);
    tally.judge("two large pictures of one scene")
}

fn same_twice() -> Outcome {
    let tree = small().tree();
    let plain = Baker::new(&adapter::plain()?)?;
    let bake = |baker: &Baker| {
        let bark = bark();
        let (bark, settings) = ((&bark[..], Coat::plain(0.5)), capture::Settings::default());
        capture::bake_with(
            baker,
            &tree,
            &Plan::of(&tree),
            &Ellipses,
            bark,
            &settings,
            &Quiet,
        )
        .map_err(|e| e.to_string())
    };
    let first = bake(baker()?)?;
    // A higher sheet, which is kept: what is drawn on it next must not depend on it.
    let leaf = Mesh {
        foliage: card(0.3, 0.0),
        ..Mesh::default()
    };
    scenes(&[leaf], 300)?;
    for (second, what) in [
        (bake(baker()?)?, "two bakes of one tree"),
        (bake(&plain)?, "bakes with and without optional features"),
    ] {
        if first.atlas != second.atlas || first.quads != second.quads {
            return Err(format!("{what} differ").into());
        }
    }
    Ok(())
}

fn too_large() -> Outcome {
    let mesh = Mesh {
        bark: card(0.3, 0.0),
        ..Mesh::default()
    };
    let scene = |_| {
        Ok(Scene {
            occlusion: Occlusion::unlit(&mesh),
            meshes: vec![mesh.clone()],
            shots: vec![Shot::new(0, view(1 << 20), [1 << 19; 2])],
        })
    };
    let bark = bark();
    let foliage = Foliage::of(bark[0].clone(), 10);
    let pass = Pass {
        textures: Textures {
            bark: &bark,
            foliage: &foliage,
            reliefs: &[],
        },
        parts: &[],
        supersample: 2,
        scenes: 1,
        scene: &scene,
    };
    match Backend::draw(baker()?, &pass, &Quiet) {
        Err(BakeError::Machine(fault)) if fault.reason.contains("1048576") && !fault.passing => {
            Ok(())
        }
        other => Err(format!("{:?}", other.err()).into()),
    }
}

fn lost() -> Outcome {
    let gpu = Gpu::headless()?;
    let baker = Baker::new(&gpu)?;
    gpu.device.destroy();
    let palm = scripts().into_iter().find(|s| s.slug == "palm");
    let palm = palm.ok_or("no palm")?;
    match made(&palm, &baker, &shadow::Cpu, &Quiet) {
        Err(GenerateError::Bake(BakeError::Machine(_))) => {}
        other => return Err(format!("captures: {:?}", other.err()).into()),
    }
    match made(&palm, &capture::Cpu, &baker, &Quiet) {
        Err(GenerateError::Machine(_)) => Ok(()),
        other => Err(format!("shadows: {:?}", other.err()).into()),
    }
}

/// Cancels in one stage, once it was asked so often.
struct Impatient {
    stage: &'static str,
    seen: Mutex<(bool, u32)>,
    patience: u32,
}

impl Progress for Impatient {
    fn begin(&self, stage: &'static str, _steps: u64) {
        self.seen.lock().expect("not poisoned").0 = stage == self.stage;
    }

    fn step(&self) {}

    fn cancelled(&self) -> bool {
        let mut seen = self.seen.lock().expect("not poisoned");
        seen.1 += u32::from(seen.0);
        seen.1 > self.patience
    }
}

fn cancelled() -> Outcome {
    let palm = scripts().into_iter().find(|s| s.slug == "palm");
    let palm = palm.ok_or("no palm")?;
    for (stage, patience) in [("captures", 0), ("captures", 3), ("shadows", 0)] {
        let progress = Impatient {
            stage,
            seen: Mutex::default(),
            patience,
        };
        let baker = baker()?;
        match made(&palm, baker, baker, &progress) {
            Err(
                GenerateError::Cancelled(Cancelled)
                | GenerateError::Bake(BakeError::Cancelled(Cancelled)),
            ) => {}
            other => return Err(format!("{stage}, {patience}: {:?}", other.err()).into()),
        }
    }
    Ok(())
}

fn manifest_says() -> Outcome {
    let dir = tempfile::tempdir()?;
    let script = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("species/palm.ron");
    let generate = |baker: &str, adapter: Option<&str>| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pleach"));
        command.arg("generate").arg(&script);
        command.args([
            "--texture-size",
            "256",
            "--budgets",
            "400,8",
            "--baker",
            baker,
        ]);
        command.arg("--out").arg(dir.path().join(baker));
        if let Some(adapter) = adapter {
            command.env("WGPU_ADAPTER_NAME", adapter);
        }
        command.output()
    };
    let refused = generate("gpu", Some("no such card"))?;
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    if refused.status.code() != Some(1) || !words.contains("--baker cpu") {
        return Err(format!("{:?}: {words}", refused.status).into());
    }
    for baker in ["gpu", "auto"] {
        let run = generate(baker, None)?;
        if !run.status.success() {
            return Err(String::from_utf8_lossy(&run.stderr).into_owned().into());
        }
        let folder = std::fs::read_dir(dir.path().join(baker))?
            .next()
            .ok_or("no pack")??;
        let manifest = pack::read_manifest(&folder.path()).map_err(|e| e.to_string())?;
        pack::verify(&folder.path(), &manifest).map_err(|e| e.to_string())?;
        assert_eq!(
            manifest.baker.is_some(),
            baker == "gpu",
            "{:?}",
            manifest.baker
        );
        let text = std::fs::read_to_string(folder.path().join("pack.json"))?;
        assert_eq!(text.contains("\"baker\""), baker == "gpu");
    }
    Ok(())
}
