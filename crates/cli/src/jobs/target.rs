//! What OUT stands for.

use std::path::{Path, PathBuf, is_separator};

use super::sequence::Sequence;
use super::source::Source;
use crate::failure::Failure;

/// Where results go.
#[derive(Debug)]
pub(super) enum Target {
    /// The one result.
    File(PathBuf),
    /// Each by its frame number.
    Sequence(Sequence),
    /// Each by the name of its input.
    Folder(PathBuf),
}

impl Target {
    pub(super) fn of(path: &Path, sources: &[Source]) -> Result<Self, Failure> {
        if path.is_dir() {
            return Ok(Self::Folder(path.to_path_buf()));
        }
        let shown = path.display();
        match (Sequence::of(path)?, sources) {
            (Some(sequence), [Source::Sequence(_)]) => Ok(Self::Sequence(sequence)),
            // A file that is really called so may have an output that is.
            (Some(_), [Source::File(input)])
                if input.exists() && Sequence::of(input)?.is_some() =>
            {
                Ok(Self::File(path.to_path_buf()))
            }
            (Some(_), _) => Err(Failure::Usage(format!(
                "{shown}: leaves the frame number open, and that needs one IN that does"
            ))),
            (None, [Source::Sequence(_)]) => Err(Failure::Usage(format!(
                "{shown}: must leave the frame number open as IN does, as in clean.####.exr, or \
                 be a folder that is there"
            ))),
            (None, [Source::File(_)]) if !ends_as_folder(path) => {
                Ok(Self::File(path.to_path_buf()))
            }
            _ => Err(Failure::Work(format!(
                "{shown}: the results need a folder, and there is none of this name; create it \
                 first"
            ))),
        }
    }

    /// The output of an input, which has a frame number if this is needed.
    pub(super) fn path(&self, input: &Path, frame: Option<u32>) -> PathBuf {
        match (self, frame) {
            (Self::Sequence(sequence), Some(frame)) => sequence.file(frame),
            (Self::Sequence(_), None) => unreachable!("an OUT with frames has an IN with frames"),
            (Self::Folder(folder), _) => folder.join(input.file_name().unwrap_or_default()),
            (Self::File(path), _) => path.clone(),
        }
    }
}

fn ends_as_folder(path: &Path) -> bool {
    path.to_string_lossy().ends_with(is_separator)
}
