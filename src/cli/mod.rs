//! The command line: arguments, progress on a terminal, tables, exit codes. Thin: the work is elsewhere.

mod args;
mod batch;
mod check;
mod evaluate;
mod generate;
mod guide;
mod import;
mod inspect;
mod measure;
mod preview;
mod progress;
mod render;
mod studio;
mod table;

use clap::Parser as _;
use std::io::IsTerminal as _;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a command ends, as the design's contract on exit codes has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// Done, or already done.
    Done,
    /// The input is at fault, or an item failed for good.
    Input,
    /// The command line or the plan is at fault.
    Usage,
    /// The machine failed: worth another try.
    Machine,
    /// The user stopped it.
    Interrupted,
}

impl From<End> for ExitCode {
    fn from(end: End) -> Self {
        Self::from(match end {
            End::Done => 0,
            End::Input => 1,
            End::Usage => 2,
            End::Machine => 75,
            End::Interrupted => 130,
        })
    }
}

/// A command's failure: what to say, and how to end.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) end: End,
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn input(message: impl ToString) -> Self {
        Self {
            end: End::Input,
            message: message.to_string(),
        }
    }

    pub(crate) fn usage(message: impl ToString) -> Self {
        Self {
            end: End::Usage,
            message: message.to_string(),
        }
    }

    /// A pack that could not be written: the machine's fault, or something stands in the way.
    pub(crate) fn write(error: crate::pack::WriteError) -> Self {
        if error.is_machine_fault() {
            Self::machine(error)
        } else {
            Self::input(error)
        }
    }

    pub(crate) fn machine(message: impl ToString) -> Self {
        Self {
            end: End::Machine,
            message: message.to_string(),
        }
    }
}

/// Set by the first Ctrl-C or SIGTERM; stages look at it between steps.
pub(crate) static INTERRUPTED: AtomicBool = AtomicBool::new(false);

pub(crate) fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let args = args::Args::parse();
    // Without a handler (a second program in the process, say), a signal simply ends us at once; packs
    // stay whole either way.
    let _ = ctrlc::set_handler(|| INTERRUPTED.store(true, Ordering::Relaxed));
    let result = match &args.command {
        args::Command::Generate(args) => generate::run(args),
        args::Command::Evaluate(args) => evaluate::run(args),
        args::Command::Batch(args) => batch::run(args),
        args::Command::Check(args) => check::run(args),
        args::Command::Inspect(args) => inspect::run(args),
        args::Command::Measure(args) => measure::run(args),
        args::Command::Guide(args) => guide::run(args),
        args::Command::Import(args) => import::run(args),
        args::Command::Render(args) => render::run(args),
        args::Command::Preview(args) => preview::run(args),
        args::Command::Studio(args) => studio::run(args),
    };
    match result {
        Ok(end) => end.into(),
        Err(_) if interrupted() => {
            eprintln!("interrupted; nothing half-written is left");
            End::Interrupted.into()
        }
        Err(failure) => {
            let paint = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
            let word = if paint {
                "\u{1b}[1;31merror\u{1b}[0m"
            } else {
                "error"
            };
            eprintln!("{word}: {}", failure.message);
            failure.end.into()
        }
    }
}

/// True if reports on stderr may be coloured.
pub(crate) fn coloured() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

/// Writes machine text to stdout; a closed pipe is not a fault.
pub(crate) fn say(json: &impl serde::Serialize) -> Result<(), Failure> {
    use std::io::Write as _;
    let text = serde_json::to_string_pretty(json).map_err(Failure::machine)?;
    match writeln!(std::io::stdout(), "{text}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::machine(e)),
        _ => Ok(()),
    }
}

/// Why a window could not be shown.
#[cfg(feature = "preview")]
fn window_failure(error: crate::viewer::WindowError) -> Failure {
    if error.is_worth_another_try() {
        Failure::machine(error)
    } else {
        Failure::input(error)
    }
}

/// Writes a file whole or not at all, and says so.
pub(crate) fn write(path: &std::path::Path, bytes: &[u8]) -> Result<(), Failure> {
    let told =
        |e: std::io::Error| Failure::machine(format!("cannot write {}: {e}", path.display()));
    crate::disk::write_whole(path, bytes).map_err(told)?;
    eprintln!("{} ({})", path.display(), table::bytes(bytes.len() as u64));
    Ok(())
}

/// Limits the number of threads of all parallel work.
pub(crate) fn use_threads(threads: Option<usize>) -> Result<(), Failure> {
    let Some(threads) = threads else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(Failure::machine)
}

/// A script file with its text and species.
pub(crate) struct Script {
    pub(crate) text: String,
    pub(crate) species: crate::species::schema::Species,
    pub(crate) files: crate::species::Beside,
}

/// The text of a script with what the command line changes in it.
fn changed(
    shown: &str,
    text: String,
    files: &crate::species::Beside,
    changes: &args::Changes,
) -> Result<String, Failure> {
    use crate::species::edit;
    let mut text = text;
    if let Some(name) = &changes.variation {
        // What is at fault in the script is told where it is read for good.
        let Ok(species) = crate::species::parse(shown, &text, files) else {
            return Ok(text);
        };
        let known = species.variations.iter().find(|known| known.name == *name);
        let Some(variation) = known else {
            let names: Vec<&str> = species.variations.iter().map(|v| &v.name[..]).collect();
            let known = match names.is_empty() {
                true => "it has none".to_owned(),
                false => format!("there are {}", names.join(", ")),
            };
            let message = format!("--variation {name}: {shown} has no such variation; {known}");
            return Err(Failure::usage(message));
        };
        text = edit::vary(&text, &species, variation).map_err(Failure::usage)?;
    }
    for change in &changes.set {
        let Some((field, value)) = change.split_once('=') else {
            let message = format!("--set {change}: expected FIELD=VALUE, such as age=0.4");
            return Err(Failure::usage(message));
        };
        text = match edit::set(&text, field.trim(), value) {
            Ok(text) => text,
            Err(edit::EditError::Unreadable) => return Ok(text),
            Err(error) => return Err(Failure::usage(format!("--set {change}: {error}"))),
        };
    }
    Ok(text)
}

/// Reads a script and changes it; its faults become the failure's message.
pub(crate) fn read_script(
    path: &std::path::Path,
    changes: &args::Changes,
) -> Result<Script, Failure> {
    let bytes = std::fs::read(path)
        .map_err(|e| Failure::input(format!("cannot read {}: {e}", path.display())))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        Failure::input(format!(
            "{} is not text: byte {at} is not UTF-8",
            path.display()
        ))
    })?;
    let files =
        crate::species::Beside(path.parent().unwrap_or(std::path::Path::new("")).to_owned());
    let text = changed(&path.display().to_string(), text, &files, changes)?;
    match crate::species::parse(&path.display().to_string(), &text, &files) {
        Ok(species) => Ok(Script {
            text,
            species,
            files,
        }),
        Err(faults) => {
            eprintln!("{}", faults.render(coloured()));
            let count = faults.list().len();
            let faults = if count == 1 { "fault" } else { "faults" };
            Err(Failure::input(format!(
                "{}: {count} {faults}; nothing was made",
                path.display()
            )))
        }
    }
}
