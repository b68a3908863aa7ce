//! The files that are being read, and what to go back to if they are not wanted after all.

use crate::open::Wish;
use crate::state::latest::Latest;
use crate::state::sequence::Sequence;
use crate::state::settling::Stamp;

/// The files that are being read.
#[derive(Debug, Default)]
pub(crate) struct Pending {
    pub(crate) noisy: Option<Reading>,
    pub(crate) latest_noisy: Latest,
    /// The name of the reference that is being read.
    pub(crate) reference: Option<String>,
    pub(crate) latest_reference: Latest,
}

/// A noisy image that is being read.
#[derive(Debug)]
pub(crate) struct Reading {
    pub(crate) name: String,
    /// The version of the watched file; `None` if the user opens the file.
    pub(crate) version: Option<Stamp>,
    /// The choices that belong to what is open, to go back to.
    pub(crate) before: (Option<Sequence>, Wish),
}

impl Pending {
    /// The name of a file that is being read.
    pub(crate) fn name(&self) -> Option<&str> {
        self.noisy.as_ref().map(|reading| &reading.name).or(self.reference.as_ref()).map(|n| &**n)
    }
}
