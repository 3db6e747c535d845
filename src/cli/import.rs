//! `pleach import`.

use super::args::{Import, Source, WeberPenn};
use super::{End, Failure};
use crate::import::weber_penn;
use crate::species::{self, NoFiles};
use crate::tree::{Limits, grow};
use std::io::Write as _;
use std::path::Path;

pub(crate) fn run(args: &Import) -> Result<End, Failure> {
    match &args.from {
        Source::WeberPenn(args) => of_weber_penn(args),
    }
}

fn of_weber_penn(args: &WeberPenn) -> Result<End, Failure> {
    let shown = args.file.display();
    let bytes = std::fs::read(&args.file)
        .map_err(|e| Failure::input(format!("cannot read {shown}: {e}")))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        Failure::input(format!("{shown} is not text: byte {at} is not UTF-8"))
    })?;
    let imported = weber_penn::import(&text).map_err(|faults| {
        for fault in &faults {
            eprintln!("{shown}:{fault}");
        }
        let (count, faults) = match faults.len() {
            1 => (1, "fault"),
            count => (count, "faults"),
        };
        Failure::input(format!("{shown}: {count} {faults}; nothing was made"))
    })?;
    check(&imported.script, &shown.to_string())?;
    for note in &imported.notes {
        eprintln!("{note}");
    }
    eprintln!("(= used, ~ approximated, - without a counterpart or effect, ! look here)");
    match &args.out {
        Some(out) => {
            write(out, &imported.script, args.force)?;
            eprintln!("wrote {}", out.display());
        }
        None => {
            let written = std::io::stdout().write_all(imported.script.as_bytes());
            if let Err(e) = written.and_then(|()| std::io::stdout().flush())
                && e.kind() != std::io::ErrorKind::BrokenPipe
            {
                return Err(Failure::machine(e));
            }
        }
    }
    Ok(End::Done)
}

/// Parameters within their ranges may still make a tree that is none, or too large.
fn check(script: &str, shown: &str) -> Result<(), Failure> {
    let reason = match species::parse("script", script, &NoFiles) {
        Err(faults) => faults.render(false),
        Ok(species) => match grow(&species, species.seed, &Limits::default()) {
            Err(error) => error.to_string(),
            Ok(_) => return Ok(()),
        },
    };
    Err(Failure::input(format!(
        "{shown}: the script that its parameters make does not hold; nothing was written\n{reason}"
    )))
}

/// Writes a script; one that is there is replaced only if asked for.
fn write(path: &Path, script: &str, force: bool) -> Result<(), Failure> {
    let mut options = std::fs::OpenOptions::new();
    options.write(true);
    if force {
        options.create(true).truncate(true);
    } else {
        options.create_new(true);
    }
    options
        .open(path)
        .and_then(|mut file| file.write_all(script.as_bytes()))
        .map_err(|e| match e.kind() {
            std::io::ErrorKind::AlreadyExists => Failure::input(format!(
                "{} is there already; --force replaces it",
                path.display()
            )),
            _ => Failure::machine(format!("cannot write {}: {e}", path.display())),
        })
}
