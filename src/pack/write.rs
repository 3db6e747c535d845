//! Packs on disk: there whole or not at all.
//!
//! A pack is written to a temporary folder beside its place and renamed. Whatever happens in between (a
//! full disk, a kill), the place holds the old pack, the new one, or nothing; never a part of one.

use super::{FORMAT, Manifest, PackFile, VERSION};
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What to do with something that already stands in the pack's place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Replace {
    /// Replace a pack of this version; refuse anything else.
    #[default]
    OwnPacks,
    /// Replace a pack of any version; refuse anything that is no pack.
    AnyPack,
}

/// Why a pack could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The machine failed: disk full, no permission, and so on.
    #[error("cannot write {path}: {source}{}", hint(.source))]
    Io {
        /// File or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Something that is no pack stands in the way.
    #[error(
        "{path} is in the way and is no pack (it has no pack.json); move it away or choose another --out"
    )]
    NotAPack {
        /// Folder or file.
        path: PathBuf,
    },
    /// The folder of the packs is, or lies below, something that is no folder.
    #[error("{path} is no folder, so no pack can be made in it; choose another --out")]
    NotAFolder {
        /// What is no folder.
        path: PathBuf,
    },
    /// A pack of another version stands in the way.
    #[error(
        "{path} holds a pack of version {found}, and this program writes version {VERSION}; \
         move it away, choose another --out, or replace it with --force"
    )]
    OtherVersion {
        /// Folder.
        path: PathBuf,
        /// Version found there.
        found: String,
    },
}

impl WriteError {
    /// True if trying again later or elsewhere may help.
    #[must_use]
    pub fn is_machine_fault(&self) -> bool {
        matches!(self, Self::Io { .. })
    }
}

fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "; choose a folder that you may write to with --out"
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; free some space or choose another disk with --out"
        }
        _ => "",
    }
}

/// Writes a pack's files as the folder `out/name`; returns its path. Nothing half-written is left.
///
/// # Errors
/// See [`WriteError`]. After an error the place holds what it held before.
pub fn write(
    out: &Path,
    name: &str,
    files: &[PackFile],
    replace: Replace,
) -> Result<PathBuf, WriteError> {
    check_place(out, name, replace)?;
    fs::create_dir_all(out).map_err(io_at(out))?;
    let (temporary, _lock) = temporary(out, name, ".tmp")?;
    // Temporary folders are private to the user; a folder in it is as readable as any new one.
    let pack = temporary.path().join(INSIDE);
    fs::create_dir(&pack).map_err(io_at(&pack))?;
    for file in files {
        let path = pack.join(&file.path);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(io_at(folder))?;
        }
        write_file(&path, &file.bytes).map_err(io_at(&path))?;
    }
    put(&pack, out, name)?;
    Ok(out.join(name))
}

/// Moves a finished folder to its place, and what stood there out of the way.
fn put(finished: &Path, out: &Path, name: &str) -> Result<(), WriteError> {
    let target = out.join(name);
    if !target.exists() {
        return fs::rename(finished, &target).map_err(io_at(&target));
    }
    // The old pack moves into a temporary folder of its own, which is then removed.
    let (old, _lock) = temporary(out, name, OLD)?;
    let aside = old.path().join(INSIDE);
    fs::rename(&target, &aside).map_err(io_at(&target))?;
    let moved = fs::rename(finished, &target);
    // Put back what was there; if even that fails, keep it for a later sweep to put back.
    if moved.is_err() && fs::rename(&aside, &target).is_err() && !target.exists() {
        let _ = old.keep();
    }
    moved.map_err(io_at(&target))
}

fn io_at(path: &Path) -> impl FnOnce(io::Error) -> WriteError {
    let path = path.to_owned();
    move |source| WriteError::Io { path, source }
}

/// End of the name of a temporary folder that holds a replaced pack.
const OLD: &str = ".old.tmp";

/// The pack in a temporary folder.
const INSIDE: &str = "pack";

/// A hidden folder beside the pack's place, locked for as long as the second value lives, where the
/// system can lock folders.
fn temporary(
    out: &Path,
    name: &str,
    suffix: &str,
) -> Result<(tempfile::TempDir, Option<fs::File>), WriteError> {
    let folder = tempfile::Builder::new()
        .prefix(&format!(".{name}."))
        .suffix(suffix)
        .tempdir_in(out)
        .map_err(io_at(out))?;
    let lock = fs::File::open(folder.path())
        .ok()
        .filter(|f| f.try_lock().is_ok());
    Ok((folder, lock))
}

/// How long a temporary folder must have rested before it may count as left behind. The lock alone
/// would do on one machine; machines that share a disk need not see each other's locks.
const RESTED: Duration = Duration::from_secs(600);

/// Removes what killed runs left behind in `out` of the packs for which `ours` is true of their names.
/// A replaced pack that a kill caught on its way out goes back to its place. Nothing that a living run
/// holds is touched; what cannot be removed stays.
pub fn sweep(out: &Path, ours: impl Fn(&str) -> bool) {
    let Ok(entries) = fs::read_dir(out) else {
        return;
    };
    for entry in entries.flatten() {
        let file = entry.file_name();
        let parts = file
            .to_str()
            .and_then(|f| f.strip_prefix('.')?.split_once('.'));
        let Some((name, rest)) = parts else {
            continue;
        };
        if !rest.ends_with(".tmp") || !ours(name) || !left_behind(&entry.path()) {
            continue;
        }
        let target = out.join(name);
        if rest.ends_with(OLD) && !target.exists() {
            let _ = fs::rename(entry.path().join(INSIDE), &target);
        }
        let _ = fs::remove_dir_all(entry.path());
    }
}

fn left_behind(folder: &Path) -> bool {
    let Ok(folder) = fs::File::open(folder) else {
        return false;
    };
    let rested = folder.metadata().is_ok_and(|m| {
        m.is_dir()
            && m.modified()
                .is_ok_and(|t| t.elapsed().is_ok_and(|e| e > RESTED))
    });
    rested && folder.try_lock().is_ok()
}

fn write_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::File::create_new(path)?;
    file.write_all(bytes)?;
    // Without this, a full disk may show itself only after the rename.
    file.sync_data()
}

/// Tells before any work whether the pack `name` may be written in the folder `out`.
///
/// # Errors
/// If something stands there that is no pack, or a pack that `replace` protects.
pub fn check_place(out: &Path, name: &str, replace: Replace) -> Result<(), WriteError> {
    if let Some(path) = out.ancestors().find(|p| p.exists())
        && !path.is_dir()
    {
        let path = path.to_owned();
        return Err(WriteError::NotAFolder { path });
    }
    let target = out.join(name);
    if !target.exists() {
        return Ok(());
    }
    let text = fs::read(target.join("pack.json")).unwrap_or_default();
    let json: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    if json["format"] != FORMAT {
        return Err(WriteError::NotAPack { path: target });
    }
    if replace == Replace::OwnPacks && json["version"] != VERSION {
        let found = json["version"].to_string();
        return Err(WriteError::OtherVersion {
            path: target,
            found,
        });
    }
    Ok(())
}

/// Reads the manifest of a pack.
///
/// # Errors
/// In words: no such folder, no manifest, not a pack, another version.
pub fn read_manifest(folder: &Path) -> Result<Manifest, String> {
    let path = folder.join("pack.json");
    let text = fs::read(&path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
    let json: serde_json::Value =
        serde_json::from_slice(&text).map_err(|e| format!("{} is broken: {e}", path.display()))?;
    if json["format"] != FORMAT {
        return Err(format!("{} is not the manifest of a pack", path.display()));
    }
    if json["version"] != VERSION {
        let found = &json["version"];
        return Err(format!(
            "{} has version {found}; this program reads {VERSION}",
            path.display()
        ));
    }
    serde_json::from_value(json).map_err(|e| format!("{} is broken: {e}", path.display()))
}

/// Checks that every file of a pack is there with the size and hash that its manifest says.
///
/// # Errors
/// The first file that is not, in words.
pub fn verify(folder: &Path, manifest: &Manifest) -> Result<(), String> {
    for entry in &manifest.files {
        let path = folder.join(&entry.path);
        let bytes = fs::read(&path).map_err(|e| format!("cannot read {}: {e}", path.display()))?;
        if bytes.len() as u64 != entry.bytes || super::manifest::sha256(&bytes) != entry.sha256 {
            return Err(format!("{} is not what the manifest says", path.display()));
        }
    }
    Ok(())
}
