//! What the user names as input: a file, a sequence of frames, or a pattern.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::{fs, io};

use glob::MatchOptions;

use super::frames::{self, Frames, Pattern};
use super::{FileError, Problem, escaped, is_stream};

/// One input.
#[derive(Debug)]
pub enum Source {
    /// A file, whether it exists or not, a pipe, or `-` for standard input.
    File(PathBuf),
    /// The frames of an animation.
    Sequence(Sequence),
    /// All files that match, for shells that do not expand patterns.
    Glob(String),
}

/// Matches patterns as shells do.
const AS_SHELLS: MatchOptions = MatchOptions {
    case_sensitive: true,
    require_literal_separator: true,
    require_literal_leading_dot: true,
};

impl Source {
    /// Classifies a path. A path that exists is a file, whatever its name looks like.
    ///
    /// # Errors
    /// [`Problem::Pattern`] if the name has two places for a frame number, or one that is too long.
    pub fn of(path: &Path) -> Result<Self, FileError> {
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

    /// Whether it has a place for the frame number.
    #[must_use]
    pub fn is_sequence(&self) -> bool {
        matches!(self, Self::Sequence(_))
    }

    /// Lists the files, all of which exist, with the frame numbers of a sequence.
    ///
    /// # Errors
    /// If there is none, a wanted frame is missing, or a file is a folder or a device.
    pub fn files(&self, frames: Option<&Frames>) -> Result<Vec<(PathBuf, Option<i64>)>, FileError> {
        match self {
            Self::File(path) => check_file(path).map(|()| vec![(path.clone(), None)]),
            Self::Glob(pattern) => {
                Ok(matching(pattern)?.into_iter().map(|path| (path, None)).collect())
            }
            Self::Sequence(sequence) => {
                let files = sequence.files(frames)?;
                Ok(files.into_iter().map(|(frame, file)| (file, Some(frame))).collect())
            }
        }
    }

    /// A sentence on files of a sequence whose numbers are not frames, such as subframes.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn left_out(&self) -> Result<Option<String>, FileError> {
        match self {
            Self::Sequence(sequence) => sequence.left_out(),
            Self::File(_) | Self::Glob(_) => Ok(None),
        }
    }
}

fn check_file(path: &Path) -> Result<(), FileError> {
    if is_stream(path) {
        return Ok(());
    }
    match path.metadata() {
        Err(error) => Err(Problem::Read(error).at(path)),
        Ok(metadata) if metadata.is_dir() => {
            Err(Problem::Format("is a folder and not an image".into()).at(path))
        }
        Ok(metadata) if metadata.is_file() => Ok(()),
        Ok(_) => Err(Problem::NotRegular.at(path)),
    }
}

fn matching(pattern: &str) -> Result<Vec<PathBuf>, FileError> {
    let of = |problem: Problem| problem.at(Path::new(pattern));
    let paths = glob::glob_with(pattern, AS_SHELLS)
        .map_err(|error| of(Problem::Pattern(format!("is not a valid pattern: {}", error.msg))))?;
    let paths: Result<Vec<_>, _> = paths.collect();
    let mut paths = paths.map_err(|error| of(Problem::Read(error.into())))?;
    paths.retain(|path| path.is_file());
    if paths.is_empty() { Err(of(Problem::NotFound(NOT_FOUND.into()))) } else { Ok(paths) }
}

const NOT_FOUND: &str = "matches no file";

/// The files of an animation, such as `renders/beauty.####.exr`.
#[derive(Debug)]
pub struct Sequence {
    path: PathBuf,
    pattern: Pattern,
}

impl Sequence {
    /// Parses a path; `None` if it names a single file.
    ///
    /// # Errors
    /// [`Problem::Pattern`], as in [`Source::of`].
    pub fn of(path: &Path) -> Result<Option<Self>, FileError> {
        let pattern = Pattern::parse(path.file_name().unwrap_or_default())
            .map_err(|why| Problem::Pattern(why).at(path))?;
        Ok(pattern.map(|pattern| Self { path: path.to_path_buf(), pattern }))
    }

    /// The path to write a frame's file to; an existing file may be padded differently.
    #[must_use]
    pub fn file(&self, frame: i64) -> PathBuf {
        self.path.with_file_name(self.pattern.name(frame))
    }

    /// Lists the wanted frames, all of which must exist, or by default every frame that exists.
    ///
    /// # Errors
    /// If there is none, or a wanted one is missing.
    pub fn files(&self, wanted: Option<&Frames>) -> Result<BTreeMap<i64, PathBuf>, FileError> {
        let mut existing = self.existing()?;
        match wanted {
            Some(Frames(wanted)) => {
                self.check(wanted, &existing)?;
                existing.retain(|frame, _| wanted.binary_search(frame).is_ok());
            }
            None if existing.is_empty() => return Err(self.not_found()?),
            None => {}
        }
        Ok(existing)
    }

    /// The error that there is no frame, with files that come near.
    fn not_found(&self) -> Result<FileError, FileError> {
        let near = self.near()?.map(|names| format!(", but {names} with another number of digits"));
        let what = format!("{NOT_FOUND}{}", near.unwrap_or_default());
        Ok(Problem::NotFound(what).at(&self.path))
    }

    /// Refuses frames without a file.
    fn check(&self, wanted: &[i64], existing: &BTreeMap<i64, PathBuf>) -> Result<(), FileError> {
        let is_missing = |frame: &i64| !existing.contains_key(frame);
        let missing: Vec<_> = wanted.iter().copied().filter(is_missing).collect();
        let what = match missing.as_slice() {
            [] => return Ok(()),
            [one] => format!("frame {one} is missing"),
            _ => format!("frames {} are missing", frames::shown(&missing)),
        };
        Err(Problem::NotFound(what).at(&self.path))
    }

    /// All frames and their files. Of two files for one frame, the one with the pattern's own
    /// padding wins.
    fn existing(&self) -> Result<BTreeMap<i64, PathBuf>, FileError> {
        let frame = |name: OsString| Some((self.pattern.frame(&name)?, name));
        let mut frames = BTreeMap::new();
        for (frame, name) in self.names()?.into_iter().filter_map(frame) {
            let file = self.path.with_file_name(name);
            if file == self.file(frame) || !frames.contains_key(&frame) {
                frames.insert(frame, file);
            }
        }
        Ok(frames)
    }

    /// The names of all files in the folder.
    fn names(&self) -> Result<Vec<OsString>, FileError> {
        let folder = self.path.parent().filter(|parent| *parent != Path::new(""));
        let name = |entry: io::Result<fs::DirEntry>| entry.map(|entry| entry.file_name());
        let entries = fs::read_dir(folder.unwrap_or(Path::new(".")));
        entries.and_then(|entries| entries.map(name).collect()).map_err(|error| {
            Problem::NotFound(format!("its folder cannot be read: {error}")).at(&self.path)
        })
    }

    fn left_out(&self) -> Result<Option<String>, FileError> {
        let near = self.near()?;
        Ok(near.map(|names| {
            let pattern = shown(&self.path);
            format!("{pattern}: left out {names}: no whole frames with this number of digits")
        }))
    }

    /// Names of files whose numbers are not frames of this sequence, such as subframes.
    fn near(&self) -> Result<Option<String>, FileError> {
        let mut names = self.names()?;
        names.retain(|name| self.pattern.is_near(name));
        names.sort();
        let more = match names.len().saturating_sub(MOST_LISTED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let listed = names.iter().take(MOST_LISTED).map(|name| shown(Path::new(name)));
        let listed = listed.collect::<Vec<_>>().join(", ");
        Ok((!names.is_empty()).then(|| listed + &more))
    }
}

/// Most names in one message.
const MOST_LISTED: usize = 5;

/// A path in a message.
fn shown(path: &Path) -> String {
    escaped(&path.to_string_lossy())
}
