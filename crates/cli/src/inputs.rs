//! What an IN of the command line stands for: a file, a sequence of frames, or a pattern.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{fs, io};

use glob::MatchOptions;

use crate::failure::{Failure, shown};
use crate::frames::{self, Frames, Pattern};
use wgdenoise_files::Problem;

/// One IN.
#[derive(Debug)]
pub(crate) enum Source {
    /// A file, whether it exists or not.
    File(PathBuf),
    Sequence(Sequence),
    /// All files that match, for shells that do not expand patterns.
    Glob(String),
}

/// The matching rules of shells.
const AS_SHELLS: MatchOptions = MatchOptions {
    case_sensitive: true,
    require_literal_separator: true,
    require_literal_leading_dot: true,
};

impl Source {
    /// A path that exists is a file, whatever its name looks like.
    pub(crate) fn of(path: &Path) -> Result<Self, Failure> {
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

    pub(crate) fn is_sequence(&self) -> bool {
        matches!(self, Self::Sequence(_))
    }

    /// The files, all of which exist, with the frame numbers of a sequence.
    pub(crate) fn files(
        &self,
        frames: Option<&Frames>,
    ) -> Result<Vec<(PathBuf, Option<u32>)>, Failure> {
        match self {
            Self::File(path) => check_file(path).map(|()| vec![(path.clone(), None)]),
            Self::Glob(pattern) => {
                Ok(matching(pattern)?.into_iter().map(|path| (path, None)).collect())
            }
            Self::Sequence(sequence) => {
                let frames = sequence.frames(frames)?;
                Ok(frames.into_iter().map(|f| (sequence.file(f), Some(f))).collect())
            }
        }
    }
}

fn check_file(path: &Path) -> Result<(), Failure> {
    match path.metadata() {
        Err(error) => Err(Failure::of(path, format_args!("cannot be read: {error}"))),
        Ok(metadata) if metadata.is_dir() => Err(Failure::of(path, "is a folder and not an image")),
        Ok(metadata) if metadata.is_file() => Ok(()),
        Ok(_) => Err(Failure::of(path, Problem::NotRegular)),
    }
}

fn matching(pattern: &str) -> Result<Vec<PathBuf>, Failure> {
    let of = |what: String| Failure::of(Path::new(pattern), what);
    let paths = glob::glob_with(pattern, AS_SHELLS).map_err(|error| {
        let pattern = shown(Path::new(pattern));
        Failure::Usage(format!("{pattern}: is not a valid pattern: {}", error.msg))
    })?;
    let paths: Result<Vec<_>, _> = paths.collect();
    let mut paths = paths.map_err(|error| of(format!("cannot be read: {error}")))?;
    paths.retain(|path| path.is_file());
    if paths.is_empty() { Err(of(NOT_FOUND.into())) } else { Ok(paths) }
}

const NOT_FOUND: &str = "no file has such a name";

/// The files of an animation, such as `renders/beauty.####.exr`.
#[derive(Debug)]
pub(crate) struct Sequence {
    path: PathBuf,
    pattern: Pattern,
}

impl Sequence {
    /// `None` for a path that names one file.
    pub(crate) fn of(path: &Path) -> Result<Option<Self>, Failure> {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let pattern = Pattern::parse(name)
            .map_err(|why| Failure::Usage(format!("{}: {why}", shown(path))))?;
        Ok(pattern.map(|pattern| Self { path: path.to_path_buf(), pattern }))
    }

    /// The file of a frame.
    pub(crate) fn file(&self, frame: u32) -> PathBuf {
        self.path.with_file_name(self.pattern.name(frame))
    }

    /// The wanted frames, all of which must exist, or else every frame that exists.
    fn frames(&self, wanted: Option<&Frames>) -> Result<Vec<u32>, Failure> {
        match wanted {
            Some(Frames(wanted)) => self.check(wanted).map(|()| wanted.clone()),
            None => match self.existing()? {
                frames if frames.is_empty() => Err(Failure::of(&self.path, NOT_FOUND)),
                frames => Ok(frames.into_iter().collect()),
            },
        }
    }

    /// Refuses frames without a file.
    pub(crate) fn check(&self, wanted: &[u32]) -> Result<(), Failure> {
        let existing = self.existing()?;
        let missing: Vec<_> = wanted.iter().copied().filter(|f| !existing.contains(f)).collect();
        match missing.as_slice() {
            [] => Ok(()),
            [one] => Err(Failure::of(&self.path, format_args!("frame {one} is missing"))),
            _ => {
                let listed = frames::shown(&missing);
                Err(Failure::of(&self.path, format_args!("frames {listed} are missing")))
            }
        }
    }

    fn existing(&self) -> Result<BTreeSet<u32>, Failure> {
        let folder = self.path.parent().filter(|parent| *parent != Path::new(""));
        let frame = |entry: io::Result<fs::DirEntry>| {
            entry.map(|entry| self.pattern.frame(entry.file_name().to_str()?)).transpose()
        };
        let entries = fs::read_dir(folder.unwrap_or(Path::new(".")));
        let frames = entries.and_then(|entries| entries.filter_map(frame).collect());
        frames.map_err(|error| {
            Failure::of(&self.path, format_args!("its folder cannot be read: {error}"))
        })
    }
}
