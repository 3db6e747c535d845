//! `pleach generate`.

use super::args::{self, Baker, Generate};
use super::progress::Bar;
use super::{End, Failure, table};
use crate::pack::{self, Manifest};
use crate::pipeline::{self, Bakers, GenerateError, Settings};
use std::time::Instant;

pub(crate) fn run(args: &Generate) -> Result<End, Failure> {
    let begun = Instant::now();
    super::use_threads(args.threads.map(usize::from))?;
    let settings = settings(&args.tree, args.seed)?;
    let script = super::read_script(&args.species, &args.changes)?;
    let seed = args.seed.unwrap_or(script.species.seed);
    let name = pack::folder_name(&script.species.slug, seed);
    // Now as well as when writing, so that nobody waits for a tree that is then refused.
    pack::check_place(&args.out, &name, args.pack.replace()).map_err(Failure::write)?;
    pack::sweep(&args.out, |other| other == name);
    let oven = Oven::of(args.tree.baker)?;
    let bar = Bar::alone(&script.species.name);
    let (species, files) = (&script.species, &script.files);
    let asset = pipeline::generate_with(oven.bakers(), species, &settings, files, &bar)
        .map_err(|error| failure(&args.species, &error))?;
    let files =
        pack::build(&asset, script.text.as_bytes(), args.pack.options()).map_err(Failure::input)?;
    let folder =
        pack::write(&args.out, &name, &files, args.pack.replace()).map_err(Failure::write)?;
    drop(bar);
    let manifest = pack::read_manifest(&folder).map_err(Failure::machine)?;
    eprintln!("{}", super::inspect::manifest_text(&manifest));
    for warning in &manifest.warnings {
        eprintln!("warning: {warning}");
    }
    let total = manifest.files.iter().map(|f| f.bytes).sum();
    let seconds = begun.elapsed().as_secs_f32();
    eprintln!(
        "{} ({}) in {seconds:.1} s",
        folder.display(),
        table::bytes(total)
    );
    if args.json {
        let folder = folder.display().to_string();
        super::say(&Made {
            folder,
            pack: &manifest,
        })?;
    }
    Ok(End::Done)
}

/// What `--json` tells. A structure and no JSON value, whose numbers would be widened to 64 bits and
/// read otherwise than in `pack.json`.
#[derive(serde::Serialize)]
struct Made<'a> {
    folder: String,
    pack: &'a Manifest,
}

/// Settings from arguments; all of them are checked before any work.
fn settings(tree: &args::Tree, seed: Option<u64>) -> Result<Settings, Failure> {
    if tree.baker == Baker::Gpu && cfg!(not(feature = "gpu")) {
        return Err(Failure::usage(
            "--baker gpu: this build has no GPU backend; build with `cargo build --release --features gpu`, or use \
             --baker cpu, which needs no driver",
        ));
    }
    let (full, budgets) = args::budgets(tree.budgets.as_deref()).map_err(Failure::usage)?;
    let mut settings = Settings {
        seed,
        full,
        budgets,
        ..Settings::default()
    };
    tree.lods.apply(&mut settings);
    settings.captures.atlas_size = args::texture_size(tree.texture_size).map_err(Failure::usage)?;
    Ok(settings)
}

/// What draws captures and shadows.
enum Oven {
    Cpu,
    #[cfg(feature = "gpu")]
    Gpu(Box<crate::gpu_bake::Baker>),
}

impl Oven {
    /// The CPU unless an adapter is asked for by name: packs are the same bytes everywhere.
    fn of(baker: Baker) -> Result<Self, Failure> {
        match baker {
            Baker::Cpu | Baker::Auto => Ok(Self::Cpu),
            #[cfg(feature = "gpu")]
            Baker::Gpu => {
                let open = || crate::gpu_bake::Baker::new(&crate::gpu::Gpu::headless()?);
                let baker = open().map_err(|error| {
                    let message = format!("--baker gpu: {error}; or use --baker cpu");
                    if error.is_worth_another_try() {
                        Failure::machine(message)
                    } else {
                        Failure::input(message)
                    }
                })?;
                eprintln!("captures and shadows by {}", baker.gpu().describe());
                Ok(Self::Gpu(Box::new(baker)))
            }
            // Refused with the other settings.
            #[cfg(not(feature = "gpu"))]
            Baker::Gpu => Ok(Self::Cpu),
        }
    }

    fn bakers(&self) -> Bakers<'_> {
        match self {
            Self::Cpu => Bakers::CPU,
            #[cfg(feature = "gpu")]
            Self::Gpu(baker) => Bakers {
                captures: &**baker,
                shadows: &**baker,
            },
        }
    }
}

/// A tree that could not be made; the message names the script.
pub(crate) fn failure(path: &std::path::Path, error: &GenerateError) -> Failure {
    let message = format!("{}: {error}", path.display());
    if error.is_passing() {
        Failure::machine(message)
    } else {
        Failure::input(message)
    }
}
