//! The files that a script names, behind a trait, so that reading scripts does no I/O of its own.

use std::fs;
use std::io::Read as _;
use std::path::PathBuf;

/// Largest file that is read, bytes.
const MAX_BYTES: u64 = 128 << 20;

/// Where the files named in a script come from. Paths are relative, with `/`, and never hold `..`.
pub trait Files: Sync {
    /// The text of a file.
    ///
    /// # Errors
    /// Why it cannot be read, and where it was looked for, in words for the author of the script.
    fn read_text(&self, path: &str) -> Result<String, String>;

    /// The bytes of a file.
    ///
    /// # Errors
    /// Why it cannot be read, and where it was looked for.
    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String>;

    /// Whether a file is there.
    ///
    /// # Errors
    /// That it is not, and where it was looked for.
    fn exists(&self, path: &str) -> Result<(), String>;
}

/// Files in the folder of the script.
#[derive(Clone, Debug)]
pub struct Beside(
    /// The folder.
    pub PathBuf,
);

impl Beside {
    fn no_such(&self, path: &str) -> String {
        let dir = if self.0.as_os_str().is_empty() {
            ".".to_owned()
        } else {
            self.0.display().to_string()
        };
        format!("no such file `{path}`; looked in {dir}")
    }
}

impl Files for Beside {
    fn read_text(&self, path: &str) -> Result<String, String> {
        let bytes = self.read_bytes(path)?;
        String::from_utf8(bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            format!("`{path}` is not text: byte {at} is not UTF-8")
        })
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.exists(path)?;
        let cannot = |error: std::io::Error| format!("cannot read `{path}`: {error}");
        let file = fs::File::open(self.0.join(path)).map_err(cannot)?;
        let mut bytes = Vec::new();
        file.take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(cannot)?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(format!("`{path}` is larger than {MAX_BYTES} bytes"));
        }
        Ok(bytes)
    }

    fn exists(&self, path: &str) -> Result<(), String> {
        let full = self.0.join(path);
        if full.is_file() {
            Ok(())
        } else if full.is_dir() {
            Err(format!("`{path}` is a folder, not a file"))
        } else {
            Err(self.no_such(path))
        }
    }
}

/// A script that stands alone: no file is ever there.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read_text(&self, path: &str) -> Result<String, String> {
        Err(format!(
            "no such file `{path}`: this script has no folder to look in"
        ))
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read_text(path).map(String::into_bytes)
    }

    fn exists(&self, path: &str) -> Result<(), String> {
        self.read_text(path).map(drop)
    }
}

/// Why a path may not stand in a script: packs must not reach outside the script's folder, and must
/// mean the same on every system.
pub(super) fn refuse(path: &str) -> Option<&'static str> {
    if path.is_empty() {
        Some("a file name is empty")
    } else if path.starts_with('/') || path.contains(':') {
        Some("a file is named relative to the script's folder, not by an absolute path")
    } else if path.contains('\\') {
        Some("folders in a path are separated by `/`")
    } else if path.split('/').any(|part| part == "..") {
        Some("a file must stand in the script's folder or below it: `..` is not allowed")
    } else if path.chars().any(char::is_control) {
        Some("a file name holds a control character")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_beside_the_script_are_found_and_others_are_explained() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a.txt"), "1").unwrap();
        fs::write(dir.path().join("b.bin"), [b'x', 0xff]).unwrap();
        let files = Beside(dir.path().to_owned());
        assert_eq!(files.read_text("a.txt").as_deref(), Ok("1"));
        let missing = files.exists("c.txt").unwrap_err();
        assert!(missing.contains("c.txt") && missing.contains(dir.path().to_str().unwrap()));
        assert!(files.read_text("b.bin").unwrap_err().contains("byte 1"));
        assert!(files.exists(".").unwrap_err().contains("folder"));
    }

    #[test]
    fn paths_that_leave_the_folder_are_refused() {
        for path in ["", "/etc/passwd", "C:\\x", "a/../b", "..", "a\\b", "a\nb"] {
            assert!(refuse(path).is_some(), "{path:?}");
        }
        assert_eq!(refuse("textures/bark..png"), None);
    }
}
