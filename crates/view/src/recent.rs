//! The recently opened files, kept in a small text file in the user's configuration folder. If that
//! file cannot be read or written, the list is shorter; nothing else fails.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::thread;

use etcetera::BaseStrategy;
use wgdenoise_files::{Out, Problem, replace};

use crate::state::entry::Entry;
use crate::work::{Desk, Report};

/// Maximum length of the list.
const MOST: usize = 10;

/// A longer file is not the list.
const MOST_BYTES: u64 = 1 << 16;

/// The list, latest file first, and the file that stores it.
#[derive(Debug, Default)]
pub(crate) struct Recent {
    pub(crate) entries: Vec<Entry>,
    store: Option<PathBuf>,
}

/// `wgdenoise/recent` in the user's configuration folder; `None` if the user has no home.
pub(crate) fn store_of_user() -> Option<PathBuf> {
    let folders = etcetera::base_strategy::choose_native_strategy().ok()?;
    Some(folders.config_dir().join("wgdenoise").join("recent"))
}

impl Recent {
    /// Creates an empty list stored in this file, and reports the file's entries.
    pub(crate) fn kept_in(store: Option<PathBuf>, desk: &Desk) -> Self {
        let recent = Self { entries: Vec::new(), store };
        recent.update(desk, |_| {});
        recent
    }

    /// Puts a file first and reports the list. Other files opened with it, such as the frames of an
    /// animation, are removed.
    pub(crate) fn add(&self, path: &Path, with: &[PathBuf], desk: &Desk) {
        let Ok(path) = std::path::absolute(path) else { return };
        let with: Vec<_> = with.iter().flat_map(std::path::absolute).collect();
        self.update(desk, move |list| put_first(list, path, &with));
    }

    /// Empties the list.
    pub(crate) fn clear(&self, desk: &Desk) {
        self.update(desk, Vec::clear);
    }

    /// Runs on its own thread, because checking files on a network drive can be slow.
    fn update(&self, desk: &Desk, change: impl FnOnce(&mut Vec<PathBuf>) + Send + 'static) {
        let Some(store) = self.store.clone() else { return };
        let desk = desk.clone();
        thread::spawn(move || {
            let before = read(&store);
            let mut list = before.clone();
            change(&mut list);
            if list != before {
                write(&store, &list);
            }
            let entry = |path: PathBuf| Entry { exists: path.is_file(), path };
            desk.report(Report::Recent(list.into_iter().map(entry).collect()));
        });
    }
}

fn put_first(list: &mut Vec<PathBuf>, path: PathBuf, with: &[PathBuf]) {
    list.retain(|other| *other != path && !with.contains(other));
    list.insert(0, path);
    list.truncate(MOST);
}

/// Reads one path per line; none if the file is missing or is not a list.
fn read(store: &Path) -> Vec<PathBuf> {
    let is_short = fs::metadata(store).is_ok_and(|m| m.is_file() && m.len() <= MOST_BYTES);
    let text = if is_short { fs::read_to_string(store).unwrap_or_default() } else { String::new() };
    let paths = text.lines().map(PathBuf::from).filter(|path| path.is_absolute());
    paths.take(MOST).collect()
}

/// Replaces the file. Skips paths that do not fit on a line of text.
fn write(store: &Path, list: &[PathBuf]) {
    let lines = list.iter().filter_map(|path| path.to_str()).filter(|path| !path.contains('\n'));
    let text = lines.fold(String::new(), |text, line| text + line + "\n");
    let write = |out: &mut Out<'_>| out.write_all(text.as_bytes()).map_err(Problem::Write);
    let _ = store.parent().map(fs::create_dir_all);
    let _ = replace(store, true, write);
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, channel};

    use super::*;

    fn next(reports: &Receiver<Report>) -> Vec<(String, bool)> {
        let Report::Recent(entries) = reports.recv().unwrap() else { panic!("another report") };
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        entries.iter().map(|entry| (name(&entry.path), entry.exists)).collect()
    }

    #[test]
    fn files_are_kept_the_last_one_first_and_missing_ones_are_known() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("b.exr"), "").unwrap();
        let (sender, reports) = channel();
        let desk = Desk::new(sender, || {});
        let store = path("settings/recent");
        let recent = Recent::kept_in(Some(store.clone()), &desk);
        assert_eq!(next(&reports), []);
        for name in ["a.exr", "b.exr", "a.exr"] {
            recent.add(&path(name), &[], &desk);
            next(&reports);
        }
        Recent::kept_in(Some(store), &desk);
        assert_eq!(next(&reports), [("a.exr".into(), false), ("b.exr".into(), true)]);
        (0..20).for_each(|i| {
            recent.add(&path(&format!("{i}.exr")), &[], &desk);
            assert!(next(&reports).len() <= MOST);
        });
        recent.clear(&desk);
        assert_eq!(next(&reports), []);
    }

    #[test]
    fn a_sequence_takes_one_place_on_the_list() {
        let mut list = ["/other.exr", "/f.1.exr"].map(PathBuf::from).to_vec();
        let frames = ["/f.1.exr", "/f.2.exr"].map(PathBuf::from);
        put_first(&mut list, frames[1].clone(), &frames);
        assert_eq!(list, ["/f.2.exr", "/other.exr"].map(PathBuf::from));
    }

    #[test]
    fn a_damaged_list_is_an_empty_one_and_cannot_stop_anything() {
        let folder = tempfile::tempdir().unwrap();
        let store = folder.path().join("recent");
        for damaged in [&b"\xff\xfe"[..], b"no path\n\n../b\n", &vec![b'/'; 1 << 17]] {
            fs::write(&store, damaged).unwrap();
            assert_eq!(read(&store), Vec::<PathBuf>::new());
        }
        assert_eq!(read(folder.path()), Vec::<PathBuf>::new());
        write(folder.path(), &["/a".into()]);
        write(&store.join("below a file"), &["/a".into()]);
    }
}
