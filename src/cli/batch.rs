//! `pleach batch`.

use super::args::{self, Batch};
use super::progress::{Bar, style};
use super::table::{number, table};
use super::{End, Failure};
use crate::batch::{Item, Observer, Outcome, Plan, RunOptions, run as run_plan};
use crate::pipeline::Settings;
use crate::report::Progress;
use indicatif::{MultiProgress, ProgressBar};
use serde_json::json;
use std::time::Instant;

/// One bar for the whole plan and one for each tree being made.
struct Bars {
    bars: MultiProgress,
    overall: ProgressBar,
}

impl Observer for Bars {
    fn item<'a>(&'a self, _worker: usize, item: &Item) -> Box<dyn Progress + 'a> {
        Box::new(Bar::among(&self.bars, &item.folder))
    }

    fn done(&self, _worker: usize, item: &Item, outcome: &Outcome) {
        self.overall.inc(1);
        if let Outcome::Failed { reason, .. } = outcome {
            let first = reason.lines().next().unwrap_or_default();
            self.bars
                .suspend(|| eprintln!("failed: {}: {first}", item.folder));
        }
    }

    fn cancelled(&self) -> bool {
        super::interrupted()
    }
}

pub(crate) fn run(args: &Batch) -> Result<End, Failure> {
    let begun = Instant::now();
    let mut plan = Plan::read(&args.jobs).map_err(Failure::usage)?;
    for item in &plan.items {
        if let Some(size) = item.texture_size {
            args::texture_size(size)
                .map_err(|e| Failure::usage(format!("{}: {e}", args.jobs.display())))?;
        }
    }
    if let Some(shard) = args.shard {
        plan = plan.shard(shard);
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut settings = Settings::default();
    args.lods.apply(&mut settings);
    let options = RunOptions {
        out: args.out.clone(),
        threads: args.threads.map_or(cores, usize::from),
        resume: args.resume,
        replace: args.pack.replace(),
        pack: args.pack.options(),
        settings,
    };
    let bars = MultiProgress::new();
    let overall = bars.add(ProgressBar::new(plan.items.len() as u64));
    overall.set_style(style("{msg} {wide_bar} {pos}/{len} {eta}"));
    overall.set_message("all trees");
    let observer = Bars { bars, overall };
    let outcomes = run_plan(&plan, &options, &observer).map_err(Failure::machine)?;
    observer.overall.finish_and_clear();
    let seconds = begun.elapsed().as_secs_f32();
    report(&plan, &outcomes, seconds);
    if args.json {
        super::say(&as_json(&plan, &outcomes))?;
    }
    Ok(end(&outcomes))
}

/// Exit by the worst outcome: a fault of the input is final, one of the machine is worth another try.
fn end(outcomes: &[Outcome]) -> End {
    let any = |f: fn(&Outcome) -> bool| outcomes.iter().any(f);
    if super::interrupted() && any(|o| matches!(o, Outcome::Cancelled)) {
        End::Interrupted
    } else if any(|o| matches!(o, Outcome::Failed { machine: false, .. })) {
        End::Input
    } else if any(|o| matches!(o, Outcome::Failed { machine: true, .. })) {
        End::Machine
    } else {
        End::Done
    }
}

fn report(plan: &Plan, outcomes: &[Outcome], seconds: f32) {
    let count = |f: fn(&Outcome) -> bool| outcomes.iter().filter(|o| f(o)).count();
    let made = count(|o| matches!(o, Outcome::Made { .. }));
    let kept = count(|o| matches!(o, Outcome::Kept));
    let failed = count(|o| matches!(o, Outcome::Failed { .. }));
    let cancelled = count(|o| matches!(o, Outcome::Cancelled));
    let rows = plan
        .items
        .iter()
        .zip(outcomes)
        .filter_map(|(item, outcome)| match outcome {
            Outcome::Made {
                triangles,
                warnings,
            } => {
                let lods: Vec<String> = triangles.iter().map(|&t| number(t)).collect();
                let note = match warnings.len() {
                    0 => String::new(),
                    1 => "1 warning".to_owned(),
                    n => format!("{n} warnings"),
                };
                Some(vec![item.folder.clone(), lods.join(" - "), note])
            }
            _ => None,
        });
    let rows: Vec<Vec<String>> = rows.collect();
    if !rows.is_empty() {
        eprintln!("{}\n", table(&["pack", "triangles", ""], rows));
    }
    let faults = plan
        .items
        .iter()
        .zip(outcomes)
        .filter_map(|(item, outcome)| match outcome {
            Outcome::Failed { reason, .. } => Some(vec![item.folder.clone(), reason.clone()]),
            _ => None,
        });
    let faults: Vec<Vec<String>> = faults.collect();
    if !faults.is_empty() {
        eprintln!("{}\n", table(&["failed", "why"], faults));
    }
    #[expect(clippy::cast_precision_loss, reason = "for people")]
    let rate = made as f32 * 60.0 / seconds.max(1e-3);
    let mut text = format!("{made} made, {kept} there already, {failed} failed");
    if cancelled > 0 {
        text += &format!(", {cancelled} not begun");
    }
    eprintln!("{text} in {seconds:.1} s ({rate:.0} trees a minute)");
}

fn as_json(plan: &Plan, outcomes: &[Outcome]) -> serde_json::Value {
    let one = |(item, outcome): (&Item, &Outcome)| {
        let mut value = json!({ "index": item.index, "pack": item.folder, "seed": item.seed });
        let (status, key, detail) = match outcome {
            Outcome::Made {
                triangles,
                warnings,
            } => {
                value["warnings"] = json!(warnings);
                ("made", "triangles", json!(triangles))
            }
            Outcome::Kept => return with_status(value, "kept"),
            Outcome::Failed { reason, machine } => {
                value["machine"] = json!(machine);
                ("failed", "reason", json!(reason))
            }
            Outcome::Cancelled => return with_status(value, "cancelled"),
        };
        value[key] = detail;
        with_status(value, status)
    };
    plan.items.iter().zip(outcomes).map(one).collect()
}

fn with_status(mut value: serde_json::Value, status: &str) -> serde_json::Value {
    value["status"] = json!(status);
    value
}
