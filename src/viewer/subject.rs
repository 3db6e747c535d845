//! What is shown: a tree grown from a script, or a pack read from a disk.

use super::watch::Watched;
use crate::asset::{Drawable, TreeAsset};
use crate::math::Bounds;
use crate::pack::{self, PackContents};
use crate::pipeline::{self, GenerateError, Settings};
use crate::report::Progress;
use crate::species::{self, Beside, Files};
use std::path::{Path, PathBuf};

/// Where a tree comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A species script, and what to make of it.
    Script {
        /// The script.
        path: PathBuf,
        /// What to make of it.
        settings: Box<Settings>,
    },
    /// A pack's folder.
    Pack(PathBuf),
}

impl Source {
    /// The script or the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::Script { path, .. } | Self::Pack(path) => path,
        }
    }

    /// Makes or reads the tree. All files that it is made of are noted in `watched`, also those that are at
    /// fault or missing.
    ///
    /// # Errors
    /// What is at fault, as `pleach check` words it.
    pub fn load(&self, watched: &Watched, progress: &dyn Progress) -> Result<Subject, String> {
        watched.clear();
        match self {
            Self::Script { path, settings } => grow(path, settings, watched, progress),
            Self::Pack(path) => read(path, watched, progress),
        }
    }
}

/// A LOD in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LodFacts {
    /// Budget that it meets; `None` for full detail.
    pub budget: Option<u64>,
    /// Triangles.
    pub triangles: u64,
    /// Edge of the blocks over which its coverage is right to a tenth, metres.
    pub error_m: f32,
    /// Part of the picture's height up to which it may be shown.
    pub screen_size: f32,
}

/// A tree that can be drawn.
#[derive(Debug)]
pub struct Subject {
    tree: Tree,
    /// Common name.
    pub name: String,
    /// File-name form of the name.
    pub slug: String,
    /// Seed.
    pub seed: u64,
    /// LODs from the finest to the coarsest, at least one.
    pub lods: Vec<LodFacts>,
    /// Triangles of what stands in for the finest LOD while something moves, falling; a sketch has some.
    pub stand_ins: Vec<u64>,
    /// Bounds of all LODs, metres.
    pub bounds: Bounds,
    /// What the user should know.
    pub warnings: Vec<String>,
}

#[derive(Debug)]
enum Tree {
    Asset(Box<TreeAsset>),
    Pack(Box<PackContents>),
}

impl Subject {
    /// What it is drawn from.
    #[must_use]
    pub fn drawable(&self) -> Drawable<'_> {
        match &self.tree {
            Tree::Asset(asset) => asset.drawable(),
            Tree::Pack(pack) => pack.drawable(),
        }
    }

    /// The tree itself, where it was grown here.
    #[must_use]
    pub fn asset(&self) -> Option<&TreeAsset> {
        match &self.tree {
            Tree::Asset(asset) => Some(asset),
            Tree::Pack(_) => None,
        }
    }

    /// Grows the tree of a script's text. Files that it names are looked for in `folder` and noted in `watched`.
    ///
    /// # Errors
    /// What is at fault, as `pleach check` words it; `name` is the script's.
    pub fn grown(
        (name, text): (&str, &str),
        folder: &Path,
        settings: &Settings,
        watched: &Watched,
        progress: &dyn Progress,
    ) -> Result<Self, String> {
        let files = Noted {
            files: Beside(folder.to_owned()),
            watched,
        };
        let species = species::parse(name, text, &files)
            .map_err(|faults| faults.render(false).trim_end().to_owned())?;
        let told = |error: GenerateError| format!("{name}: {error}");
        let asset = pipeline::generate(&species, settings, &files, progress).map_err(told)?;
        Ok(asset.into())
    }
}

impl From<TreeAsset> for Subject {
    fn from(asset: TreeAsset) -> Self {
        let facts = asset.lods.iter().map(|lod| LodFacts {
            budget: lod.budget,
            triangles: lod.triangles.total(),
            error_m: lod.error_m,
            screen_size: lod.screen_size,
        });
        Self {
            name: asset.name.clone(),
            slug: asset.slug.clone(),
            seed: asset.seed,
            lods: facts.collect(),
            stand_ins: Vec::new(),
            bounds: asset.bounds,
            warnings: asset.warnings.iter().map(ToString::to_string).collect(),
            tree: Tree::Asset(Box::new(asset)),
        }
    }
}

impl From<PackContents> for Subject {
    fn from(pack: PackContents) -> Self {
        let manifest = &pack.manifest;
        let facts = manifest.lods.iter().map(|lod| LodFacts {
            budget: lod.budget,
            triangles: lod.triangles,
            error_m: lod.error_m,
            screen_size: lod.screen_size,
        });
        Self {
            name: manifest.species.name.clone(),
            slug: manifest.species.slug.clone(),
            seed: manifest.seed,
            lods: facts.collect(),
            stand_ins: Vec::new(),
            bounds: Bounds {
                min: manifest.bounds.min.into(),
                max: manifest.bounds.max.into(),
            },
            warnings: manifest.warnings.clone(),
            tree: Tree::Pack(Box::new(pack)),
        }
    }
}

fn grow(
    path: &Path,
    settings: &Settings,
    watched: &Watched,
    progress: &dyn Progress,
) -> Result<Subject, String> {
    progress.begin("reading", 0);
    watched.note(path);
    let shown = path.display();
    let bytes = std::fs::read(path).map_err(|e| format!("cannot read {shown}: {e}"))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        format!("{shown} is not text: byte {at} is not UTF-8")
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    Subject::grown(
        (&shown.to_string(), &text),
        folder,
        settings,
        watched,
        progress,
    )
}

fn read(path: &Path, watched: &Watched, progress: &dyn Progress) -> Result<Subject, String> {
    progress.begin("reading", 0);
    watched.note(&path.join("pack.json"));
    let contents = pack::read(path).map_err(|e| e.to_string())?;
    Ok(contents.into())
}

/// Files beside a script; each one asked for is noted before it is read.
struct Noted<'a> {
    files: Beside,
    watched: &'a Watched,
}

impl Noted<'_> {
    fn note(&self, path: &str) {
        self.watched.note(&self.files.0.join(path));
    }
}

impl Files for Noted<'_> {
    fn read_text(&self, path: &str) -> Result<String, String> {
        self.note(path);
        self.files.read_text(path)
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.note(path);
        self.files.read_bytes(path)
    }

    fn exists(&self, path: &str) -> Result<(), String> {
        self.note(path);
        self.files.exists(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Quiet;
    use std::fs;

    fn script(folder: &Path, text: &str) -> Source {
        let path = folder.join("tree.ron");
        fs::write(&path, text).unwrap();
        Source::Script {
            path,
            settings: Box::default(),
        }
    }

    #[test]
    fn faults_are_told_as_check_tells_them_and_missing_files_are_watched() {
        let dir = tempfile::tempdir().unwrap();
        let palm = concat!(env!("CARGO_MANIFEST_DIR"), "/species/palm.ron");
        let text = fs::read_to_string(palm).unwrap();
        let watched = Watched::default();
        let fault = script(dir.path(), &text)
            .load(&watched, &Quiet)
            .unwrap_err();
        assert!(
            fault.contains("no such file") && fault.contains("-->"),
            "{fault}"
        );
        // The spline that the script names stands where it should come.
        assert_eq!(watched.paths().len(), 2, "{:?}", watched.paths());
        let missing = &watched.paths()[0];
        fs::create_dir_all(missing.parent().unwrap()).unwrap();
        fs::write(missing, "0 0 0\n").unwrap();
        assert!(watched.changed());
    }

    #[test]
    fn what_cannot_be_read_is_said_and_watched() {
        let watched = Watched::default();
        let source = Source::Script {
            path: PathBuf::from("no/such.ron"),
            settings: Box::default(),
        };
        let fault = source.load(&watched, &Quiet).unwrap_err();
        assert!(fault.contains("cannot read no/such.ron"), "{fault}");
        assert_eq!(watched.paths(), [PathBuf::from("no/such.ron")]);
        let pack = Source::Pack(PathBuf::from("no/pack"));
        assert!(pack.load(&watched, &Quiet).is_err());
        assert_eq!(watched.paths(), [PathBuf::from("no/pack/pack.json")]);
    }
}
