//! What an IN of the command line stands for: a file, a sequence of frames, or a pattern.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::{fs, io};

use glob::MatchOptions;

use crate::failure::{Failure, shown};
use crate::frames::{self, Frames, Pattern};
use wgdenoise_files::{Problem, is_stream};

/// One IN.
#[derive(Debug)]
pub(crate) enum Source {
    /// A file, whether it exists or not, a pipe, or `-` for standard input.
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
    ) -> Result<Vec<(PathBuf, Option<i64>)>, Failure> {
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

    /// A sentence on files of a sequence that are no frames by their numbers, such as subframes.
    pub(crate) fn left_out(&self) -> Result<Option<String>, Failure> {
        match self {
            Self::Sequence(sequence) => sequence.left_out(),
            Self::File(_) | Self::Glob(_) => Ok(None),
        }
    }
}

fn check_file(path: &Path) -> Result<(), Failure> {
    if is_stream(path) {
        return Ok(());
    }
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
        let pattern = Pattern::parse(path.file_name().unwrap_or_default())
            .map_err(|why| Failure::Usage(format!("{}: {why}", shown(path))))?;
        Ok(pattern.map(|pattern| Self { path: path.to_path_buf(), pattern }))
    }

    /// The name of a frame's file if it is written, or one that exists.
    pub(crate) fn file(&self, frame: i64) -> PathBuf {
        self.path.with_file_name(self.pattern.name(frame))
    }

    /// The wanted frames, all of which must exist, or else every frame that exists.
    pub(crate) fn files(&self, wanted: Option<&Frames>) -> Result<BTreeMap<i64, PathBuf>, Failure> {
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

    /// That there is no frame, and which files are near.
    fn not_found(&self) -> Result<Failure, Failure> {
        let near = self.near()?.map(|names| format!(", but {names} with another number of digits"));
        Ok(Failure::of(&self.path, format_args!("{NOT_FOUND}{}", near.unwrap_or_default())))
    }

    /// Refuses frames without a file.
    fn check(&self, wanted: &[i64], existing: &BTreeMap<i64, PathBuf>) -> Result<(), Failure> {
        let is_missing = |frame: &i64| !existing.contains_key(frame);
        let missing: Vec<_> = wanted.iter().copied().filter(is_missing).collect();
        match missing.as_slice() {
            [] => Ok(()),
            [one] => Err(Failure::of(&self.path, format_args!("frame {one} is missing"))),
            _ => {
                let listed = frames::shown(&missing);
                Err(Failure::of(&self.path, format_args!("frames {listed} are missing")))
            }
        }
    }

    /// The files of all frames. Of two for one frame, that with the pattern's own padding counts.
    fn existing(&self) -> Result<BTreeMap<i64, PathBuf>, Failure> {
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

    /// The names in its folder.
    fn names(&self) -> Result<Vec<OsString>, Failure> {
        let folder = self.path.parent().filter(|parent| *parent != Path::new(""));
        let name = |entry: io::Result<fs::DirEntry>| entry.map(|entry| entry.file_name());
        let entries = fs::read_dir(folder.unwrap_or(Path::new(".")));
        entries.and_then(|entries| entries.map(name).collect()).map_err(|error| {
            Failure::of(&self.path, format_args!("its folder cannot be read: {error}"))
        })
    }

    fn left_out(&self) -> Result<Option<String>, Failure> {
        let near = self.near()?;
        Ok(near.map(|names| {
            let pattern = shown(&self.path);
            format!("{pattern}: left out {names}: no whole frames with this number of digits")
        }))
    }

    /// Names of files whose numbers are no frames of this sequence, such as subframes.
    fn near(&self) -> Result<Option<String>, Failure> {
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
