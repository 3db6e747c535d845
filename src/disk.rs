//! Files that are there whole or not at all.

use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

/// Writes a file that is not there yet, beside its place and then named.
///
/// # Errors
/// `AlreadyExists` if something has that name, a link that leads nowhere included; or what the disk says.
pub fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = beside(path)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist_noclobber(path)?;
    Ok(())
}

/// A file without a name yet, as readable as any, in the folder of a path.
fn beside(path: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Writes a file: beside its place, then renamed, so that a kill at any moment leaves the old one or the new one.
/// A link stays and its target is replaced; a file that was there keeps its permissions, and a new one is as
/// readable as any.
///
/// # Errors
/// What the disk says; what was there stays.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let mut file = beside(&place)?;
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
    fn a_new_file_takes_no_name_that_is_taken() {
        let dir = tempfile::tempdir().unwrap();
        let place = dir.path().join("a.png");
        write_new(&place, b"one").unwrap();
        let kind = |path: &Path| write_new(path, b"two").unwrap_err().kind();
        assert_eq!(kind(&place), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read(&place).unwrap(), b"one");
        #[cfg(unix)]
        {
            let link = dir.path().join("link.png");
            std::os::unix::fs::symlink(dir.path().join("nowhere"), &link).unwrap();
            assert_eq!(kind(&link), io::ErrorKind::AlreadyExists);
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        }
        assert!(
            fs::read_dir(dir.path()).unwrap().count() <= 2,
            "nothing else is left"
        );
    }

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
