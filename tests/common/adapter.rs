//! Tests that need a graphics adapter. Without one they show as ignored; with `PLEACH_REQUIRE_GPU=1` that is a
//! failure.

use libtest_mimic::{Arguments, Failed, Trial};
use pleach::gpu::Gpu;
use std::process::ExitCode;

/// What a test comes to.
pub(crate) type Outcome = Result<(), Failed>;

/// A test and its name.
pub(crate) type Test = (&'static str, fn() -> Outcome);

/// Runs tests that need an adapter, with the arguments of the process.
pub(crate) fn run(tests: &[Test]) -> ExitCode {
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
    let trials = tests
        .iter()
        .map(|&(name, test)| {
            let trial = match (&reason, required) {
                (Some(reason), true) => {
                    let reason = reason.clone();
                    Trial::test(name, move || Err(reason.into()))
                }
                _ => Trial::test(name, move || in_its_own_thread(name, test)),
            };
            let ignored = reason.is_some() && !required;
            trial
                .with_kind(if ignored { "no graphics adapter" } else { "" })
                .with_ignored_flag(ignored)
        })
        .collect();
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// The harness does not wait until what its threads keep to themselves is dropped, and a driver keeps much there:
/// it would go while the process leaves. A thread that is joined is gone.
fn in_its_own_thread(name: &str, test: fn() -> Outcome) -> Outcome {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(test)?
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// A device with nothing but what every adapter has: no optional features, the default limits.
pub(crate) fn plain() -> Result<Gpu, Failed> {
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    let instance = wgpu::Instance::new(descriptor);
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
    let (device, queue) =
        pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
    assert!(device.features().is_empty());
    Ok(Gpu::from_parts(device, queue, adapter.get_info()))
}
