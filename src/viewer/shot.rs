//! Screenshots: the next free name, and a file that is there whole or not at all.

use crate::image::{Image, png};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Highest number of a screenshot.
const MOST: u32 = 9999;

/// Writes a picture as `NAME-001.png` in a folder, with the next number that is free.
///
/// # Errors
/// Why it could not be written, in words.
pub fn save(folder: &Path, name: &str, picture: &Image<[u8; 4]>) -> Result<PathBuf, String> {
    let bytes = png::encode(picture).map_err(|e| e.to_string())?;
    let told = |e: std::io::Error| format!("cannot write into {}: {e}", folder.display());
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(told)?;
    file.write_all(&bytes).map_err(told)?;
    for number in 1..=MOST {
        let path = folder.join(format!("{name}-{number:03}.png"));
        if path.exists() {
            continue;
        }
        match file.persist_noclobber(&path) {
            Ok(_) => return Ok(path),
            // Another program took the name just now.
            Err(e) if e.error.kind() == std::io::ErrorKind::AlreadyExists => file = e.file,
            Err(e) => return Err(told(e.error)),
        }
    }
    Err(format!(
        "{} holds {name}-001.png to {name}-{MOST}.png already",
        folder.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn numbers_go_on_and_nothing_is_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let picture = Image::filled(3, 2, [10, 20, 30, 255]);
        fs::write(dir.path().join("olive-002.png"), "mine").unwrap();
        let names: Vec<String> = (0..3)
            .map(|_| save(dir.path(), "olive", &picture).unwrap())
            .map(|path| path.file_name().unwrap().to_string_lossy().into_owned())
            .collect();
        assert_eq!(names, ["olive-001.png", "olive-003.png", "olive-004.png"]);
        let read = fs::read(dir.path().join("olive-003.png")).unwrap();
        assert_eq!(png::decode(&read, 1 << 20).unwrap(), picture);
        assert_eq!(
            fs::read_to_string(dir.path().join("olive-002.png")).unwrap(),
            "mine"
        );
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 4);
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let picture = Image::filled(3, 2, [0; 4]);
        let fault = save(Path::new("no/such"), "olive", &picture).unwrap_err();
        assert!(fault.contains("no/such"), "{fault}");
    }
}
