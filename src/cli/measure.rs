//! `pleach measure`.

use super::args::Measure;
use super::progress::Bar;
use super::table::table;
use super::{End, Failure};
use crate::survey::reference::{self, Reference};
use crate::survey::{self, Line, SurveyError, Verdict};
use crate::tree::Limits;
use serde_json::json;
use std::time::Instant;

pub(crate) fn run(args: &Measure) -> Result<End, Failure> {
    let begun = Instant::now();
    super::use_threads(args.threads.map(usize::from))?;
    let script = super::read_script(&args.species, &args.changes)?;
    let species = &script.species;
    let foliage = survey::foliage(species, &script.files).map_err(Failure::input)?;
    let seeds: Vec<u64> = (1..=u64::from(args.seeds)).collect();
    let trees = {
        let bar = Bar::alone(&species.name);
        let trees = survey::survey(species, &foliage, &seeds, &Limits::default(), &bar);
        trees.map_err(|error| match error {
            SurveyError::Grow { .. } => {
                Failure::input(format!("{}: {error}", args.species.display()))
            }
            SurveyError::Cancelled(_) => Failure::machine(error),
        })?
    };
    let reference = reference::of_latin(&species.latin);
    let lines = survey::lines(&trees, reference);
    let latin = if species.latin.is_empty() {
        String::new()
    } else {
        format!(" ({})", species.latin)
    };
    eprintln!("{}{latin}: seeds 1 to {}\n", species.name, args.seeds);
    eprintln!("{}\n", text(&lines));
    eprintln!("{}", summary(&lines));
    match reference {
        Some(reference) => eprintln!("reference: {}", reference.sources),
        None => eprintln!("{}", unknown(&species.latin)),
    }
    eprintln!("in {:.1} s", begun.elapsed().as_secs_f32());
    if args.json {
        let species = json!({ "name": species.name, "latin": species.latin });
        super::say(&json!({
            "species": species,
            "seeds": seeds,
            "reference": reference.map(|r: &Reference| &r.latin),
            "sources": reference.map(|r| &r.sources),
            "lines": lines,
            "trees": trees,
        }))?;
    }
    Ok(End::Done)
}

/// All figures as a table.
fn text(lines: &[Line]) -> String {
    let rows = lines.iter().map(|line| {
        let [median, spread, range] = line.figures();
        let verdict = line.verdict.word().to_owned();
        vec![
            line.title(),
            median,
            spread,
            range,
            verdict,
            line.note.clone(),
        ]
    });
    table(
        &[
            "",
            "#median",
            "#P10 to P90",
            "#real trees",
            "verdict",
            "note",
        ],
        rows,
    )
}

/// How many figures lie within their range.
fn summary(lines: &[Line]) -> String {
    let count = |verdict| lines.iter().filter(|l| l.verdict == verdict).count();
    let within = count(Verdict::Within);
    let judged = within + count(Verdict::Below) + count(Verdict::Above);
    format!(
        "{within} of {judged} figures within; {} without reference",
        count(Verdict::NoReference)
    )
}

/// Says that nothing is known of a species.
fn unknown(latin: &str) -> String {
    let known = reference::all().len();
    if latin.is_empty() {
        format!("reference: the script has no `latin` name; {known} species are known by theirs")
    } else {
        format!("reference: `{latin}` is not among the {known} species of the table")
    }
}
