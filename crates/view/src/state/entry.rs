//! A file among those that were opened last.

use std::path::PathBuf;

/// Its path, and whether it was there when the list was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) path: PathBuf,
    pub(crate) exists: bool,
}
