//! `pleach inspect`: what a script or a pack holds.

use super::args::{self, Inspect};
use super::progress::Bar;
use super::table::{bytes, noted_table, number, table};
use super::{End, Failure};
use crate::lod::{SWITCH_PIXELS, Selector};
use crate::math::Similarity;
use crate::pack::{self, AskedEntry, LevelEntry, LodEntry, Manifest};
use crate::pipeline::{self, Settings};

pub(crate) fn run(args: &Inspect) -> Result<End, Failure> {
    if args.path.is_dir() {
        pack_folder(args)
    } else {
        script(args)
    }
}

fn pack_folder(args: &Inspect) -> Result<End, Failure> {
    if args.changes.any() {
        return Err(Failure::usage(format!(
            "{} is a pack, whose tree is grown already; leave out --variation and --set, or inspect its script",
            args.path.display()
        )));
    }
    let manifest = pack::read_manifest(&args.path).map_err(Failure::input)?;
    eprintln!("{}", manifest_text(&manifest));
    let files = manifest
        .files
        .iter()
        .map(|f| vec![f.path.clone(), bytes(f.bytes)]);
    eprintln!("\n{}", table(&["file", "#size"], files));
    for warning in &manifest.warnings {
        eprintln!("warning: {warning}");
    }
    if args.json {
        super::say(&manifest)?;
    }
    match pack::verify(&args.path, &manifest) {
        Ok(()) => Ok(End::Done),
        Err(fault) => Err(Failure::input(fault)),
    }
}

/// The species, levels and LODs of a pack, as tables.
pub(crate) fn manifest_text(manifest: &Manifest) -> String {
    let species = &manifest.species;
    let latin = if species.latin.is_empty() {
        String::new()
    } else {
        format!(" ({})", species.latin)
    };
    let height = manifest.bounds.max[1] - manifest.bounds.min[1];
    let width = (manifest.bounds.max[0] - manifest.bounds.min[0])
        .max(manifest.bounds.max[2] - manifest.bounds.min[2]);
    let [atlas, _] = manifest.textures.foliage.size;
    format!(
        "{}{latin}, seed {}: all LODs within {height:.1} m of height and {width:.1} m of width; {} in an atlas of {atlas} x {atlas}\n\n{}\n\n{}",
        species.name,
        manifest.seed,
        captures(manifest.captures, manifest.plane_captures),
        levels_text(&manifest.levels),
        lods_text(&manifest.lods),
    )
}

/// Levels as a table.
fn levels_text(levels: &[LevelEntry]) -> String {
    let rows = levels.iter().map(|l| {
        vec![
            l.name.clone(),
            l.kind.clone(),
            l.prototypes.to_string(),
            number(l.nodes),
        ]
    });
    table(&["level", "kind", "#prototypes", "#nodes"], rows)
}

/// Captures in words.
fn captures(sides: usize, planes: usize) -> String {
    match planes {
        0 => format!("{sides} captures"),
        _ => format!("{sides} captures and {planes} of fitted planes"),
    }
}

/// LODs as a table, each with its state on a line of its own, and what the numbers mean.
fn lods_text(lods: &[LodEntry]) -> String {
    let header = [
        "LOD",
        "#budget",
        "#triangles",
        "#used %",
        "#bark",
        "#foliage",
        "#error m",
        "#screen",
        "#IoU",
        "#coverage %",
        "#scale",
    ];
    let rows = lods.iter().map(|l| {
        let row = vec![
            format!("LOD{}", l.index),
            l.budget.map_or_else(|| "full".to_owned(), number),
            number(l.triangles),
            used(l).map_or_else(String::new, |used| format!("{:.0}", used * 100.0)),
            number(l.branches_triangles),
            number(l.foliage_triangles),
            format!("{:.3}", l.error_m),
            format!("{:.3}", l.screen_size),
            l.silhouette_iou
                .map_or_else(String::new, |i| format!("{i:.3}")),
            l.coverage
                .map_or_else(String::new, |c| format!("{:.1}", c * 100.0)),
            format!("{:.3}", l.scale),
        ];
        (row, l.state.clone())
    });
    let sizes: Vec<String> = lods
        .iter()
        .map(|l| format!("LOD{} {:.0}", l.index, pixels(l)))
        .collect();
    format!(
        "{}\n\n\
         Error is the edge, in metres, of the blocks over which a LOD covers as much as full detail to within\n\
         a tenth. Screen is the part of the picture's height that the tree fills when the LOD may take over:\n\
         its error is then at most {SWITCH_PIXELS} pixels of {LINES}. On a screen of {LINES} lines, that is a \
         tree of so many\npixels in height (the first LOD serves all greater heights as well): {}.",
        noted_table(&header, rows),
        sizes.join(", "),
    )
}

/// Lines of the screen in whose pixels sizes are told.
const LINES: u16 = 1080;

/// Height of the tree at which a LOD may take over, pixels of a screen of [`LINES`].
fn pixels(lod: &LodEntry) -> f32 {
    lod.screen_size * f32::from(LINES)
}

/// Part of its budget that a LOD uses; nothing for full detail, which has none.
#[expect(clippy::cast_precision_loss, reason = "a part, for people")]
fn used(lod: &LodEntry) -> Option<f32> {
    lod.budget
        .map(|budget| lod.triangles as f32 / budget.max(1) as f32)
}

/// Settings from arguments; all of them are checked before any work.
fn settings(args: &Inspect) -> Result<Settings, Failure> {
    let (full, budgets) = args::budgets(args.budgets.as_deref()).map_err(Failure::usage)?;
    let mut settings = Settings {
        seed: args.seed,
        full,
        budgets,
        ..Settings::default()
    };
    args.lods.apply(&mut settings);
    settings.captures.atlas_size = args::texture_size(args.texture_size).map_err(Failure::usage)?;
    Ok(settings)
}

/// A LOD of a script, in the words of a pack's manifest, and what follows from them.
#[derive(serde::Serialize)]
struct ScriptLod<'a> {
    #[serde(flatten)]
    lod: &'a LodEntry,
    /// Part of the budget.
    budget_used: Option<f32>,
    /// Height of the tree, pixels of a screen of 1080 lines, at which it may take over.
    pixels_of_1080: f32,
}

/// What `--json` tells of a script. Structures and no JSON values, whose numbers would be widened.
#[derive(serde::Serialize)]
struct ScriptJson<'a> {
    species: &'a str,
    seed: u64,
    captures: usize,
    plane_captures: usize,
    asked: AskedEntry,
    full_triangles: u64,
    graph_bytes: usize,
    levels: Vec<LevelEntry>,
    lods: Vec<ScriptLod<'a>>,
    warnings: Vec<String>,
}

/// Makes the tree, all but its files: what LODs look like is measured, so it cannot be told without.
fn script(args: &Inspect) -> Result<End, Failure> {
    let settings = settings(args)?;
    let script = super::read_script(&args.path, &args.changes)?;
    let bar = Bar::alone(&script.species.name);
    let asset = pipeline::generate(&script.species, &settings, &script.files, &bar)
        .map_err(|error| super::generate::failure(&args.path, &error))?;
    drop(bar);
    let tree = &asset.tree;
    let full_triangles = Selector::new(tree, &script.species.lod).full_triangles();
    let size = tree.extents()[0][0].bounds(&Similarity::IDENTITY).size();
    eprintln!(
        "{}, seed {}: about {:.1} m high, {:.1} m wide; {}; {} triangles at full detail; {} of memory for \
         all nodes\n",
        asset.name,
        asset.seed,
        size.y,
        size.x.max(size.z),
        captures(asset.captures, asset.plane_captures),
        number(full_triangles),
        bytes(tree.bytes() as u64),
    );
    let levels = LevelEntry::all(tree);
    let lods = LodEntry::all(&asset);
    eprintln!("{}\n\n{}", levels_text(&levels), lods_text(&lods));
    for warning in &asset.warnings {
        eprintln!("warning: {warning}");
    }
    if args.json {
        let lods = lods.iter().map(|lod| ScriptLod {
            lod,
            budget_used: used(lod),
            pixels_of_1080: pixels(lod),
        });
        super::say(&ScriptJson {
            species: &asset.name,
            seed: asset.seed,
            captures: asset.captures,
            plane_captures: asset.plane_captures,
            asked: (&asset.asked).into(),
            full_triangles,
            graph_bytes: tree.bytes(),
            levels,
            lods: lods.collect(),
            warnings: asset.warnings.iter().map(ToString::to_string).collect(),
        })?;
    }
    Ok(End::Done)
}
