//! What an IN stands for.

use std::path::{Path, PathBuf};

use glob::MatchOptions;

use super::layers::Layers;
use super::sequence::Sequence;
use crate::failure::Failure;
use crate::frames::Frames;

/// One IN of the command line.
#[derive(Debug)]
pub(super) enum Source {
    /// A file, there or not.
    File(PathBuf),
    /// The frames of an animation.
    Sequence(Sequence),
    /// All files of such names, for shells that do not say which these are.
    Glob(String),
}

/// As shells take patterns.
const AS_SHELLS: MatchOptions = MatchOptions {
    case_sensitive: true,
    require_literal_separator: true,
    require_literal_leading_dot: true,
};

impl Source {
    /// A name is taken as it is if there is such a file.
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
        if path.exists() {
            return Ok(Self::File(path.to_path_buf()));
        }
        if let Some(sequence) = Sequence::of(path)? {
            return Ok(Self::Sequence(sequence));
        }
        Ok(match path.to_str().filter(|text| text.contains(['*', '?', '['])) {
            Some(text) => Self::Glob(text.into()),
            None => Self::File(path.to_path_buf()),
        })
    }

    pub(super) fn is_sequence(&self) -> bool {
        matches!(self, Self::Sequence(_))
    }

    /// Its files, all of which are there, with the frame numbers of an animation.
    pub(super) fn pictures(
        &self,
        frames: Option<&Frames>,
        layers: &Layers,
    ) -> Result<Vec<(PathBuf, Option<u32>)>, Failure> {
        match self {
            Self::File(path) => is_file(path).map(|()| vec![(path.clone(), None)]),
            Self::Glob(pattern) => {
                Ok(matching(pattern)?.into_iter().map(|path| (path, None)).collect())
            }
            Self::Sequence(sequence) => {
                let frames = sequence.frames(frames)?;
                layers.check(&frames)?;
                Ok(frames.into_iter().map(|f| (sequence.file(f), Some(f))).collect())
            }
        }
    }
}

fn is_file(path: &Path) -> Result<(), Failure> {
    let wrong = |what: String| Err(Failure::Work(format!("{}: {what}", path.display())));
    match path.metadata() {
        Err(error) => wrong(format!("cannot be read: {error}")),
        Ok(metadata) if metadata.is_dir() => wrong("is a folder and not an image".into()),
        Ok(_) => Ok(()),
    }
}

fn matching(pattern: &str) -> Result<Vec<PathBuf>, Failure> {
    let wrong = |what: String| Failure::Work(format!("{pattern}: {what}"));
    let paths = glob::glob_with(pattern, AS_SHELLS)
        .map_err(|error| Failure::Usage(format!("{pattern}: is no pattern: {}", error.msg)))?;
    let paths: Result<Vec<_>, _> = paths.collect();
    let mut paths = paths.map_err(|error| wrong(format!("cannot be read: {error}")))?;
    paths.retain(|path| path.is_file());
    if paths.is_empty() { Err(wrong("no file has such a name".into())) } else { Ok(paths) }
}
