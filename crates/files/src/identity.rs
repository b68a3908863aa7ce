//! Telling whether two paths lead to the same file.

use std::fs;
use std::path::{Path, PathBuf};

/// A file, whatever name or link leads to it. A file that does not exist yet is its place.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Identity {
    /// The device, and the inode number on it, which all hard links share.
    #[cfg(unix)]
    Number(u64, u64),
    /// Its absolute path.
    Place(PathBuf),
}

impl Identity {
    /// Follows links; a file that does not exist yet is identified by its folder and name.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        #[cfg(unix)]
        if let Ok(metadata) = fs::metadata(path) {
            use std::os::unix::fs::MetadataExt;
            return Self::Number(metadata.dev(), metadata.ino());
        }
        Self::Place(fs::canonicalize(path).unwrap_or_else(|_| {
            let parent = folder(path);
            let parent = fs::canonicalize(parent).unwrap_or_else(|_| parent.to_path_buf());
            parent.join(path.file_name().unwrap_or_default())
        }))
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
}
