//! The files being read, and the state to restore if they are canceled.

use crate::open::Wish;
use crate::state::latest::Latest;
use crate::state::sequence::Sequence;
use crate::state::settling::Stamp;

/// The files being read.
#[derive(Debug, Default)]
pub(crate) struct Pending {
    pub(crate) noisy: Option<Reading>,
    pub(crate) latest_noisy: Latest,
    /// The name of the reference being read.
    pub(crate) reference: Option<String>,
    pub(crate) latest_reference: Latest,
}

/// A noisy image being read.
#[derive(Debug)]
pub(crate) struct Reading {
    pub(crate) name: String,
    /// The watched file's version; `None` if the user opened the file.
    pub(crate) version: Option<Stamp>,
    /// The open file's choices, to restore on failure.
    pub(crate) before: (Option<Sequence>, Wish),
}

impl Pending {
    /// The name of a file being read.
    pub(crate) fn name(&self) -> Option<&str> {
        self.noisy.as_ref().map(|reading| &reading.name).or(self.reference.as_ref()).map(|n| &**n)
    }
}
