//! Files that are there whole or not at all.

use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

/// Writes a file: beside its place, then renamed, so that a kill at any moment leaves the old one or the new one.
/// A link stays and its target is replaced; a file that was there keeps its permissions, and a new one is as
/// readable as any.
///
/// # Errors
/// What the disk says; what was there stays.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    if let Ok(before) = fs::metadata(&place) {
        file.as_file().set_permissions(before.permissions())?;
    }
    file.as_file().sync_all()?;
    file.persist(&place)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_what_it_was_reached_by_stays() {
        let dir = tempfile::tempdir().unwrap();
        let (place, link) = (dir.path().join("a.ron"), dir.path().join("link.ron"));
        write_whole(&place, b"one").unwrap();
        #[cfg(unix)]
        {
            use std::os::unix::fs::{PermissionsExt as _, symlink};
            fs::set_permissions(&place, fs::Permissions::from_mode(0o640)).unwrap();
            symlink(&place, &link).unwrap();
            write_whole(&link, b"two").unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(
                fs::metadata(&place).unwrap().permissions().mode() & 0o777,
                0o640
            );
            assert_eq!(fs::read(&place).unwrap(), b"two");
        }
        assert!(write_whole(&dir.path().join("no/such/folder.ron"), b"x").is_err());
        let files = fs::read_dir(dir.path()).unwrap().count();
        assert!(files <= 2, "nothing half-written is left");
    }
}
