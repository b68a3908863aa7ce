//! Which of several wishes is the latest.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The ticket of the latest wish. Threads compare it with theirs, so that older work is skipped.
#[derive(Clone, Debug, Default)]
pub(crate) struct Latest(Arc<AtomicU64>);

impl Latest {
    /// A ticket for a new wish.
    pub(crate) fn next(&self) -> u64 {
        self.0.fetch_add(1, Ordering::Relaxed) + 1
    }

    pub(crate) fn current(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    pub(crate) fn is(&self, ticket: u64) -> bool {
        self.current() == ticket
    }
}
