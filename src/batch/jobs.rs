//! Job lists: species x seeds x parameter overrides x budgets, and the plan that they unfold to.

use crate::pack::folder_name;
use crate::species::{Beside, Faults, edit, parse, schema::Species};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Job list format that this version reads.
const FORMAT: u32 = 1;

/// Most trees of one plan.
const MOST_ITEMS: u64 = 1_000_000;

/// A job list as its RON file has it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JobList {
    /// Format version, 1.
    pub format: u32,
    /// Budgets for jobs that have none; without, each species' own.
    #[serde(default)]
    pub budgets: Option<Vec<u64>>,
    /// Atlas edge for jobs that have none, texels.
    #[serde(default)]
    pub texture_size: Option<u32>,
    /// The jobs.
    pub jobs: Vec<Job>,
}

/// Trees of one species with the same parameters.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// Species script, relative to the job list.
    pub species: String,
    /// Name of the variation; becomes part of the packs' names. Needed beside `set`.
    #[serde(default)]
    pub name: Option<String>,
    /// Seeds; without, the species' own.
    #[serde(default)]
    pub seeds: Option<Seeds>,
    /// Fields of the script to change: path such as `levels.trunk.length_m` to RON text.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
    /// Triangle budgets, falling.
    #[serde(default)]
    pub budgets: Option<Vec<u64>>,
    /// Atlas edge, texels.
    #[serde(default)]
    pub texture_size: Option<u32>,
}

/// The seeds of a job.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub enum Seeds {
    /// From the first to the last, both included.
    Range(u64, u64),
    /// These.
    List(Vec<u64>),
}

/// One tree to make.
#[derive(Clone, Debug)]
pub struct Item {
    /// Number in the plan, from 0.
    pub index: usize,
    /// Folder of the pack: slug, variation and seed.
    pub folder: String,
    /// Species script file.
    pub path: PathBuf,
    /// Text of the script with the job's changes.
    pub script: String,
    /// Seed.
    pub seed: u64,
    /// Budgets; the script's own if `None`.
    pub budgets: Option<Vec<u64>>,
    /// Atlas edge; the default if `None`.
    pub texture_size: Option<u32>,
    /// The species, or why there is none.
    pub species: Result<Box<Species>, String>,
}

/// All trees of a job list.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// In the order of the list.
    pub items: Vec<Item>,
}

/// A part of a plan: number `index` of `count`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// 1..=count.
    pub index: usize,
    /// At least 1.
    pub count: usize,
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fault = || format!("`{text}` is no shard; write I/N with 1 <= I <= N, such as 2/4");
        let (index, count) = text.split_once('/').ok_or_else(fault)?;
        let index = index.parse().map_err(|_| fault())?;
        let count = count.parse().map_err(|_| fault())?;
        if index == 0 || index > count {
            Err(fault())
        } else {
            Ok(Self { index, count })
        }
    }
}

/// Why a job list is of no use as a whole. (A single bad species fails its trees alone.)
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// File.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The text is no job list.
    #[error("{path}:{line}:{column}: {message}")]
    Syntax {
        /// File.
        path: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// A job is at fault.
    #[error("{path}: jobs[{job}]: {message}")]
    Job {
        /// File.
        path: String,
        /// Number of the job, from 0.
        job: usize,
        /// What is wrong.
        message: String,
    },
    /// Something else about the list.
    #[error("{path}: {message}")]
    List {
        /// File.
        path: String,
        /// What is wrong.
        message: String,
    },
}

impl Plan {
    /// Reads a job list and all scripts that it names.
    ///
    /// # Errors
    /// If the list itself is at fault. A script that is at fault fails its items when they run.
    pub fn read(path: &Path) -> Result<Self, PlanError> {
        let shown = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| PlanError::Read {
            path: path.to_owned(),
            source,
        })?;
        let options = ron::Options::default()
            .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let list: JobList = options.from_str(&text).map_err(|error| PlanError::Syntax {
            path: shown.clone(),
            line: error.span.start.line,
            column: error.span.start.col,
            message: error.code.to_string(),
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::of(&list, folder, &shown)
    }

    fn of(list: &JobList, folder: &Path, shown: &str) -> Result<Self, PlanError> {
        let fault = |message: String| PlanError::List {
            path: shown.to_owned(),
            message,
        };
        if list.format != FORMAT {
            return Err(fault(format!("format {} is not {FORMAT}", list.format)));
        }
        if list.jobs.is_empty() {
            return Err(fault("there are no jobs".to_owned()));
        }
        let mut plan = Self::default();
        let mut names = BTreeSet::new();
        for (number, job) in list.jobs.iter().enumerate() {
            let fault = |message: String| PlanError::Job {
                path: shown.to_owned(),
                job: number,
                message,
            };
            let ready = Prepared::of(list, job, folder).map_err(fault)?;
            for seed in ready.seeds(job, plan.items.len() as u64).map_err(fault)? {
                let item = ready.item(plan.items.len(), seed);
                if !names.insert(item.folder.clone()) {
                    let name = &item.folder;
                    return Err(fault(format!(
                        "makes `{name}`, which another job makes too; give one of them a `name`"
                    )));
                }
                plan.items.push(item);
            }
        }
        Ok(plan)
    }

    /// The items of one shard: every N-th, so that long and short ones are mixed.
    #[must_use]
    pub fn shard(mut self, shard: Shard) -> Self {
        self.items
            .retain(|item| item.index % shard.count == shard.index - 1);
        self
    }
}

/// A job with its script read and changed.
struct Prepared {
    path: PathBuf,
    script: String,
    slug: String,
    own_seed: u64,
    species: Result<Box<Species>, String>,
    budgets: Option<Vec<u64>>,
    texture_size: Option<u32>,
}

impl Prepared {
    fn of(list: &JobList, job: &Job, folder: &Path) -> Result<Self, String> {
        let path = folder.join(&job.species);
        let text = std::fs::read_to_string(&path)
            .map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        if !job.set.is_empty() && job.name.is_none() {
            return Err("has `set`, and needs a `name` to tell its packs from others".to_owned());
        }
        let beside = Beside(path.parent().unwrap_or(Path::new("")).to_owned());
        let name = path.display().to_string();
        let plain = parse(&name, &text, &beside);
        let stem = path
            .file_stem()
            .map_or_else(|| "tree".to_owned(), |s| s.to_string_lossy().into_owned());
        let mut slug = plain.as_ref().map_or(stem, |s| s.slug.clone());
        let mut script = text;
        for (field, value) in &job.set {
            script = match edit::set(&script, field, value) {
                Ok(script) => script,
                // Its faults are told when its trees fail; the other jobs go on.
                Err(edit::EditError::Unreadable) => break,
                Err(error) => return Err(error.to_string()),
            };
        }
        if let Some(variation) = &job.name {
            slug = variation_slug(&slug, variation)?;
            // So that the script in the pack names the pack that it makes.
            script = edit::set(&script, "slug", &format!("\"{slug}\"")).unwrap_or(script);
        }
        let budgets = job.budgets.clone().or_else(|| list.budgets.clone());
        check_budgets(budgets.as_deref().unwrap_or(&[]))?;
        let species = parse(&name, &script, &beside);
        Ok(Self {
            own_seed: species.as_ref().map_or(1, |s| s.seed),
            species: species
                .map(Box::new)
                .map_err(|faults: Faults| faults.to_string()),
            path,
            script,
            slug,
            budgets,
            texture_size: job.texture_size.or(list.texture_size),
        })
    }

    fn seeds(&self, job: &Job, so_far: u64) -> Result<Vec<u64>, String> {
        let seeds = match &job.seeds {
            None => vec![self.own_seed],
            Some(Seeds::List(seeds)) => seeds.clone(),
            Some(Seeds::Range(first, last)) => {
                let (first, last) = (*first, *last);
                if last < first {
                    return Err(format!(
                        "seeds Range({first}, {last}) ends before it begins"
                    ));
                }
                let count = last - first;
                if count.saturating_add(so_far) >= MOST_ITEMS {
                    return Err(format!("a plan has at most {MOST_ITEMS} trees"));
                }
                (first..=last).collect()
            }
        };
        if seeds.is_empty() {
            Err("has no seeds".to_owned())
        } else {
            Ok(seeds)
        }
    }

    fn item(&self, index: usize, seed: u64) -> Item {
        Item {
            index,
            folder: folder_name(&self.slug, seed),
            path: self.path.clone(),
            script: self.script.clone(),
            seed,
            budgets: self.budgets.clone(),
            texture_size: self.texture_size,
            species: self.species.clone(),
        }
    }
}

fn variation_slug(slug: &str, variation: &str) -> Result<String, String> {
    let fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if variation.is_empty() || !variation.chars().all(fine) {
        return Err(format!(
            "`name: \"{variation}\"` may hold lower-case letters, digits and `-` only, since it becomes \
             a part of file names"
        ));
    }
    Ok(format!("{slug}-{variation}"))
}

/// Budgets must fall and hold a tree's smallest form.
///
/// # Errors
/// What is wrong with them, and what they should be.
pub fn check_budgets(budgets: &[u64]) -> Result<(), String> {
    if let Some(small) = budgets
        .iter()
        .find(|&&b| b < crate::lod::CROSS_QUAD_TRIANGLES)
    {
        return Err(format!(
            "a budget of {small} triangles is too small: the smallest form of a tree, one cross-quad, has 4"
        ));
    }
    match budgets.windows(2).find(|pair| pair[1] >= pair[0]) {
        Some(pair) => Err(format!(
            "budgets must fall from LOD to LOD, but {} is followed by {}",
            pair[0], pair[1]
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_part_a_plan_without_rest() {
        let shard = |text: &str| text.parse::<Shard>();
        assert_eq!(shard("2/4"), Ok(Shard { index: 2, count: 4 }));
        for bad in ["", "1", "0/3", "4/3", "a/b", "1/0", "-1/2"] {
            assert!(shard(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn budgets_must_fall_and_hold_a_cross_quad() {
        assert!(check_budgets(&[100, 50, 4]).is_ok());
        assert!(check_budgets(&[100, 3]).unwrap_err().contains("has 4"));
        assert!(check_budgets(&[0]).is_err());
        assert!(check_budgets(&[50, 100]).unwrap_err().contains("must fall"));
    }
}
