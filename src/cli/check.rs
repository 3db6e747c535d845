//! `pleach check`.

use super::args::Check;
use super::{End, Failure};
use crate::pipeline::read_image;
use crate::species::schema::{Bark, LeafLook, Species};
use crate::species::{Beside, Faults, Files, parse};
use crate::tree::{self, Limits};
use serde_json::{Value, json};
use std::path::Path;

pub(crate) fn run(args: &Check) -> Result<End, Failure> {
    let mut faulty = 0;
    let mut reports = Vec::new();
    for path in &args.species {
        let report = one(path);
        if !report.is_empty() {
            faulty += 1;
        }
        reports.push(json!({ "file": path.display().to_string(), "faults": report }));
    }
    if args.json {
        super::say(&json!(reports))?;
    }
    if faulty == 0 {
        return Ok(End::Done);
    }
    eprintln!("{faulty} of {} scripts at fault", args.species.len());
    Ok(End::Input)
}

/// The faults of one script, told on stderr and returned for machines.
fn one(path: &Path) -> Vec<Value> {
    let shown = path.display().to_string();
    let plain = |message: String| {
        eprintln!("{shown}: {message}");
        vec![json!({ "message": message })]
    };
    let text = match std::fs::read(path)
        .map_err(|e| e.to_string())
        .and_then(|bytes| {
            String::from_utf8(bytes).map_err(|e| {
                format!(
                    "not text: byte {} is not UTF-8",
                    e.utf8_error().valid_up_to()
                )
            })
        }) {
        Ok(text) => text,
        Err(reason) => return plain(format!("cannot be read: {reason}")),
    };
    let files = Beside(path.parent().unwrap_or(Path::new("")).to_owned());
    match parse(&shown, &text, &files) {
        Err(faults) => {
            eprintln!("{}", faults.render(super::coloured()));
            faults_json(&faults)
        }
        Ok(species) => match tree::grow(&species, species.seed, &Limits::default()) {
            Err(error) => plain(error.to_string()),
            Ok(tree) => {
                let faults = image_faults(&species, &files);
                if !faults.is_empty() {
                    return faults.into_iter().flat_map(plain).collect();
                }
                let nodes: u64 = tree.nodes().iter().flatten().sum();
                eprintln!(
                    "{shown}: {} is fine ({} nodes)",
                    species.name,
                    super::table::number(nodes)
                );
                Vec::new()
            }
        },
    }
}

/// What is wrong with the image files that a species names.
fn image_faults(species: &Species, files: &dyn Files) -> Vec<String> {
    let leaves = species.leaves.iter().filter_map(|kind| match &kind.look {
        LeafLook::Image(path) => Some(path),
        LeafLook::Drawn(_) => None,
    });
    let bark = match &species.bark {
        Bark::Image { path, .. } => Some(path),
        Bark::Drawn(_) => None,
    };
    let fault = |path: &String| Some(read_image(path, files).err()?.to_string());
    leaves.chain(bark).filter_map(fault).collect()
}

fn faults_json(faults: &Faults) -> Vec<Value> {
    let one = |fault: &crate::species::Fault| {
        let (file, line, column) = faults.place(fault);
        json!({
            "file": file, "line": line, "column": column, "path": fault.path,
            "message": fault.message, "help": fault.help,
        })
    };
    faults.list().iter().map(one).collect()
}
