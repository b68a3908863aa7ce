//! Outputs appear whole or not at all: a file is written in the output's folder and named at the
//! end, so a failure leaves what was there.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Seek, Write};
use std::path::Path;

use super::draft::Draft;
use super::format::Format;
use super::identity::{folder, place};
use super::stream::{self, is_standard};
use super::{FileError, Problem};

/// The file being written.
pub type Out<'a> = BufWriter<&'a File>;

/// Checks, before any work is done, that an image can be written to `path`; returns its format.
///
/// # Errors
/// If its extension names no format, or as in [`check_place`].
pub fn check(path: &Path, force: bool) -> Result<Format, FileError> {
    let format = Format::of_extension(path).map_err(|p| p.at(path))?;
    check_place(path, force)?;
    Ok(format)
}

/// Checks, before any work is done, that a file of any kind can be written to `path`, which may be
/// `-` for standard output.
///
/// # Errors
/// If its folder does not exist or accepts no file, the system rejects the name, it is not a plain
/// file, or it exists and `force` is not given.
pub fn check_place(path: &Path, force: bool) -> Result<(), FileError> {
    if is_standard(path) {
        return check_stdout().map_err(|problem| problem.at(path));
    }
    if !folder(path).is_dir() {
        return Err(Problem::NoFolder(folder(path).to_path_buf()).at(path));
    }
    if path.exists() && !path.is_file() {
        let what = "cannot be written: it is not a plain file; give - for standard output";
        return Err(Problem::Format(what.into()).at(path));
    }
    match fs::symlink_metadata(path) {
        Ok(_) if !force => return Err(Problem::Exists.at(path)),
        // Such as a name too long.
        Err(error) if error.kind() != ErrorKind::NotFound => {
            return Err(Problem::Write(error).at(path));
        }
        _ => {}
    }
    // The file made here is removed at once.
    draft(&place(path)).map_err(|p| p.at(path))?;
    Ok(())
}

/// Writes a file as a whole: `path` becomes what `write` wrote or, if that fails, stays as it was.
/// A link stays a link to the file that is replaced, and the file keeps its permissions. Standard
/// output, `-`, gets all of it or nothing.
///
/// # Errors
/// If `path` exists and `force` is not given, `write` fails, or the system does.
pub fn replace<T>(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut Out<'_>) -> Result<T, Problem>,
) -> Result<T, FileError> {
    if is_standard(path) {
        return to_stdout(write).map_err(|problem| problem.at(path));
    }
    // Without `force`, a dangling link counts as existing.
    let target = if force { place(path) } else { path.to_path_buf() };
    replace_target(&target, force, write).map_err(|problem| problem.at(path))
}

/// Refuses a terminal, which would take a picture for commands.
fn check_stdout() -> Result<(), Problem> {
    if io::stdout().is_terminal() {
        return Err(Problem::Format("is a terminal; give a file, or write into a pipe".into()));
    }
    Ok(())
}

/// Writes to a temporary file first: pictures are not written front to back, but pipes are.
fn to_stdout<T>(write: impl FnOnce(&mut Out<'_>) -> Result<T, Problem>) -> Result<T, Problem> {
    let in_folder = |error: io::Error| stream::full(&error);
    let mut file = tempfile::tempfile().map_err(in_folder)?;
    let mut out = BufWriter::with_capacity(1 << 20, &file);
    let result = write(&mut out)?;
    out.flush().map_err(in_folder)?;
    drop(out);
    let mut stdout = io::stdout().lock();
    let copied = file.rewind().and_then(|()| io::copy(&mut file, &mut stdout));
    copied.and_then(|_| stdout.flush()).map_err(Problem::Write)?;
    Ok(result)
}

fn replace_target<T>(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut Out<'_>) -> Result<T, Problem>,
) -> Result<T, Problem> {
    let draft = draft(path)?;
    let mut out = BufWriter::with_capacity(1 << 20, draft.file());
    let result = write(&mut out)?;
    out.flush().map_err(Problem::Write)?;
    drop(out);
    finish(draft.file(), path).map_err(Problem::Write)?;
    draft.keep(path, force).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => Problem::Exists,
        _ => Problem::Write(error),
    })?;
    Ok(result)
}

/// Gives a file the permissions of the one it replaces, and its owner and group where the system
/// allows it; flushes it to disk before it is named.
fn finish(file: &File, path: &Path) -> io::Result<()> {
    if let Ok(existing) = fs::metadata(path) {
        #[cfg(unix)]
        keep_owner(file, &existing);
        file.set_permissions(existing.permissions())?;
    }
    file.sync_all()
}

/// Only the superuser may give files away, but others may keep a group that they belong to.
#[cfg(unix)]
fn keep_owner(file: &File, existing: &fs::Metadata) {
    use std::os::unix::fs::{MetadataExt, fchown};
    let group = Some(existing.gid());
    let _ = fchown(file, Some(existing.uid()), group).or_else(|_| fchown(file, None, group));
}

fn draft(path: &Path) -> Result<Draft, Problem> {
    Draft::within(folder(path)).map_err(Problem::Write)
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

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

    /// This test also runs as the process that is killed, in the middle of writing.
    #[test]
    fn a_process_that_is_killed_while_it_writes_leaves_the_old_file_whole() {
        const OUTPUT: &str = "WGDENOISE_TEST_OUTPUT";
        const THIS: &str =
            "output::tests::a_process_that_is_killed_while_it_writes_leaves_the_old_file_whole";
        if let Some(path) = std::env::var_os(OUTPUT) {
            return write_half_and_wait(Path::new(&path));
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.exr");
        fs::write(&path, "old").unwrap();
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", THIS, "--nocapture"]).env(OUTPUT, &path);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap().ends_with("half is written")));
        child.kill().unwrap();
        assert!(!child.wait().unwrap().success());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        if cfg!(target_os = "linux") {
            assert_eq!(entries(folder.path()), 1);
        }
    }

    fn write_half_and_wait(path: &Path) {
        let half = |out: &mut Out<'_>| {
            out.write_all(&vec![1; 4 << 20]).and_then(|()| out.flush()).map_err(Problem::Write)?;
            println!("half is written");
            // Until the other process kills this one or is gone itself.
            io::stdin().read_line(&mut String::new()).map_err(Problem::Read)
        };
        replace(path, true, half).unwrap();
        panic!("nothing has killed this process");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_to_what_is_replaced() {
        let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let (link, real) = (folder.path().join("link.exr"), other.path().join("real.exr"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        assert!(matches!(check(&link, false).unwrap_err().problem, Problem::Exists));
        replace(&link, true, |out| out.write_all(b"new").map_err(Problem::Write)).unwrap();
        assert_eq!(
            (fs::read(&real).unwrap(), fs::read_link(&link).unwrap()),
            (b"new".into(), real)
        );
        assert_eq!((entries(folder.path()), entries(other.path())), (1, 1));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_missing_file_stays_a_link_and_its_target_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (link, real) = (folder.path().join("link.exr"), folder.path().join("real.exr"));
        std::os::unix::fs::symlink("real.exr", &link).unwrap();
        let write = |out: &mut Out<'_>| out.write_all(b"new").map_err(Problem::Write);
        assert!(matches!(replace(&link, false, write).unwrap_err().problem, Problem::Exists));
        check(&link, true).unwrap();
        replace(&link, true, write).unwrap();
        assert_eq!((fs::read(&real).unwrap(), link.is_symlink()), (b"new".to_vec(), true));
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

    /// Only the superuser can try it.
    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_owner_and_group_where_the_system_allows_it() {
        use std::os::unix::fs::{MetadataExt, chown};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.exr");
        fs::write(&path, "old").unwrap();
        let given_away = chown(&path, Some(1234), Some(2345)).is_ok();
        let before = fs::metadata(&path).unwrap();
        replace(&path, true, |out| out.write_all(b"new").map_err(Problem::Write)).unwrap();
        let after = fs::metadata(&path).unwrap();
        assert_eq!((after.uid(), after.gid()), (before.uid(), before.gid()));
        assert!(!given_away || after.uid() == 1234);
    }

    #[test]
    fn an_output_must_have_a_known_extension_and_a_folder_and_be_a_plain_file() {
        let text = |path: &str| check(Path::new(path), true).unwrap_err().to_string();
        assert!(text("picture.tiff").contains(".exr, .png, .jpg or .jpeg"));
        assert!(text("no/such/folder/x.exr").contains("the folder no/such/folder does not exist"));
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("folder.exr");
        fs::create_dir(&inner).unwrap();
        assert!(text(inner.to_str().unwrap()).contains("not a plain file"));
    }
}
