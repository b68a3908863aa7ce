//! Whether two paths lead to the same file.

use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

/// A file, whatever name or link leads to it; a file that does not exist yet is its place.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Identity {
    /// The device, and the inode number on it, which all hard links share.
    #[cfg(unix)]
    Number(u64, u64),
    /// Its absolute path.
    Place(PathBuf),
}

impl Identity {
    /// Identifies the file at a path. Follows links; a file that does not exist yet is its place.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let path = place(path);
        #[cfg(unix)]
        if let Ok(metadata) = fs::metadata(&path) {
            use std::os::unix::fs::MetadataExt;
            return Self::Number(metadata.dev(), metadata.ino());
        }
        Self::Place(path)
    }
}

/// The absolute path of a file, with every link followed. Neither the file nor its folders need to
/// exist: the result stays the same when missing folders are created.
pub(crate) fn place(path: &Path) -> PathBuf {
    let missing = match fs::canonicalize(path) {
        Ok(place) => return place,
        Err(error) => error.kind() == ErrorKind::NotFound,
    };
    match fs::read_link(path) {
        // Other errors, such as a cycle of links, lead nowhere.
        Ok(target) if missing => place(&folder(path).join(target)),
        _ => place_in(place(folder(path)), path),
    }
}

/// The place of a path's last component in its folder.
fn place_in(folder: PathBuf, path: &Path) -> PathBuf {
    match path.components().next_back() {
        Some(Component::Normal(name)) => folder.join(name),
        Some(Component::ParentDir) => folder.parent().unwrap_or(&folder).to_path_buf(),
        _ => folder,
    }
}

/// The folder that a path is in.
pub(crate) fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_links_of_one_file_are_alike_and_others_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("inner")).unwrap();
        fs::write(at("a"), "").unwrap();
        fs::write(at("b"), "").unwrap();
        let of = |name: &str| Identity::of(&at(name));
        assert_eq!(of("a"), of("inner/../a"));
        assert_ne!(of("a"), of("b"));
        assert_eq!(of("new"), of("inner/../new"));
        assert_ne!(of("new"), of("newer"));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("a", at("soft")).unwrap();
            fs::hard_link(at("a"), at("hard")).unwrap();
            assert!(of("soft") == of("a") && of("hard") == of("a"));
        }
    }

    #[test]
    fn a_path_through_missing_folders_is_what_it_is_once_they_exist() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "").unwrap();
        let names = ["new/../a", "new/inner/../../a", "new/./b", "new/inner/../b"];
        let of = || names.map(|name| Identity::of(&at(name)));
        let before = of();
        assert!(before[0] == Identity::of(&at("a")) && before[1] == before[0]);
        assert!(before[2] == before[3] && before[2] != before[0]);
        fs::create_dir_all(at("new/inner")).unwrap();
        assert_eq!(of(), before);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_a_missing_file_is_its_target_and_a_circle_of_links_is_itself() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        symlink("missing/../new", at("link")).unwrap();
        symlink("link", at("second")).unwrap();
        symlink("circle", at("circle")).unwrap();
        let of = |name: &str| Identity::of(&at(name));
        assert!(of("link") == of("new") && of("second") == of("new"));
        assert!(of("circle") == of("circle") && of("circle") != of("new"));
    }
}
