//! Decides when a file that a renderer rewrites is complete.

use std::time::{Duration, Instant, SystemTime};

/// A file whose length and time stay the same for this long counts as written.
const QUIET: Duration = Duration::from_millis(400);

/// What identifies a version of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp {
    pub(crate) length: u64,
    pub(crate) modified: Option<SystemTime>,
}

impl Stamp {
    /// The stamp of a file; `None` if there is no file.
    pub(crate) fn of(path: &std::path::Path) -> Option<Self> {
        let metadata = path.metadata().ok()?;
        Some(Self { length: metadata.len(), modified: metadata.modified().ok() })
    }
}

/// Tracks the stamps of one file.
#[derive(Clone, Debug)]
pub(crate) struct Settling {
    /// The stamp of the version that was read.
    read: Option<Stamp>,
    /// The latest stamp, and when it first appeared.
    seen: Option<(Stamp, Instant)>,
}

impl Settling {
    /// Starts from the version that was read.
    pub(crate) fn new(read: Option<Stamp>) -> Self {
        Self { read, seen: None }
    }

    /// Whether a new version exists that may still be growing.
    pub(crate) fn is_waiting(&self) -> bool {
        self.seen.is_some()
    }

    /// Updates the file's current stamp. Returns a new version to read once it is not empty and has
    /// not changed for [`QUIET`]. Each version is returned once.
    pub(crate) fn look(&mut self, now: Instant, stamp: Option<Stamp>) -> Option<Stamp> {
        let Some(stamp) = stamp.filter(|stamp| stamp.length > 0 && self.read != Some(*stamp))
        else {
            self.seen = None;
            return None;
        };
        match self.seen {
            Some((seen, since)) if seen == stamp => {
                let is_quiet = now.duration_since(since) >= QUIET;
                if is_quiet {
                    *self = Self::new(Some(stamp));
                }
                is_quiet.then_some(stamp)
            }
            _ => {
                self.seen = Some((stamp, now));
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp(length: u64) -> Stamp {
        Stamp { length, modified: None }
    }

    #[test]
    fn a_growing_file_is_waited_for_and_reported_once() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let mut settling = Settling::new(Some(stamp(9)));
        let looks =
            [(0, 9), (100, 3), (400, 5), (700, 5), (900, 5), (1500, 5), (2000, 9), (2500, 9)];
        let found = looks.map(|(ms, length)| settling.look(at(ms), Some(stamp(length))).is_some());
        assert_eq!(found, [false, false, false, false, true, false, false, true]);
    }

    #[test]
    fn a_missing_or_empty_file_is_no_version() {
        let start = Instant::now();
        let mut settling = Settling::new(Some(stamp(9)));
        for (ms, stamp) in [(0, None), (1000, None), (2000, Some(stamp(0))), (3000, Some(stamp(0)))]
        {
            assert_eq!(settling.look(start + Duration::from_millis(ms), stamp), None);
        }
        let found = settling.look(start + Duration::from_secs(4), Some(stamp(9)));
        assert_eq!(found, None, "it was read before");
    }
}
