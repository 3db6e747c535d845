//! Tests that need a graphics adapter. Without one they show as ignored; with `PLEACH_REQUIRE_GPU=1` that is a
//! failure.

use libtest_mimic::{Arguments, Failed, Trial};
use pleach::gpu::Gpu;
use std::process::ExitCode;

/// How a test ends.
pub(crate) type Outcome = Result<(), Failed>;

/// Runs the tests that the command line asks for.
pub(crate) fn run(tests: &[(&str, fn() -> Outcome)]) -> ExitCode {
    let arguments = Arguments::from_args();
    let required = std::env::var_os("PLEACH_REQUIRE_GPU").is_some();
    let reason = match Gpu::headless() {
        Ok(gpu) => {
            eprintln!("drawing with {}", gpu.describe());
            None
        }
        Err(error) => {
            eprintln!("{error}");
            Some(error.to_string())
        }
    };
    let trial = |&(name, test): &(&str, fn() -> Outcome)| {
        let trial = match (&reason, required) {
            (Some(reason), true) => {
                let reason = reason.clone();
                Trial::test(name, move || Err(reason.into()))
            }
            _ => Trial::test(name, test),
        };
        let ignored = reason.is_some() && !required;
        trial
            .with_kind(if ignored { "no graphics adapter" } else { "" })
            .with_ignored_flag(ignored)
    };
    libtest_mimic::run(&arguments, tests.iter().map(trial).collect()).exit_code()
}
