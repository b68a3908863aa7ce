//! What can go wrong with a file.

use std::io;
use std::path::{Path, PathBuf};

use crate::escape::escaped;

/// A problem with a file. The message is one sentence that starts with the path.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", escaped(&path.to_string_lossy()))]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub problem: Problem,
}

/// What is wrong with a file. The message completes a sentence that starts with the file's name.
///
/// A caller that offers a way out of [`Exists`](Self::Exists), [`NoFolder`](Self::NoFolder),
/// [`TooManyPixels`](Self::TooManyPixels), [`LargeBlocks`](Self::LargeBlocks) or
/// [`AmbiguousColor`](Self::AmbiguousColor) adds it to the message.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The system cannot read it.
    #[error("cannot be read: {0}")]
    Read(#[source] io::Error),
    /// The system cannot write it.
    #[error("cannot be written: {0}")]
    Write(#[source] io::Error),
    /// It is a device, whose reading may never end, or a pipe where a file is needed.
    #[error("is not a regular file; give a file on disk")]
    NotRegular,
    /// No file has the name that was given, or a frame of a sequence is missing.
    #[error("{0}")]
    NotFound(String),
    /// Its name is not a valid pattern for files or frames.
    #[error("{0}")]
    Pattern(String),
    /// It exists and must not be replaced.
    #[error("already exists")]
    Exists,
    /// The folder it should go into does not exist.
    #[error("cannot be written: the folder {} does not exist", escaped(&.0.to_string_lossy()))]
    NoFolder(PathBuf),
    /// It has none of the known formats.
    #[error("{0}")]
    Format(String),
    /// It is truncated or contradicts itself.
    #[error("{0}")]
    Damaged(String),
    /// It uses a feature of its format that is not supported.
    #[error("{0}")]
    Unsupported(String),
    /// It claims more pixels than [`Limits`](crate::Limits) accepts.
    #[error("claims {width}×{height} pixels, and at most {most} are accepted")]
    TooManyPixels {
        /// Pixels per row.
        width: u64,
        /// Rows.
        height: u64,
        /// The most pixels that are accepted.
        most: u64,
    },
    /// Its blocks unpack to more bytes than [`Limits`](crate::Limits) accepts.
    #[error(
        "has blocks of {bytes} bytes, and at most {most} are accepted; write it with smaller \
         tiles or another compression"
    )]
    LargeBlocks {
        /// The size of the largest block.
        bytes: u128,
        /// The most bytes that are accepted.
        most: u64,
    },
    /// It needs more memory than is reasonable.
    #[error("{0}")]
    TooLarge(String),
    /// Several layers could be the color.
    #[error("{0}")]
    AmbiguousColor(String),
    /// A layer is missing or cannot be used.
    #[error("{0}")]
    Layers(String),
    /// Two images that belong together differ in size.
    #[error("{0}")]
    Size(String),
}

impl Problem {
    /// Adds the path of the file.
    #[must_use]
    pub fn at(self, path: &Path) -> FileError {
        FileError { path: path.to_path_buf(), problem: self }
    }
}
