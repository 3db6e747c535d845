//! `pleach studio`: a window in which a species is made.

use super::args::Studio;
use super::{End, Failure};

#[cfg(not(feature = "studio"))]
pub(crate) fn run(args: &Studio) -> Result<End, Failure> {
    use clap::ValueEnum as _;
    let species = args.species.as_ref();
    let baker = args.baker.to_possible_value();
    let check = species.map_or(String::new(), |path| format!(" {}", path.display()));
    Err(Failure::usage(format!(
        "studio: this build has no studio; build with `cargo build --release --features studio`, or edit the script \
         with any editor and look at it with `pleach check{check}`; --out{}, --baker {} and --size {}x{} are its \
         options",
        args.out
            .as_ref()
            .map_or(String::new(), |out| format!(" {}", out.display())),
        baker.as_ref().map_or("auto", |value| value.get_name()),
        args.size[0],
        args.size[1],
    )))
}

#[cfg(feature = "studio")]
pub(crate) fn run(args: &Studio) -> Result<End, Failure> {
    use super::args::SketchBaker;
    use crate::math::float;
    use crate::studio::document::Document;
    use crate::studio::kept::{self, Keeper};
    use crate::studio::{self, Begin, recovery, templates};
    let document = match &args.species {
        Some(path) => Document::open(path)
            .map_err(|e| Failure::input(format!("cannot read {}: {e}", path.display())))?,
        None => Document::new(templates::BLANK.to_owned()),
    };
    let baker = match args.baker {
        SketchBaker::Auto => studio::SketchBaker::Auto,
        SketchBaker::Cpu => studio::SketchBaker::Cpu,
        SketchBaker::Gpu => studio::SketchBaker::Gpu,
    };
    let notes = recovery::folder();
    let kept = Keeper::open(kept::file());
    let plain = Begin::new(document);
    let out = args.out.clone().or_else(|| kept.now.export.folder.clone());
    let begin = Begin {
        left: notes.as_deref().map(recovery::left).unwrap_or_default(),
        notes,
        out: out.unwrap_or_else(|| plain.out.clone()),
        kept,
        baker,
        stop: super::interrupted,
        ..plain
    };
    studio::run(begin, args.size.map(float)).map_err(super::window_failure)?;
    if super::interrupted() {
        return Ok(End::Interrupted);
    }
    Ok(End::Done)
}
