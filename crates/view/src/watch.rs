//! Watches a file that a renderer rewrites.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use notify::{RecommendedWatcher, RecursiveMode, Watcher as _};
use wgdenoise_files::escaped;

use crate::state::settling::{Settling, Stamp};
use crate::work::{Desk, Report};

/// Polling interval while a file is being written.
const SOON: Duration = Duration::from_millis(100);

/// Polling interval without events, which network drives do not send.
const SELDOM: Duration = Duration::from_secs(2);

/// A watched file. Dropping it ends the watch.
pub(crate) struct Watch {
    path: PathBuf,
    /// A completed version, waiting to be read.
    pub(crate) unread: Option<Stamp>,
    _watcher: RecommendedWatcher,
}

impl Watch {
    /// Starts to report [`Report::Changed`] for every version after the one that was read.
    ///
    /// # Errors
    /// If the system cannot watch the file's folder.
    pub(crate) fn start(path: &Path, read: Option<Stamp>, desk: Desk) -> Result<Self, String> {
        let (sender, events) = channel();
        let folder = path.parent().filter(|parent| *parent != Path::new(""));
        let wake = move |_| {
            // Fails if the watch has ended.
            let _ = sender.send(());
        };
        let watching = || {
            let mut watcher = notify::recommended_watcher(wake)?;
            // A renderer may replace the file; only its folder reports that.
            watcher.watch(folder.unwrap_or(Path::new(".")), RecursiveMode::NonRecursive)?;
            Ok(watcher)
        };
        let watcher = watching().map_err(|error: notify::Error| {
            format!("{}: cannot be watched: {error}", escaped(&path.to_string_lossy()))
        })?;
        let (watched, settling) = (path.to_path_buf(), Settling::new(read));
        thread::spawn(move || run(&watched, settling, &events, &desk));
        Ok(Self { path: path.to_path_buf(), unread: None, _watcher: watcher })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Notes that a version was read or skipped.
    pub(crate) fn finish(&mut self, version: Option<Stamp>) {
        self.unread = self.unread.filter(|unread| version != Some(*unread));
    }
}

/// Checks the file after every event until the watcher is gone.
fn run(path: &Path, mut settling: Settling, events: &Receiver<()>, desk: &Desk) {
    loop {
        let wait = if settling.is_waiting() { SOON } else { SELDOM };
        if events.recv_timeout(wait) == Err(RecvTimeoutError::Disconnected) {
            return;
        }
        if let Some(version) = settling.look(Instant::now(), Stamp::of(path)) {
            desk.report(Report::Changed(path.to_path_buf(), version));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rewritten_file_is_reported_once_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("render.exr");
        std::fs::write(&path, "first").unwrap();
        let (sender, reports) = channel();
        let watch = Watch::start(&path, Stamp::of(&path), Desk::new(sender, || {})).unwrap();
        for part in ["s", "sec", "second"] {
            std::fs::write(&path, part).unwrap();
            thread::sleep(Duration::from_millis(150));
        }
        let start = Instant::now();
        assert!(matches!(reports.recv_timeout(Duration::from_secs(10)), Ok(Report::Changed(..))));
        assert!(start.elapsed() > Duration::from_millis(100), "it was read while it was written");
        assert!(reports.recv_timeout(Duration::from_secs(1)).is_err(), "it was reported twice");
        drop(watch);
    }

    #[test]
    fn a_folder_that_is_gone_is_one_sentence() {
        let (sender, _reports) = channel();
        let error = Watch::start(Path::new("/nowhere/a.exr"), None, Desk::new(sender, || {}));
        assert!(error.err().unwrap().starts_with("/nowhere/a.exr: cannot be watched: "));
    }
}
