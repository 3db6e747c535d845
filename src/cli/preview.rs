//! `pleach preview`: a window on a tree.

use super::args::Preview;
use super::{End, Failure};

#[cfg(not(feature = "preview"))]
pub(crate) fn run(args: &Preview) -> Result<End, Failure> {
    Err(Failure::usage(format!(
        "preview: this build has no window; build with `cargo build --release --features preview`, or draw {} \
         without one: `pleach render`",
        args.path.display()
    )))
}

#[cfg(feature = "preview")]
pub(crate) fn run(args: &Preview) -> Result<End, Failure> {
    use crate::math::float;
    use crate::viewer;
    let options = viewer::Options {
        size: args.size.map(float),
        stop: super::interrupted,
        ..viewer::Options::default()
    };
    viewer::run(&source(args)?, &options).map_err(super::window_failure)?;
    if super::interrupted() {
        return Ok(End::Interrupted);
    }
    Ok(End::Done)
}

/// What is to be shown. Faults inside a script are shown in the window, where they can be mended.
#[cfg(feature = "preview")]
fn source(args: &Preview) -> Result<crate::viewer::Source, Failure> {
    use super::args;
    use crate::pipeline::Settings;
    use crate::viewer::Source;
    let path = &args.path;
    if path.is_dir() {
        if args.seed.is_some() || args.budgets.is_some() {
            return Err(Failure::usage(format!(
                "{} is a pack, which has its own seed and budgets; leave out --seed and --budgets, or show its script",
                path.display()
            )));
        }
        crate::pack::read_manifest(path).map_err(Failure::input)?;
        return Ok(Source::Pack(path.clone()));
    }
    std::fs::File::open(path)
        .map_err(|e| Failure::input(format!("cannot read {}: {e}", path.display())))?;
    let (full, budgets) = args::budgets(args.budgets.as_deref()).map_err(Failure::usage)?;
    let mut settings = Settings {
        seed: args.seed,
        full: full || budgets.is_none(),
        budgets,
        ..Settings::default()
    };
    args.lods.apply(&mut settings);
    settings.captures.atlas_size = args::texture_size(args.texture_size).map_err(Failure::usage)?;
    Ok(Source::Script {
        path: path.clone(),
        settings: Box::new(settings),
    })
}
