//! The files that the arrow keys step through: frames of an animation, or files opened together.

use std::path::{Path, PathBuf};

use wgdenoise_files::FileError;
use wgdenoise_files::inputs::Source;

/// Ordered files, and the open one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sequence {
    files: Vec<PathBuf>,
    at: usize,
}

impl Sequence {
    /// Builds a sequence from several files as given, or from one with the other frames of its
    /// animation; `None` without a file. Patterns such as `beauty.####.exr` and `*.exr` expand as
    /// on the command line.
    ///
    /// # Errors
    /// If a pattern is invalid or matches no file.
    pub(crate) fn of(paths: &[PathBuf]) -> Result<Option<Self>, FileError> {
        let found = paths.iter().map(|path| expanded(path)).collect::<Result<Vec<_>, _>>()?;
        Ok(match found.concat().as_slice() {
            [] => None,
            [one] => Some(Self::around(one)),
            several => Some(Self { files: several.to_vec(), at: 0 }),
        })
    }

    /// A file with those in its folder that differ only in the frame number.
    fn around(path: &Path) -> Self {
        let folder = path.parent().filter(|parent| *parent != Path::new(""));
        let entries = std::fs::read_dir(folder.unwrap_or(Path::new(".")));
        let entries = entries.into_iter().flatten().flatten();
        let names: Vec<_> =
            entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        let own = path.file_name().and_then(|name| name.to_str());
        let frames = own.map(|own| frames(own, &names)).unwrap_or_default();
        let files: Vec<_> = frames.iter().map(|name| path.with_file_name(name)).collect();
        let alone = || Self { files: vec![path.to_path_buf()], at: 0 };
        files.iter().position(|file| file == path).map_or_else(alone, |at| Self { files, at })
    }

    pub(crate) fn files(&self) -> &[PathBuf] {
        &self.files
    }

    pub(crate) fn current(&self) -> &Path {
        &self.files[self.at]
    }

    /// Index of the open file.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    pub(crate) fn len(&self) -> usize {
        self.files.len()
    }

    /// Goes to a file by index, clamped to the ends. Returns whether it is another one.
    pub(crate) fn go(&mut self, to: usize) -> bool {
        let before = std::mem::replace(&mut self.at, to.min(self.files.len() - 1));
        before != self.at
    }

    /// Steps forward or back by this many files.
    pub(crate) fn step(&mut self, by: isize) -> bool {
        self.go(self.at.saturating_add_signed(by))
    }
}

/// Expands a path or pattern to files.
fn expanded(path: &Path) -> Result<Vec<PathBuf>, FileError> {
    match Source::of(path)? {
        Source::File(path) => Ok(vec![path]),
        several => Ok(several.files(None)?.into_iter().map(|(path, _)| path).collect()),
    }
}

/// The names that differ from `own` only in the last number, ordered by that number.
fn frames(own: &str, names: &[String]) -> Vec<String> {
    let Some((prefix, digits, suffix)) = split(own) else { return vec![own.into()] };
    let number = |name: &str| {
        let found = name.strip_prefix(prefix)?.strip_suffix(suffix)?;
        let is_number = !found.is_empty() && found.bytes().all(|b| b.is_ascii_digit());
        // Padded numbers have the same length; unpadded ones grow.
        let fits = found.len() == digits.len()
            || !(found.starts_with('0') || digits.starts_with('0')) && found.len() <= MOST_DIGITS;
        (is_number && fits).then(|| found.parse::<u128>().ok()).flatten()
    };
    let mut found: Vec<_> =
        names.iter().filter_map(|name| Some((number(name)?, name.clone()))).collect();
    found.sort();
    found.into_iter().map(|(_, name)| name).collect()
}

/// No frame number is longer; more digits are a date or a hash.
const MOST_DIGITS: usize = 10;

/// Splits a name without its extension around its last number: prefix, digits, suffix.
fn split(name: &str) -> Option<(&str, &str, &str)> {
    let stem = name.rfind('.').filter(|&dot| dot > 0).unwrap_or(name.len());
    let end = name[..stem].rfind(|c: char| c.is_ascii_digit())? + 1;
    let before = name[..end].trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = &name[before.len()..end];
    (digits.len() <= MOST_DIGITS).then_some((before, digits, &name[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(own: &str, names: &[&str]) -> Vec<String> {
        frames(own, &names.iter().map(ToString::to_string).collect::<Vec<_>>())
    }

    #[test]
    fn frames_are_the_files_that_differ_in_the_last_number() {
        let names =
            ["b.0002.exr", "b.0001.exr", "b.0010.exr", "b.00011.exr", "b.0003.png", "a.0001.exr"];
        assert_eq!(found("b.0002.exr", &names), ["b.0001.exr", "b.0002.exr", "b.0010.exr"]);
        assert_eq!(found("b8_v2.exr", &["b8_v1.exr", "b9_v2.exr", "b8_v2.exr"]).len(), 2);
    }

    #[test]
    fn numbers_without_padding_are_ordered_by_value() {
        let names = ["f10.exr", "f9.exr", "f1.exr", "f02.exr"];
        assert_eq!(found("f9.exr", &names), ["f1.exr", "f9.exr", "f10.exr"]);
    }

    #[test]
    fn names_without_a_number_or_with_a_hash_stand_alone() {
        let hash = "x12345678901234567890.exr";
        for name in ["beauty.exr", ".exr", hash, "größe.exr"] {
            assert_eq!(found(name, &["other1.exr"]), [name]);
        }
    }

    #[test]
    fn steps_end_at_the_ends() {
        let files = ["a", "b", "c"].map(PathBuf::from);
        let mut sequence = Sequence::of(&files).unwrap().unwrap();
        assert!(!sequence.step(-1) && sequence.step(1) && sequence.step(5));
        assert_eq!((sequence.current(), sequence.at()), (Path::new("c"), 2));
        assert!(sequence.go(0) && !sequence.go(0));
        assert_eq!(Sequence::of(&[]).unwrap(), None);
    }

    #[test]
    fn a_file_of_a_folder_finds_its_neighbors() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["s.0001.exr", "s.0002.exr", "s.0003.exr", "other.exr"] {
            std::fs::write(path(name), "").unwrap();
        }
        let sequence = Sequence::of(&[path("s.0002.exr")]).unwrap().unwrap();
        assert_eq!((sequence.len(), sequence.at()), (3, 1));
        let missing = path("none.0001.exr");
        let alone = Sequence::of(std::slice::from_ref(&missing)).unwrap().unwrap();
        assert_eq!(alone.current(), missing);
    }

    #[test]
    fn patterns_stand_for_the_files_that_the_command_line_finds() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["s.0010.exr", "s.0002.exr", "s.1.exr", "t.exr"] {
            std::fs::write(path(name), "").unwrap();
        }
        let found = |name: &str| Sequence::of(&[path(name)]).map(|s| s.unwrap().files);
        let frames = ["s.0002.exr", "s.0010.exr"].map(path).to_vec();
        assert_eq!(found("s.####.exr").unwrap(), frames);
        assert_eq!(found("s.%04d.exr").unwrap(), frames);
        assert_eq!(found("*.exr").unwrap().len(), 4);
        let none = found("none.####.exr").unwrap_err().to_string();
        assert!(none.ends_with("matches no file"), "{none}");
        let two = found("s.##.##.exr").unwrap_err().to_string();
        assert!(two.contains("two places for a frame number"), "{two}");
    }
}
