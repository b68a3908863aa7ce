//! Writing beside the output and renaming, so that a failure leaves what was there.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::format::{self, Format};
use super::{FileError, Problem};

/// Where a picture is written to.
pub(super) type Out = BufWriter<File>;

/// Checks, before any work is done, that `path` can be an output; returns its format.
///
/// # Errors
/// If its extension says no format, its folder is not there, it is not a plain file, or it
/// exists and `force` is not given.
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
    Ok(format)
}

/// Lets `write` fill a temporary file in the folder of `path`, then renames it to `path`.
pub(super) fn replace<T>(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut Out) -> Result<T, Problem>,
) -> Result<T, FileError> {
    replace_resolved(&resolved(path), force, write).map_err(|problem| problem.at(path))
}

fn replace_resolved<T>(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut Out) -> Result<T, Problem>,
) -> Result<T, Problem> {
    let temporary = create_beside(path).map_err(Problem::Write)?;
    let file = temporary.reopen().map_err(Problem::Write)?;
    let mut out = BufWriter::with_capacity(1 << 20, file);
    let result = write(&mut out)?;
    out.flush().map_err(Problem::Write)?;
    drop(out);
    let kept = if force { temporary.persist(path) } else { temporary.persist_noclobber(path) };
    kept.map_err(|e| match e.error.kind() {
        std::io::ErrorKind::AlreadyExists => Problem::Exists,
        _ => Problem::Write(e.error),
    })?;
    Ok(result)
}

/// A temporary file with the permissions that the output has or would get.
fn create_beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".wgdenoise-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(folder(path))?;
    if let Ok(existing) = fs::metadata(path) {
        fs::set_permissions(temporary.path(), existing.permissions())?;
    }
    Ok(temporary)
}

/// What a link points to, so that the link stays one.
fn resolved(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

fn folder(path: &Path) -> &Path {
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
        let write = |out: &mut Out| out.write_all(b"new").map_err(Problem::Write);
        assert!(matches!(check(&path, false).unwrap_err().problem, Problem::Exists));
        assert!(matches!(replace(&path, false, write).unwrap_err().problem, Problem::Exists));
        replace(&path, true, write).unwrap();
        assert_eq!((fs::read(&path).unwrap(), entries(folder.path())), (b"new".to_vec(), 1));
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
