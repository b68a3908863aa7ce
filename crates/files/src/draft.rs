//! Files that are unnamed, or temporarily named, until they are complete.
//!
//! Own code over `tempfile` because no crate does both: the unnamed files of `tempfile` cannot be
//! given a name, and `atomic-write-file` always replaces an existing file.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, NamedTempFile};

/// Drafts with a temporary name. Locked whenever a draft gets or loses a name.
static NAMED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn named() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    NAMED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes half-written files, for a process about to end: no file can be written after this.
pub fn discard_drafts() {
    let named = named();
    for path in &*named {
        let _ = fs::remove_file(path);
    }
    // Never unlock it.
    std::mem::forget(named);
}

/// A file being written.
#[derive(Debug)]
pub(super) enum Draft {
    /// Vanishes with the process, however it ends.
    #[cfg(target_os = "linux")]
    Nameless(File),
    /// Where the system has no unnamed files: removed unless the process is killed.
    Named(NamedTempFile, Listed),
}

impl Draft {
    /// Creates an empty file in a folder, with the permissions of a new file.
    pub(super) fn within(folder: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Some(file) = nameless::file(folder) {
            return Ok(Self::Nameless(file));
        }
        Self::with_name(folder)
    }

    fn with_name(folder: &Path) -> io::Result<Self> {
        let mut named = named();
        let file = builder().tempfile_in(folder).map_err(|error| known(&error))?;
        named.insert(file.path().to_path_buf());
        let listed = Listed(file.path().to_path_buf());
        Ok(Self::Named(file, listed))
    }

    pub(super) fn file(&self) -> &File {
        match self {
            #[cfg(target_os = "linux")]
            Self::Nameless(file) => file,
            Self::Named(named, _) => named.as_file(),
        }
    }

    /// Names the file, in its folder; without `force` only if nothing has that name yet.
    pub(super) fn keep(self, path: &Path, force: bool) -> io::Result<()> {
        let named = named();
        let (temporary, listed) = match self {
            // A link cannot replace a file, but a rename can.
            #[cfg(target_os = "linux")]
            Self::Nameless(file) => {
                let link = |name: &Path| nameless::link(&file, name);
                let linked = builder().make_in(super::identity::folder(path), link);
                (linked.map_err(|error| known(&error))?.into_temp_path(), None)
            }
            Self::Named(file, listed) => (file.into_temp_path(), Some(listed)),
        };
        let kept = if force { temporary.persist(path) } else { temporary.persist_noclobber(path) };
        drop(named);
        drop(listed);
        kept.map_err(|error| error.error)
    }
}

/// A temporary name, listed in [`NAMED`] as long as the draft has it.
#[derive(Debug)]
pub(super) struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        named().remove(&self.0);
    }
}

fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".wgdenoise-").suffix(".part");
    #[cfg(unix)]
    {
        use std::fs::Permissions;
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(Permissions::from_mode(0o666));
    }
    builder
}

/// Cuts the temporary file's path off an error message: it means nothing to a user.
fn known(error: &io::Error) -> io::Error {
    let text = error.to_string();
    io::Error::new(error.kind(), text.split(" at path ").next().unwrap_or_default())
}

#[cfg(target_os = "linux")]
mod nameless {
    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::{Path, PathBuf};

    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};

    /// Creates an unnamed file; `None` where the system or the file system has none, or cannot name
    /// it later.
    pub(super) fn file(folder: &Path) -> Option<File> {
        let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
        let file = File::from(open(folder, flags, Mode::from_raw_mode(0o666)).ok()?);
        Some(file).filter(|file| place(file).exists())
    }

    pub(super) fn link(file: &File, name: &Path) -> io::Result<()> {
        Ok(linkat(CWD, place(file), CWD, name, AtFlags::SYMLINK_FOLLOW)?)
    }

    fn place(file: &File) -> PathBuf {
        format!("/proc/self/fd/{}", file.as_raw_fd()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draft_with_a_name_is_listed_until_it_is_kept_or_given_up() {
        let folder = tempfile::tempdir().unwrap();
        let listed = || named().iter().filter(|path| path.starts_with(folder.path())).count();
        let drafts = [(); 2].map(|()| Draft::with_name(folder.path()).unwrap());
        assert_eq!((listed(), fs::read_dir(folder.path()).unwrap().count()), (2, 2));
        let [kept, given_up] = drafts;
        kept.keep(&folder.path().join("kept"), false).unwrap();
        drop(given_up);
        assert_eq!((listed(), fs::read_dir(folder.path()).unwrap().count()), (0, 1));
    }

    /// This test also runs as the process that ends, with a draft that would otherwise stay.
    #[test]
    fn what_is_discarded_leaves_no_file() {
        const FOLDER: &str = "WGDENOISE_TEST_FOLDER";
        if let Some(folder) = std::env::var_os(FOLDER) {
            let draft = Draft::with_name(Path::new(&folder)).unwrap();
            discard_drafts();
            std::mem::forget(draft);
            std::process::exit(7);
        }
        let folder = tempfile::tempdir().unwrap();
        let mut command = std::process::Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "draft::tests::what_is_discarded_leaves_no_file"]);
        let status = command.env(FOLDER, folder.path()).status().unwrap();
        assert_eq!((status.code(), fs::read_dir(folder.path()).unwrap().count()), (Some(7), 0));
    }
}
