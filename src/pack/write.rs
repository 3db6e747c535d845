//! Packs on disk: there whole or not at all.
//!
//! A pack is written to a temporary folder beside its place and renamed. Whatever happens in between (a
//! full disk, a kill), the place holds the old pack, the new one, or nothing; never a part of one.

use super::{FORMAT, Manifest, PackFile, VERSION};
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

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
        io::ErrorKind::StorageFull => "; free some space or choose another disk with --out",
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
    let target = out.join(name);
    let io_at = |path: &Path| {
        let path = path.to_owned();
        move |source| WriteError::Io { path, source }
    };
    may_replace(&target, replace)?;
    fs::create_dir_all(out).map_err(io_at(out))?;
    let temporary = tempfile::Builder::new()
        .prefix(&format!(".{name}."))
        .suffix(".tmp")
        .tempdir_in(out)
        .map_err(io_at(out))?;
    for file in files {
        let path = temporary.path().join(&file.path);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(io_at(folder))?;
        }
        write_file(&path, &file.bytes).map_err(io_at(&path))?;
    }
    readable_by_all(temporary.path()).map_err(io_at(temporary.path()))?;
    if target.exists() {
        // The old pack moves into a temporary folder of its own, which is then removed.
        let old = tempfile::Builder::new()
            .prefix(&format!(".{name}."))
            .suffix(".old.tmp")
            .tempdir_in(out)
            .map_err(io_at(out))?;
        let aside = old.path().join("pack");
        fs::rename(&target, &aside).map_err(io_at(&target))?;
        if let Err(source) = fs::rename(temporary.path(), &target) {
            // Put back what was there; if even that fails, the first error says why.
            let _ = fs::rename(&aside, &target);
            return Err(WriteError::Io {
                path: target,
                source,
            });
        }
    } else {
        fs::rename(temporary.path(), &target).map_err(io_at(&target))?;
    }
    // The folder has moved: there is nothing left to remove under its old name.
    let _ = temporary.keep();
    Ok(target)
}

fn write_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::File::create_new(path)?;
    file.write_all(bytes)?;
    // Without this, a full disk may show itself only after the rename.
    file.sync_data()
}

/// Temporary folders are private to the user; a pack is as readable as any new folder.
#[cfg(unix)]
fn readable_by_all(folder: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(folder, fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn readable_by_all(_folder: &Path) -> io::Result<()> {
    Ok(())
}

fn may_replace(target: &Path, replace: Replace) -> Result<(), WriteError> {
    if !target.exists() {
        return Ok(());
    }
    let text = fs::read(target.join("pack.json")).unwrap_or_default();
    let json: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    if json["format"] != FORMAT {
        return Err(WriteError::NotAPack {
            path: target.to_owned(),
        });
    }
    if replace == Replace::OwnPacks && json["version"] != VERSION {
        let found = json["version"].to_string();
        return Err(WriteError::OtherVersion {
            path: target.to_owned(),
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
