//! What stands in a folder, and what a typed path means.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What a path is wanted for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wants {
    /// A script that is there.
    Script,
    /// A script to write.
    NewScript,
    /// A folder, which may have to be made.
    Folder,
}

/// A folder as it was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Listing {
    pub(super) entries: Result<Vec<Entry>, String>,
    /// False for one that may have to be made.
    pub(super) is_there: bool,
}

impl Listing {
    /// What a folder holds for what is wanted.
    pub(super) fn of(folder: &Path, wants: Wants) -> Self {
        Self {
            entries: list(folder, wants != Wants::Folder).map_err(|e| e.to_string()),
            is_there: folder.exists(),
        }
    }
}

/// What is to become of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// It is a folder to look into.
    Enter(PathBuf),
    Take(PathBuf),
    Fault(String),
}

/// Looks at a path that is to be taken; `enters` says whether folders are gone into.
pub(super) fn found(wants: Wants, typed: &str, path: PathBuf, enters: bool) -> Found {
    if enters && path.is_dir() {
        return Found::Enter(path);
    }
    match checked(wants, typed, path) {
        Ok(path) => Found::Take(path),
        Err(fault) => Found::Fault(fault),
    }
}

/// Something in a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) is_folder: bool,
}

/// A path that may be taken, or why not.
fn checked(wants: Wants, typed: &str, mut path: PathBuf) -> Result<PathBuf, String> {
    match wants {
        Wants::Script if !path.is_file() => Err(format!("There is no file {}.", path.display())),
        Wants::NewScript => {
            if typed.trim().ends_with(std::path::is_separator) {
                return Err("The file needs a name.".to_owned());
            }
            if path.extension().is_none() {
                path.set_extension("ron");
            }
            match path.parent() {
                Some(folder) if !folder.is_dir() => {
                    Err(format!("There is no folder {}.", folder.display()))
                }
                _ => Ok(path),
            }
        }
        Wants::Folder => match path.ancestors().find(|p| p.exists()) {
            Some(there) if !there.is_dir() => Err(format!("{} is no folder.", there.display())),
            _ => Ok(path),
        },
        Wants::Script => Ok(path),
    }
}

/// A path from the root on, without a separator at its end; `~` is the user's own folder.
pub(super) fn absolute(path: &Path) -> PathBuf {
    let home = std::env::home_dir().zip(path.strip_prefix("~").ok());
    let path = home.map_or_else(|| path.to_owned(), |(home, rest)| home.join(rest));
    let whole = std::path::absolute(&path).unwrap_or(path);
    whole.components().collect()
}

/// The folder that a path leads into, and what follows it.
pub(super) fn parted(text: &str) -> (PathBuf, String) {
    let whole = |folder: &str| {
        let folder = if folder.is_empty() { "." } else { folder };
        absolute(Path::new(folder))
    };
    match text.rfind(std::path::is_separator) {
        // The separator is one byte on all systems, and stays with the folder: it may be the root.
        Some(at) => (whole(&text[..=at]), text[at + 1..].to_owned()),
        None => (whole(""), text.to_owned()),
    }
}

/// What a folder holds: sub-folders, then scripts if they are asked for, each by name.
///
/// # Errors
/// If the folder cannot be read.
fn list(folder: &Path, scripts: bool) -> io::Result<Vec<Entry>> {
    let mut entries: Vec<Entry> = fs::read_dir(folder)?
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let kind = entry.file_type().ok()?;
            let is_folder = kind.is_dir() || (kind.is_symlink() && entry.path().is_dir());
            let ending = Path::new(&name).extension().unwrap_or_default();
            let wanted = is_folder || (scripts && ending.eq_ignore_ascii_case("ron"));
            wanted.then_some(Entry { name, is_folder })
        })
        .collect();
    entries.sort_by_cached_key(|e| (!e.is_folder, e.name.to_lowercase(), e.name.clone()));
    Ok(entries)
}

/// The entries whose names hold what was typed, in any case. Hidden ones are shown once their dot is typed.
pub(super) fn matching<'e>(
    entries: &'e [Entry],
    filter: &str,
) -> impl Iterator<Item = &'e Entry> + use<'e> {
    let filter = filter.to_lowercase();
    entries.iter().filter(move |entry| {
        let is_hidden = entry.name.starts_with('.') && !filter.starts_with('.');
        !is_hidden && entry.name.to_lowercase().contains(&filter)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_parted_at_its_last_separator() {
        let parts = |text: &str| parted(text);
        assert_eq!(
            parts("/trees/oak.ron"),
            (PathBuf::from("/trees"), "oak.ron".to_owned())
        );
        assert_eq!(parts("/trees/"), (PathBuf::from("/trees"), String::new()));
        assert_eq!(parts("/oak"), (PathBuf::from("/"), "oak".to_owned()));
        let here = std::env::current_dir().unwrap();
        if let Some(home) = std::env::home_dir() {
            assert_eq!(parts("~/trees/o"), (home.join("trees"), "o".to_owned()));
        }
        assert_eq!(parts("oak.ron"), (here.clone(), "oak.ron".to_owned()));
        assert_eq!(parts("trees/oak"), (here.join("trees"), "oak".to_owned()));
    }
}
