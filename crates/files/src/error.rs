//! What can go wrong with a file.

use std::io;
use std::path::{Path, PathBuf};

/// A problem with a file: one sentence that begins with the file's path.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub problem: Problem,
}

/// What is wrong with a file; the text goes on where the file's name ended.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The system does not let it be read.
    #[error("cannot be read: {0}")]
    Read(#[source] io::Error),
    /// The system does not let it be written.
    #[error("cannot be written: {0}")]
    Write(#[source] io::Error),
    /// It is there and may not be replaced.
    #[error("already exists; give --force to replace it")]
    Exists,
    /// It is of none of the known formats.
    #[error("{0}")]
    Format(String),
    /// It is cut off or contradicts itself.
    #[error("{0}")]
    Damaged(String),
    /// It uses a feature of its format that is not supported.
    #[error("{0}")]
    Unsupported(String),
    /// It claims more pixels or bytes than are accepted.
    #[error("{0}")]
    TooLarge(String),
    /// A layer is not there or cannot be used.
    #[error("{0}")]
    Layers(String),
    /// Two images that belong together differ in size.
    #[error("{0}")]
    Size(String),
}

impl Problem {
    /// The same, with the file's path.
    #[must_use]
    pub fn at(self, path: &Path) -> FileError {
        FileError { path: path.to_path_buf(), problem: self }
    }
}
