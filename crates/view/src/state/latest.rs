//! The latest of several requests.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The latest request's ticket. Threads compare it with theirs to skip older work.
#[derive(Clone, Debug, Default)]
pub(crate) struct Latest(Arc<AtomicU64>);

impl Latest {
    /// Issues a ticket for a new request.
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
