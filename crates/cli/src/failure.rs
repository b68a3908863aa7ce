//! Why the program stops, and with which exit code.

use std::path::Path;

use wgdenoise::Error;
use wgdenoise_files::{FileError, Problem, escaped};

/// A failed run. The message is one sentence.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// An input could not be read, or the output could not be made.
    #[error("{0}")]
    Work(String),
    /// The command line was wrong in a way that its grammar cannot express.
    #[error("{0}")]
    Usage(String),
    /// No adapter can do the work, or the chosen one lacks what the flags need.
    #[error("{0}")]
    Adapter(String),
    /// The device was lost, hangs or computes wrong results.
    #[error("{0}")]
    Device(String),
    /// The host asked to stop.
    #[error("denoising was stopped")]
    Stopped,
}

impl Failure {
    /// A problem with a file.
    pub(crate) fn of(path: &Path, problem: impl std::fmt::Display) -> Self {
        Self::Work(format!("{}: {problem}", shown(path)))
    }

    /// A file that cannot be used as the command line asks, with the flags that help; `layer_flag`
    /// names layers.
    pub(crate) fn of_file(error: &FileError, layer_flag: &str) -> Self {
        if matches!(error.problem, Problem::Pattern(_)) {
            return Self::Usage(error.to_string());
        }
        let advice = match error.problem {
            Problem::Exists => "; give --force to replace it".into(),
            Problem::NoFolder(_) => "; give --parents to create it".into(),
            Problem::TooManyPixels { .. } => "; give --max-pixels to accept more".into(),
            Problem::LargeBlocks { .. } => ", or give a higher --max-pixels".into(),
            Problem::AmbiguousColor(_) => format!("; name one with {layer_flag}"),
            _ => String::new(),
        };
        Self::Work(format!("{error}{advice}"))
    }

    /// The exit code of a program that fails this way.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Work(_) => 1,
            Self::Usage(_) => 2,
            Self::Adapter(_) => 3,
            Self::Device(_) => 4,
            Self::Stopped => 130,
        }
    }
}

/// Formats a path for a message.
pub(crate) fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::of_file(&error, "--color")
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::NoAdapter(_) | Error::Unsupported(_) => Self::Adapter(error.to_string()),
            Error::DeviceLost { .. }
            | Error::Timeout { .. }
            | Error::WrongResult(_)
            | Error::Device { .. } => Self::Device(error.to_string()),
            Error::Stopped => Self::Stopped,
            other => Self::Work(other.to_string()),
        }
    }
}
