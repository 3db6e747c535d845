//! `pleach evaluate`.

use super::args::{self, Evaluate};
use super::progress::Bar;
use super::table::table;
use super::{End, Failure};
use crate::evaluate::{
    self, Evaluation, ReferenceError, Settings, Subject, TABLE_HEADER, faults_above, table_rows,
};
use crate::pack::{self, PackContents, ReadError};
use crate::pipeline::{self, GenerateError};
use crate::species::schema::Species;
use crate::species::{Beside, Files};
use std::io::Write as _;
use std::path::Path;
use std::time::Instant;

pub(crate) fn run(args: &Evaluate) -> Result<End, Failure> {
    let begun = Instant::now();
    check(args)?;
    super::use_threads(args.threads.map(usize::from))?;
    let evaluation = if args.path.is_dir() {
        of_pack(args)?
    } else {
        of_script(args)?
    };
    if let Some(path) = &args.report {
        write_report(path, &evaluation)?;
    }
    eprintln!("{}", text(&evaluation));
    if let Some(path) = &args.report {
        eprintln!("report: {}", path.display());
    }
    eprintln!("in {:.1} s", begun.elapsed().as_secs_f32());
    if args.json {
        super::say(&evaluation)?;
    }
    gate(args, &evaluation)
}

/// Faults of the command line that would otherwise be found after the work.
fn check(args: &Evaluate) -> Result<(), Failure> {
    if args.rivals && cfg!(not(feature = "rivals")) {
        return Err(Failure::usage(
            "--rivals: this build has only the random rival, which is always compared; for the others build \
             with `cargo build --release --features rivals`",
        ));
    }
    if args
        .fail_above
        .is_some_and(|limit| limit.is_nan() || limit < 0.0)
    {
        return Err(Failure::usage(
            "--fail-above: write a part of the covered area that is not negative, such as 0.05 for 5 %",
        ));
    }
    let from_script = args.seed.is_some()
        || args.budgets.is_some()
        || args.texture_size.is_some()
        || args.changes.any();
    if args.path.is_dir() && from_script {
        return Err(Failure::usage(format!(
            "{} is a pack, which has its own seed, budgets and texture size; leave out --seed, --budgets, \
             --texture-size, --variation and --set, or evaluate its script",
            args.path.display()
        )));
    }
    let Some(report) = &args.report else {
        return Ok(());
    };
    if report.is_dir() || report.file_name().is_none() {
        return Err(Failure::usage(format!(
            "--report: {} is a folder; write the name of a file",
            report.display()
        )));
    }
    let folder = folder_of(report);
    if folder.is_dir() {
        Ok(())
    } else {
        Err(Failure::usage(format!(
            "--report: there is no folder {}",
            folder.display()
        )))
    }
}

fn of_script(args: &Evaluate) -> Result<Evaluation, Failure> {
    let (full, budgets) = args::budgets(args.budgets.as_deref()).map_err(Failure::usage)?;
    let mut settings = pipeline::Settings {
        seed: args.seed,
        full,
        budgets,
        ..pipeline::Settings::default()
    };
    if let Some(size) = args.texture_size {
        settings.captures.atlas_size = args::texture_size(size).map_err(Failure::usage)?;
    }
    let script = super::read_script(&args.path, &args.changes)?;
    let bar = Bar::alone(&script.species.name);
    let asset = grown(&args.path, &script.species, &settings, &script.files, &bar)?;
    let subject = Subject::of_asset(&asset, full);
    evaluate::evaluate(&subject, &wanted(args), &bar).map_err(Failure::input)
}

fn of_pack(args: &Evaluate) -> Result<Evaluation, Failure> {
    let pack = pack::read(&args.path).map_err(|error| match error {
        ReadError::Io { .. } => Failure::machine(error),
        _ => Failure::input(error),
    })?;
    let species = species_of(&pack)?;
    let bar = Bar::alone(&species.name);
    let settings = evaluate::settings_of(&pack);
    let files = Beside(pack.folder.clone());
    let grown = grown(&args.path, &species, &settings, &files, &bar)?;
    if pack.reliefs.is_empty() && !evaluate::same_atlas(&pack, &grown) {
        eprintln!(
            "warning: the pack's atlas is not what its script gives now, so it was made by another version or \
             with other settings; its captures are drawn without their depth, and shaded as leaves are"
        );
    }
    let subject = Subject::of_pack(&pack, &grown);
    evaluate::evaluate(&subject, &wanted(args), &bar).map_err(Failure::input)
}

fn species_of(pack: &PackContents) -> Result<Species, Failure> {
    let path = pack.folder.join("species.ron").display().to_string();
    let files = Beside(pack.folder.clone());
    crate::species::parse(&path, &pack.script, &files).map_err(|faults| {
        eprintln!("{}", faults.render(super::coloured()));
        Failure::input(format!(
            "{path}: the pack's tree cannot be grown again, and without it there is nothing to compare with"
        ))
    })
}

/// The tree, its first LOD the full one.
fn grown(
    path: &Path,
    species: &Species,
    settings: &pipeline::Settings,
    files: &dyn Files,
    bar: &Bar,
) -> Result<crate::asset::TreeAsset, Failure> {
    let at =
        |reason: &dyn std::fmt::Display| Failure::input(format!("{}: {reason}", path.display()));
    let settings =
        evaluate::with_reference(species, settings).map_err(|e: ReferenceError| at(&e))?;
    pipeline::generate(species, &settings, files, bar).map_err(|e: GenerateError| at(&e))
}

fn wanted(args: &Evaluate) -> Settings {
    let side = usize::from(args.views);
    Settings {
        side_views: side,
        aerial_views: side.div_ceil(2),
        plates: args.report.is_some(),
        rivals: args.rivals,
        ..Settings::default()
    }
}

/// What was compared, and the table of all models.
fn text(evaluation: &Evaluation) -> String {
    format!(
        "{}, seed {}: compared with {} triangles from {} side and {} aerial views; figures at {} px\n\n{}",
        evaluation.name,
        evaluation.seed,
        super::table::number(evaluation.reference_triangles),
        evaluation.side_views,
        evaluation.aerial_views,
        evaluation.heights.iter().max().copied().unwrap_or_default(),
        table(&TABLE_HEADER, table_rows(evaluation))
    )
}

fn gate(args: &Evaluate, evaluation: &Evaluation) -> Result<End, Failure> {
    let Some(limit) = args.fail_above else {
        return Ok(End::Done);
    };
    let faults = faults_above(evaluation, limit);
    if faults.is_empty() {
        return Ok(End::Done);
    }
    Err(Failure::input(format!(
        "{} is above what --fail-above allows\n  {}",
        evaluation.name,
        faults.join("\n  ")
    )))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Writes the report whole or not at all: beside its place, then renamed.
fn write_report(path: &Path, evaluation: &Evaluation) -> Result<(), Failure> {
    let fault = |e: &dyn std::fmt::Display| {
        Failure::machine(format!("cannot write {}: {e}", path.display()))
    };
    // Inside a temporary folder, so that the file is as readable as any new one.
    let folder = tempfile::Builder::new()
        .prefix(".pleach-report-")
        .tempdir_in(folder_of(path))
        .map_err(|e| fault(&e))?;
    let unfinished = folder.path().join("report.html");
    let mut file = std::fs::File::create_new(&unfinished).map_err(|e| fault(&e))?;
    file.write_all(evaluate::html(evaluation).as_bytes())
        .and_then(|()| file.sync_all())
        .map_err(|e| fault(&e))?;
    std::fs::rename(&unfinished, path).map_err(|e| fault(&e))
}
