//! The files of an animation: a folder, and a file name that leaves the frame number open.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::{fs, io};

use crate::failure::Failure;
use crate::frames::{self, Frames, Pattern};

/// `renders/beauty.####.exr`.
#[derive(Debug)]
pub(super) struct Sequence {
    path: PathBuf,
    pattern: Pattern,
}

impl Sequence {
    /// `None` for a path that names one file.
    pub(super) fn of(path: &Path) -> Result<Option<Self>, Failure> {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let pattern = Pattern::parse(name)
            .map_err(|why| Failure::Usage(format!("{}: {why}", path.display())))?;
        Ok(pattern.map(|pattern| Self { path: path.to_path_buf(), pattern }))
    }

    /// The file of a frame.
    pub(super) fn file(&self, frame: u32) -> PathBuf {
        self.path.with_file_name(self.pattern.name(frame))
    }

    /// The frames asked for, all of which must be there, or else all that there are.
    pub(super) fn frames(&self, wanted: Option<&Frames>) -> Result<Vec<u32>, Failure> {
        match wanted {
            Some(Frames(wanted)) => self.check(wanted).map(|()| wanted.clone()),
            None => match self.there()? {
                there if there.is_empty() => Err(self.failure("no file has such a name")),
                there => Ok(there.into_iter().collect()),
            },
        }
    }

    /// Makes sure that every one of these frames is there.
    pub(super) fn check(&self, wanted: &[u32]) -> Result<(), Failure> {
        let there = self.there()?;
        let missing: Vec<_> = wanted.iter().copied().filter(|f| !there.contains(f)).collect();
        match missing.as_slice() {
            [] => Ok(()),
            [one] => Err(self.failure(&format!("frame {one} is missing"))),
            _ => Err(self.failure(&format!("frames {} are missing", frames::shown(&missing)))),
        }
    }

    fn there(&self) -> Result<BTreeSet<u32>, Failure> {
        let folder = self.path.parent().filter(|parent| *parent != Path::new(""));
        let frame = |entry: io::Result<fs::DirEntry>| {
            entry.map(|entry| self.pattern.frame(entry.file_name().to_str()?)).transpose()
        };
        let entries = fs::read_dir(folder.unwrap_or(Path::new(".")));
        let frames = entries.and_then(|entries| entries.filter_map(frame).collect());
        frames.map_err(|error| self.failure(&format!("its folder cannot be read: {error}")))
    }

    fn failure(&self, what: &str) -> Failure {
        Failure::Work(format!("{}: {what}", self.path.display()))
    }
}
