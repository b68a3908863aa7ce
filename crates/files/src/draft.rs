//! A file that has no name, or a temporary one, until it is whole.
//!
//! Own code over `tempfile` because no crate does both: the unnamed files of `tempfile` cannot be
//! given a name, and `atomic-write-file` always replaces what is there.

use std::fs::File;
use std::io;
use std::path::Path;

use tempfile::{Builder, NamedTempFile};

/// A file being written.
#[derive(Debug)]
pub(super) enum Draft {
    /// Vanishes when the process ends, however it ends.
    #[cfg(target_os = "linux")]
    Nameless(File),
    /// Where the system has no unnamed files: removed unless the process is killed.
    Named(NamedTempFile),
}

impl Draft {
    /// An empty file in a folder, with the permissions of a new file.
    pub(super) fn within(folder: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Some(file) = nameless::file(folder) {
            return Ok(Self::Nameless(file));
        }
        builder().tempfile_in(folder).map(Self::Named).map_err(|error| known(&error))
    }

    pub(super) fn file(&self) -> &File {
        match self {
            #[cfg(target_os = "linux")]
            Self::Nameless(file) => file,
            Self::Named(named) => named.as_file(),
        }
    }

    /// Gives it a name in its folder; without `force` only if nothing has that name yet.
    pub(super) fn keep(self, path: &Path, force: bool) -> io::Result<()> {
        let temporary = match self {
            // A link cannot replace a file, but a rename can.
            #[cfg(target_os = "linux")]
            Self::Nameless(file) => {
                let link = |name: &Path| nameless::link(&file, name);
                builder()
                    .make_in(super::identity::folder(path), link)
                    .map_err(|error| known(&error))?
                    .into_temp_path()
            }
            Self::Named(named) => named.into_temp_path(),
        };
        let kept = if force { temporary.persist(path) } else { temporary.persist_noclobber(path) };
        kept.map_err(|error| error.error)
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

/// Cuts the path of the temporary file off an error's message: it means nothing to a user.
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

    /// `None` where the system or the file system has no unnamed files, or cannot name them later.
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
