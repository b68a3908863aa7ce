//! Why the program stops, and with which exit code.

use std::process::ExitCode;

use wgdenoise::Error;
use wgdenoise_files::FileError;

/// A failed run; the text is one sentence.
#[derive(Debug, thiserror::Error)]
pub(super) enum Failure {
    /// An input could not be read or the output not be made.
    #[error("{0}")]
    Work(String),
    /// The command line was wrong in a way that its grammar does not tell.
    #[error("{0}")]
    Usage(String),
    /// No adapter can do the work.
    #[error("{0}")]
    Adapter(String),
    /// The device was lost, hangs or computes wrong results.
    #[error("{0}")]
    Device(String),
}

impl Failure {
    pub(super) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Work(_) => 1,
            Self::Usage(_) => 2,
            Self::Adapter(_) => 3,
            Self::Device(_) => 4,
        })
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::Work(error.to_string())
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
            other => Self::Work(other.to_string()),
        }
    }
}
