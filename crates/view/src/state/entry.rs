//! An entry in the list of recent files.

use std::path::PathBuf;

/// A path, and whether the file existed when the list was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) path: PathBuf,
    pub(crate) exists: bool,
}
