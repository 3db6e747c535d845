//! `pleach inspect`: what a script or a pack holds.

use super::args::{self, Inspect};
use super::table::{bytes, number, table};
use super::{End, Failure};
use crate::asset::level_summaries;
use crate::capture::Plan;
use crate::lod::Selector;
use crate::math::Similarity;
use crate::pack::{self, Manifest};
use crate::tree::{self, Limits};
use serde_json::json;

pub(crate) fn run(args: &Inspect) -> Result<End, Failure> {
    if args.path.is_dir() {
        pack_folder(args)
    } else {
        script(args)
    }
}

fn pack_folder(args: &Inspect) -> Result<End, Failure> {
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
    let levels = manifest.levels.iter().map(|l| {
        vec![
            l.name.clone(),
            l.kind.clone(),
            l.prototypes.to_string(),
            number(l.nodes),
        ]
    });
    let lods = manifest.lods.iter().map(|l| {
        vec![
            format!("LOD{}", l.index),
            l.budget.map_or_else(|| "full".to_owned(), number),
            number(l.triangles),
            number(l.branches_triangles),
            number(l.foliage_triangles),
            format!("{:.3}", l.error_m),
            format!("{:.3}", l.screen_size),
            l.state.clone(),
        ]
    });
    let [atlas, _] = manifest.textures.foliage.size;
    format!(
        "{}{latin}, seed {}: all LODs within {height:.1} m of height and {width:.1} m of width; {} captures in an atlas of {atlas} x {atlas}\n\n{}\n\n{}",
        species.name,
        manifest.seed,
        manifest.captures,
        table(&["level", "kind", "#prototypes", "#nodes"], levels),
        table(
            &[
                "LOD",
                "#budget",
                "#triangles",
                "#bark",
                "#foliage",
                "#error m",
                "#screen",
                "state"
            ],
            lods
        ),
    )
}

fn script(args: &Inspect) -> Result<End, Failure> {
    let (full, budgets) = args::budgets(args.budgets.as_deref()).map_err(Failure::usage)?;
    let script = super::read_script(&args.path)?;
    let species = &script.species;
    let seed = args.seed.unwrap_or(species.seed);
    let tree = tree::grow(species, seed, &Limits::default())
        .map_err(|e| Failure::input(format!("{}: {e}", args.path.display())))?;
    let selector = Selector::new(&tree, &species.lod);
    let budgets = budgets.unwrap_or_else(|| species.lod.budgets.clone());
    let chain = selector.chain(&budgets, full);
    let size = tree.extents()[0][0].bounds(&Similarity::IDENTITY).size();
    let captures = Plan::of(&tree).captures();
    let summaries = level_summaries(&tree);
    eprintln!(
        "{}, seed {seed}: about {:.1} m high, {:.1} m wide; {captures} captures; {} triangles at full \
         detail; {} of memory for all nodes\n",
        species.name,
        size.y,
        size.x.max(size.z),
        number(selector.full_triangles()),
        bytes(tree.bytes() as u64),
    );
    let rows = summaries.iter().map(|l| {
        vec![
            l.name.clone(),
            l.kind.to_owned(),
            l.prototypes.to_string(),
            number(l.nodes),
        ]
    });
    eprintln!(
        "{}\n",
        table(&["level", "kind", "#prototypes", "#nodes"], rows)
    );
    let lods = chain.lods.iter().enumerate().map(|(index, l)| {
        vec![
            format!("LOD{index}"),
            l.budget.map_or_else(|| "full".to_owned(), number),
            number(l.triangles.total()),
            format!("{:.3}", l.error_m),
            l.state.describe(&tree),
        ]
    });
    eprintln!(
        "{}",
        table(&["LOD", "#budget", "#triangles", "#error m", "state"], lods)
    );
    for warning in &chain.warnings {
        eprintln!("warning: {warning}");
    }
    if args.json {
        let levels: Vec<_> = summaries
            .iter()
            .map(|l| json!({ "name": l.name, "kind": l.kind, "prototypes": l.prototypes, "nodes": l.nodes }))
            .collect();
        let lods: Vec<_> = chain
            .lods
            .iter()
            .map(|l| {
                json!({
                    "budget": l.budget, "triangles": l.triangles.total(), "error_m": l.error_m,
                    "screen_size": l.screen_size, "state": l.state.describe(&tree),
                })
            })
            .collect();
        super::say(&json!({
            "species": species.name, "seed": seed, "captures": captures,
            "full_triangles": selector.full_triangles(), "graph_bytes": tree.bytes(),
            "levels": levels, "lods": lods,
            "warnings": chain.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        }))?;
    }
    Ok(End::Done)
}
