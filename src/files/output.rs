//! Writing beside the output and renaming, so that a failure leaves what was there.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::format::{self, Format};
use super::{FileError, Problem};

/// Where a picture is written to.
pub(crate) type Out<'a> = BufWriter<&'a File>;

/// Checks, before any work is done, that `path` can be an output; returns its format.
///
/// # Errors
/// If its extension says no format, its folder is not there or takes no file, it is not a plain
/// file, or it exists and `force` is not given.
pub fn check(path: &Path, force: bool) -> Result<Format, FileError> {
    let format = format::of_extension(path).map_err(|p| p.at(path))?;
    if !folder(path).is_dir() {
        return Err(Problem::Format("cannot be written: its folder is not there".into()).at(path));
    }
    if path.exists() && !path.is_file() {
        return Err(Problem::Format("cannot be written: it is not a plain file".into()).at(path));
    }
    if !force && fs::symlink_metadata(path).is_ok() {
        return Err(Problem::Exists.at(path));
    }
    // The file that is made here goes away again at once.
    create_beside(&resolved(path)).map_err(|p| p.at(path))?;
    Ok(format)
}

/// Lets `write` fill a temporary file in the folder of `path`, then renames it to `path`.
pub(crate) fn replace<T>(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut Out<'_>) -> Result<T, Problem>,
) -> Result<T, FileError> {
    replace_resolved(&resolved(path), force, write).map_err(|problem| problem.at(path))
}

fn replace_resolved<T>(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut Out<'_>) -> Result<T, Problem>,
) -> Result<T, Problem> {
    let temporary = create_beside(path)?;
    let mut out = BufWriter::with_capacity(1 << 20, temporary.as_file());
    let result = write(&mut out)?;
    out.flush().map_err(Problem::Write)?;
    drop(out);
    finish(temporary.as_file(), path).map_err(Problem::Write)?;
    let kept = if force { temporary.persist(path) } else { temporary.persist_noclobber(path) };
    kept.map_err(|e| match e.error.kind() {
        std::io::ErrorKind::AlreadyExists => Problem::Exists,
        _ => Problem::Write(e.error),
    })?;
    Ok(result)
}

/// Gives a file the permissions of what it is about to replace, and has it reach the disk before
/// the new name does.
fn finish(file: &File, path: &Path) -> std::io::Result<()> {
    if let Ok(existing) = fs::metadata(path) {
        file.set_permissions(existing.permissions())?;
    }
    file.sync_all()
}

/// A temporary file with the permissions that a new output would get.
fn create_beside(path: &Path) -> Result<tempfile::NamedTempFile, Problem> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".wgdenoise-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    // The error's text ends with the path of a file that nobody knows.
    builder.tempfile_in(folder(path)).map_err(|error| {
        let text = error.to_string();
        let known = text.split(" at path ").next().unwrap_or_default();
        Problem::Write(std::io::Error::new(error.kind(), known))
    })
}

/// What a link points to, so that the link stays one.
fn resolved(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

pub(super) fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.exr");
        fs::write(&path, "old").unwrap();
        let failed = replace(&path, true, |out| {
            out.write_all(b"new").map_err(Problem::Write)?;
            Err::<(), _>(Problem::Damaged("stops here".into()))
        });
        assert_eq!(failed.unwrap_err().to_string(), format!("{}: stops here", path.display()));
        assert_eq!((fs::read(&path).unwrap(), entries(folder.path())), (b"old".to_vec(), 1));
    }

    #[test]
    fn an_existing_file_is_replaced_only_with_force() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        fs::write(&path, "old").unwrap();
        let write = |out: &mut Out<'_>| out.write_all(b"new").map_err(Problem::Write);
        assert!(matches!(check(&path, false).unwrap_err().problem, Problem::Exists));
        assert!(matches!(replace(&path, false, write).unwrap_err().problem, Problem::Exists));
        replace(&path, true, write).unwrap();
        assert_eq!((fs::read(&path).unwrap(), entries(folder.path())), (b"new".to_vec(), 1));
    }

    /// Even root cannot make a file in this folder.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_folder_that_takes_no_file_is_found_before_the_work() {
        let error = check(Path::new("/proc/x.exr"), false).unwrap_err();
        assert!(matches!(error.problem, Problem::Write(_)), "{error}");
        let text = error.to_string();
        assert!(text.starts_with("/proc/x.exr: cannot be written: ") && !text.contains(".part"));
        assert!(text.contains("(os error"), "{text}");
    }

    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_permissions_even_if_it_is_read_only() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.exr");
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o440)).unwrap();
        assert_eq!((check(&path, true).unwrap(), entries(folder.path())), (Format::Exr, 1));
        replace(&path, true, |out| out.write_all(b"new").map_err(Problem::Write)).unwrap();
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!((fs::read(&path).unwrap(), mode & 0o777), (b"new".to_vec(), 0o440));
    }

    #[test]
    fn an_output_must_have_a_known_extension_and_a_folder_and_be_a_plain_file() {
        let text = |path: &str| check(Path::new(path), true).unwrap_err().to_string();
        assert!(text("picture.tiff").contains(".exr, .png, .jpg or .jpeg"));
        assert!(text("no/such/folder/x.exr").contains("its folder is not there"));
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("folder.exr");
        fs::create_dir(&inner).unwrap();
        assert!(text(inner.to_str().unwrap()).contains("not a plain file"));
    }
}
