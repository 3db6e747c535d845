//! Carries out a plan: workers take items one by one; one bad tree does not stop the rest.

use super::jobs::{Item, Plan};
use crate::asset::TreeAsset;
use crate::pack::{self, AskedEntry, Manifest, Options, Replace, WriteError};
use crate::pipeline::{self, GenerateError, Settings};
use crate::report::Progress;
use crate::species::Beside;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How a plan is carried out.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Folder of the packs.
    pub out: PathBuf,
    /// Workers; each makes one tree at a time on one thread, which is the best use of all cores.
    pub threads: usize,
    /// True to leave alone packs that are whole and made from the same script.
    pub resume: bool,
    /// What to do with packs that are there.
    pub replace: Replace,
    /// How packs are laid out.
    pub pack: Options,
    /// Settings that items start from.
    pub settings: Settings,
}

/// What became of an item.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Made: triangles of each LOD, and warnings.
    Made {
        /// Triangles by LOD.
        triangles: Vec<u64>,
        /// Warnings in words.
        warnings: Vec<String>,
    },
    /// There already, whole.
    Kept,
    /// Not made.
    Failed {
        /// Why.
        reason: String,
        /// True if trying again may help.
        machine: bool,
    },
    /// Not begun, or given up, because the batch was cancelled.
    Cancelled,
}

/// Follows a run; called from the workers' threads.
pub trait Observer: Sync {
    /// Progress of the item that `worker` (from 0) begins now.
    fn item<'a>(&'a self, worker: usize, item: &Item) -> Box<dyn Progress + 'a>;
    /// `worker` is done with an item.
    fn done(&self, worker: usize, item: &Item, outcome: &Outcome);
    /// True if no further item should begin.
    fn cancelled(&self) -> bool;
}

/// Carries out all items; outcomes in the plan's order.
///
/// # Errors
/// If no worker thread can be started.
pub fn run(
    plan: &Plan,
    options: &RunOptions,
    observer: &dyn Observer,
) -> std::io::Result<Vec<Outcome>> {
    let names: BTreeSet<&str> = plan.items.iter().map(|i| i.folder.as_str()).collect();
    pack::sweep(&options.out, |name| names.contains(name));
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(vec![Outcome::Cancelled; plan.items.len()]);
    let work = |worker: usize| {
        while !observer.cancelled() {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = plan.items.get(at) else {
                break;
            };
            let outcome = one(item, options, observer, worker);
            observer.done(worker, item, &outcome);
            if let Ok(mut outcomes) = outcomes.lock() {
                outcomes[at] = outcome;
            }
        }
    };
    std::thread::scope(|scope| {
        for worker in 0..options.threads.clamp(1, plan.items.len().max(1)) {
            // A pool of one thread keeps a tree's inner parallelism from spreading over the others.
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .thread_name(|_| "pleach-tree".to_owned())
                .build()
                .map_err(std::io::Error::other)?;
            std::thread::Builder::new()
                .name(format!("pleach-worker-{worker}"))
                .spawn_scoped(scope, move || pool.install(|| work(worker)))?;
        }
        Ok::<(), std::io::Error>(())
    })?;
    Ok(outcomes.into_inner().unwrap_or_default())
}

fn one(item: &Item, options: &RunOptions, observer: &dyn Observer, worker: usize) -> Outcome {
    let progress = observer.item(worker, item);
    if options.resume && is_whole(item, options) {
        return Outcome::Kept;
    }
    match make(item, options, &*progress) {
        Ok(asset) => Outcome::Made {
            triangles: asset.lods.iter().map(|l| l.triangles.total()).collect(),
            warnings: asset.warnings.iter().map(ToString::to_string).collect(),
        },
        Err(failure) => failure,
    }
}

fn make(item: &Item, options: &RunOptions, progress: &dyn Progress) -> Result<TreeAsset, Outcome> {
    let failed = |reason: String| Outcome::Failed {
        reason,
        machine: false,
    };
    let species = item
        .species
        .as_ref()
        .map_err(|faults| failed(faults.clone()))?;
    let settings = settings(item, options);
    let files = Beside(item.path.parent().unwrap_or(Path::new("")).to_owned());
    let asset = pipeline::generate(species, &settings, &files, progress).map_err(|error| {
        if progress.cancelled() || matches!(error, GenerateError::Cancelled(_)) {
            return Outcome::Cancelled;
        }
        failed(error.to_string())
    })?;
    let packed = pack::build(&asset, item.script.as_bytes(), options.pack)
        .map_err(|error| failed(error.to_string()))?;
    if progress.cancelled() {
        return Err(Outcome::Cancelled);
    }
    pack::write(&options.out, &item.folder, &packed, options.replace).map_err(
        |error: WriteError| Outcome::Failed {
            machine: error.is_machine_fault(),
            reason: error.to_string(),
        },
    )?;
    Ok(asset)
}

/// The run's settings with the item's own.
fn settings(item: &Item, options: &RunOptions) -> Settings {
    let mut settings = options.settings.clone();
    settings.seed = Some(item.seed);
    settings.budgets = item.budgets.clone().or(settings.budgets);
    if let Some(size) = item.texture_size {
        settings.captures.atlas_size = size;
    }
    settings
}

/// True if the item's pack is there, is what this plan would make, and all its files are what the
/// manifest says.
fn is_whole(item: &Item, options: &RunOptions) -> bool {
    let folder = options.out.join(&item.folder);
    let Ok(manifest) = pack::read_manifest(&folder) else {
        return false;
    };
    let generator = concat!("pleach ", env!("CARGO_PKG_VERSION"));
    let same_script = std::fs::read(folder.join("species.ron"))
        .is_ok_and(|script| script == item.script.as_bytes());
    let atlas = settings(item, options).captures.atlas_size;
    same_script
        && manifest.generator == generator
        && manifest.baker.is_none()
        && manifest.seed == item.seed
        && manifest.textures.foliage.size[0] == atlas
        && manifest.textures.foliage.mips.is_empty() != options.pack.mips
        && manifest.wind.is_none() == options.pack.no_wind
        && manifest.lods.iter().all(|lod| {
            std::fs::read(folder.join(&lod.file))
                .is_ok_and(|glb| embeds_images(&glb) == options.pack.embed)
        })
        && same_sources(item, &folder)
        && same_lods(item, options, &manifest)
        && pack::verify(&folder, &manifest).is_ok()
}

/// True if the files that the script names are now as the pack has them.
fn same_sources(item: &Item, folder: &Path) -> bool {
    let Ok(species) = &item.species else {
        return false;
    };
    let beside = item.path.parent().unwrap_or(Path::new(""));
    species.files.iter().all(|file| {
        let now = std::fs::read(beside.join(file));
        now.is_ok_and(|now| std::fs::read(folder.join(file)).is_ok_and(|then| then == now))
    })
}

/// True if a pack's LODs were asked for as they are now.
fn same_lods(item: &Item, options: &RunOptions, manifest: &Manifest) -> bool {
    let Ok(species) = &item.species else {
        return false;
    };
    let asked = settings(item, options).asked(species);
    manifest.asked.as_ref() == Some(&AskedEntry::from(&asked))
}

/// True if the JSON chunk of a GLB of ours keeps its images inside.
fn embeds_images(glb: &[u8]) -> bool {
    let key = br#""mimeType":"image/png""#;
    let length = glb
        .get(12..16)
        .and_then(|b| b.try_into().ok())
        .map_or(0, u32::from_le_bytes);
    let json = glb.get(20..).unwrap_or(&[]);
    let json = &json[..json.len().min(length as usize)];
    json.windows(key.len()).any(|part| part == key)
}
