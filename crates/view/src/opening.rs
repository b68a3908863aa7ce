//! Opening files on a thread of their own. The latest wish wins: what was asked for earlier, or was
//! cancelled, is not shown however late it arrives. What is open stays until the other file is read.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use wgdenoise::Image;
use wgdenoise_files::escaped;

use crate::gpu::host::Gpu;
use crate::gpu::texture::Texture;
use crate::open::{Opened, Wish, sentence};
use crate::session::Session;
use crate::state::pending::Reading;
use crate::state::sequence::Sequence;
use crate::state::settings::listed;
use crate::state::settling::Stamp;
use crate::work::{Loaded, Reference, Report};

impl Session {
    pub(crate) fn is_opening(&self) -> bool {
        self.opening.name().is_some()
    }

    /// Opens the first of these files; the arrow keys lead to the others, or to the other frames.
    pub(crate) fn open(&mut self, files: &[PathBuf]) {
        match Sequence::of(files) {
            Ok(Some(sequence)) => {
                let path = sequence.current().to_path_buf();
                self.read(&path, Some(sequence), Wish::default());
            }
            Ok(None) => {}
            Err(error) => self.fail(sentence(&error)),
        }
    }

    /// Reads the open file again, with another layer or view.
    pub(crate) fn choose(&mut self, wish: Wish) {
        if let Some(path) = self.opened().map(|opened| opened.path.clone()) {
            self.read(&path, self.sequence.clone(), wish);
        }
    }

    /// Reads the watched file again if it was written, once nothing else is being opened.
    pub(crate) fn read_version(&mut self) {
        let Some(watch) = self.watch.as_ref().filter(|_| !self.is_opening()) else { return };
        if let (path, version @ Some(_)) = (watch.path().to_path_buf(), watch.unread) {
            self.start(&path, self.sequence.clone(), self.wish.clone(), version);
        }
    }

    /// Reads a file that the user asks for, with its place among others.
    pub(crate) fn read(&mut self, path: &Path, sequence: Option<Sequence>, wish: Wish) {
        self.start(path, sequence, wish, None);
    }

    fn start(
        &mut self,
        path: &Path,
        sequence: Option<Sequence>,
        wish: Wish,
        version: Option<Stamp>,
    ) {
        let replaced = std::mem::replace(&mut self.sequence, sequence);
        let chosen = (replaced, std::mem::replace(&mut self.wish, wish.clone()));
        let before = self.opening.noisy.take().map_or(chosen, |reading| reading.before);
        self.opening.noisy = Some(Reading { name: name(path), version, before });
        let latest = self.opening.latest_noisy.clone();
        let (ticket, path, gpu) = (latest.next(), path.to_path_buf(), self.gpu.clone());
        self.in_background(move || {
            if latest.is(ticket) {
                Report::Opened(ticket, load(&gpu, &path, wish))
            } else {
                Report::Nothing
            }
        });
    }

    /// Reads a reference.
    pub(crate) fn read_reference(&mut self, path: &Path) {
        self.opening.reference = Some(name(path));
        let latest = self.opening.latest_reference.clone();
        let (ticket, path, gpu) = (latest.next(), path.to_path_buf(), self.gpu.clone());
        self.in_background(move || {
            if latest.is(ticket) {
                Report::Reference(ticket, load_reference(&gpu, path))
            } else {
                Report::Nothing
            }
        });
    }

    /// Leaves open what is open. Returns whether a file was being read.
    pub(crate) fn cancel_opening(&mut self) -> bool {
        let was_opening = self.is_opening();
        self.opening.latest_noisy.next();
        self.opening.latest_reference.next();
        self.opening.reference = None;
        if let Some(reading) = self.opening.noisy.take() {
            self.finish_version(reading.version);
            (self.sequence, self.wish) = reading.before;
        }
        was_opening
    }

    /// Shows a file that was read, unless it is no longer wanted.
    pub(crate) fn take_opened(&mut self, ticket: u64, loaded: Result<Loaded, String>) {
        if !self.opening.latest_noisy.is(ticket) {
            return;
        }
        let Some(reading) = self.opening.noisy.take() else { return };
        self.finish_version(reading.version);
        match loaded {
            Ok(loaded) => {
                self.show(loaded);
                self.denoise();
                self.compare();
            }
            Err(error) => {
                let (sequence, wish) = reading.before;
                let files = |s: &Option<Sequence>| s.as_ref().map(|s| s.files().to_vec());
                // Past a broken frame, the arrow keys lead on.
                if files(&sequence) != files(&self.sequence) {
                    self.sequence = sequence;
                }
                self.wish = wish;
                self.fail(error);
            }
        }
    }

    fn show(&mut self, loaded: Loaded) {
        let size = self.opened().map(|opened| opened.size());
        if size != Some(loaded.opened.size()) {
            self.transform.fit();
        }
        let wish = &loaded.opened.wish;
        if wish.color.is_none() {
            self.colors = loaded.opened.colors();
        }
        if self.opened().is_none_or(|opened| opened.wish.layers != wish.layers) {
            self.patterns = wish.layers.as_ref().map(listed).unwrap_or_default();
        }
        self.finish_version(loaded.opened.stamp);
        let with = self.sequence.as_ref().map(Sequence::files).unwrap_or_default();
        self.recent.add(&loaded.opened.path, with, &self.desk);
        self.loaded = Some(loaded);
        (self.denoised, self.figures, self.message) = (None, None, None);
    }

    /// Takes a reference that was read, unless it is no longer wanted.
    pub(crate) fn take_reference(&mut self, ticket: u64, reference: Result<Reference, String>) {
        if !self.opening.latest_reference.is(ticket) {
            return;
        }
        self.opening.reference = None;
        match reference {
            Ok(reference) => {
                (self.reference, self.message) = (Some(reference), None);
                self.compare();
                if let Some(why) = self.misfit() {
                    self.fail(why);
                }
            }
            Err(error) => self.fail(error),
        }
    }

    fn finish_version(&mut self, version: Option<Stamp>) {
        if let Some(watch) = &mut self.watch {
            watch.finish(version);
        }
    }
}

/// A file's name for the window.
fn name(path: &Path) -> String {
    escaped(&path.file_name().unwrap_or_default().to_string_lossy())
}

fn load(gpu: &Gpu, path: &Path, wish: Wish) -> Result<Loaded, String> {
    let opened = Opened::noisy(path, wish)?;
    let view = opened.view();
    let upload = |image: Option<&Image>| image.map(|i| Texture::upload(gpu, i)).transpose();
    let noisy = Texture::upload(gpu, view.color())?;
    let (albedo, normal) = (upload(view.albedo())?, upload(view.normal())?);
    Ok(Loaded { opened: Arc::new(opened), noisy, albedo, normal })
}

fn load_reference(gpu: &Gpu, path: PathBuf) -> Result<Reference, String> {
    let opened = Opened::reference(&path)?;
    let image = opened.view().color();
    let texture = Texture::upload(gpu, image)?;
    Ok(Reference { image: Arc::new(image.clone()), texture, path })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use super::*;
    use crate::commands::{act, catch_up};
    use crate::state::keys::Action;

    /// A session without a window, with pictures in a folder.
    struct Room {
        folder: tempfile::TempDir,
        session: Session,
    }

    impl Room {
        /// Has `a.png` open and knows `b.png`, `f.1.png` and `f.2.png`.
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let session = Session::new(Gpu::for_tests(), || {});
            let mut room = Self { folder, session };
            for name in ["a.png", "b.png", "f.1.png", "f.2.png"] {
                room.write(name, 16);
            }
            room.open("a.png");
            room.wait_for(|session| !session.is_opening());
            room
        }

        fn path(&self, name: &str) -> PathBuf {
            self.folder.path().join(name)
        }

        fn write(&self, name: &str, side: u32) {
            image::RgbImage::new(side, side).save(self.path(name)).unwrap();
        }

        fn open(&mut self, name: &str) {
            self.session.open(&[self.path(name)]);
        }

        fn cancel(&mut self) {
            act(&mut self.session, Action::Cancel);
        }

        /// The name and the width of what is open.
        fn shown(&self) -> (String, u32) {
            let opened = self.session.opened().unwrap();
            (opened.name(), opened.size()[0])
        }

        fn wait_for(&mut self, is_so: impl Fn(&Session) -> bool) {
            let start = Instant::now();
            while !is_so(&self.session) {
                assert!(start.elapsed() < Duration::from_mins(1), "{:?}", self.session.message);
                sleep(Duration::from_millis(5));
                catch_up(&mut self.session);
            }
        }

        /// Waits until all files are read, and leaves the reports of that unread.
        fn read_all(&self) {
            self.hold().send(()).unwrap();
            let (sender, end) = channel();
            self.session.in_background(move || {
                sender.send(()).unwrap();
                Report::Nothing
            });
            end.recv().unwrap();
        }

        /// Keeps the files' thread from reading until the sender sends or is gone.
        fn hold(&self) -> Sender<()> {
            let (sender, go) = channel::<()>();
            self.session.in_background(move || {
                let _ = go.recv();
                Report::Nothing
            });
            sender
        }

        /// Watches `a.png`, which the renderer then writes anew, and waits until that is noticed.
        fn rewrite_watched(&mut self, write: impl Fn(&Self)) {
            act(&mut self.session, Action::Watch);
            write(self);
            self.wait_for(|session| unread(session).is_some());
        }
    }

    fn unread(session: &Session) -> Option<Stamp> {
        session.watch.as_ref()?.unread
    }

    fn larger(room: &Room) {
        room.write("a.png", 32);
    }

    #[test]
    fn a_file_that_is_read_after_escape_is_not_shown() {
        let mut room = Room::new();
        room.open("f.2.png");
        room.read_all();
        room.cancel();
        catch_up(&mut room.session);
        assert_eq!(room.shown().0, "a.png");
        assert!(!room.session.is_opening());
        let sequence = room.session.sequence.as_ref().unwrap();
        assert_eq!(sequence.files(), [room.path("a.png")], "the arrow keys belong to a.png");
        assert_eq!(room.session.message.as_ref().unwrap().text, "canceled");
    }

    #[test]
    fn escape_returns_to_the_frame_and_the_choices_that_are_shown() {
        let mut room = Room::new();
        room.open("f.1.png");
        room.wait_for(|session| !session.is_opening());
        let held = room.hold();
        act(&mut room.session, Action::Step(1));
        room.open("b.png");
        room.session.choose(Wish { color: Some("none".into()), ..Wish::default() });
        room.cancel();
        drop(held);
        room.read_all();
        catch_up(&mut room.session);
        assert_eq!(room.shown().0, "f.1.png");
        let sequence = room.session.sequence.as_ref().unwrap();
        assert_eq!(sequence.current(), room.path("f.1.png"));
        assert_eq!(room.session.wish.color, None);
    }

    #[test]
    fn escape_leaves_the_reference_that_is_open() {
        let mut room = Room::new();
        room.session.read_reference(&room.path("b.png"));
        room.read_all();
        room.cancel();
        catch_up(&mut room.session);
        assert!(room.session.reference.is_none());
    }

    #[test]
    fn the_file_that_was_asked_for_last_is_shown() {
        let mut room = Room::new();
        for name in ["f.1.png", "b.png"] {
            room.open(name);
            room.read_all();
        }
        catch_up(&mut room.session);
        assert_eq!(room.shown().0, "b.png");
    }

    #[test]
    fn a_watched_file_never_replaces_one_that_the_user_opens() {
        for is_read_first in [true, false] {
            let mut room = Room::new();
            if is_read_first {
                room.rewrite_watched(larger);
                room.read_all();
            }
            let held = room.hold();
            room.open("b.png");
            if !is_read_first {
                room.rewrite_watched(larger);
            }
            catch_up(&mut room.session);
            assert_eq!(room.shown(), ("a.png".into(), 16), "what was open stays until then");
            drop(held);
            room.wait_for(|session| !session.is_opening());
            room.read_all();
            catch_up(&mut room.session);
            assert_eq!(room.shown().0, "b.png");
        }
    }

    #[test]
    fn a_version_that_had_to_wait_is_read_when_nothing_else_is_opened() {
        for is_cancelled in [true, false] {
            let mut room = Room::new();
            let held = room.hold();
            room.open("missing.png");
            room.rewrite_watched(larger);
            if is_cancelled {
                room.cancel();
            }
            drop(held);
            room.wait_for(|session| session.opened().unwrap().size()[0] == 32);
        }
    }

    #[test]
    fn a_version_that_is_broken_or_cancelled_is_not_read_again() {
        let mut room = Room::new();
        room.rewrite_watched(|room| std::fs::write(room.path("a.png"), "broken").unwrap());
        room.wait_for(|session| session.message.as_ref().is_some_and(|m| m.is_error));
        assert!(unread(&room.session).is_none() && !room.session.is_opening());
        let mut room = Room::new();
        let held = room.hold();
        room.rewrite_watched(larger);
        room.cancel();
        drop(held);
        catch_up(&mut room.session);
        assert!(unread(&room.session).is_none() && !room.session.is_opening());
        assert_eq!(room.shown(), ("a.png".into(), 16));
    }

    #[test]
    fn arrow_keys_lead_past_a_broken_frame_and_other_files_leave_the_place() {
        let mut room = Room::new();
        room.open("f.1.png");
        room.wait_for(|session| !session.is_opening());
        std::fs::write(room.path("f.2.png"), "broken").unwrap();
        act(&mut room.session, Action::Step(1));
        room.wait_for(|session| !session.is_opening());
        assert_eq!(room.session.sequence.as_ref().unwrap().at(), 1);
        room.open("missing.png");
        room.wait_for(|session| !session.is_opening());
        assert_eq!(room.session.sequence.as_ref().unwrap().len(), 2);
    }
}
