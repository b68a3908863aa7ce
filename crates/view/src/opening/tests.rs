//! What is shown in the end, whatever order files arrive in.

use std::sync::mpsc::{Sender, channel};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::*;
use crate::commands::{act, catch_up};
use crate::state::keys::Action;

/// A session without a window, and a folder of pictures.
struct Room {
    folder: tempfile::TempDir,
    session: Session,
}

impl Room {
    /// Opens `a.png` and creates `b.png`, `f.1.png` and `f.2.png`.
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

    /// Name and width of the open file.
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

    /// Waits until all files are read, but leaves the reports unprocessed.
    fn read_all(&self) {
        self.hold().send(()).unwrap();
        let (sender, end) = channel();
        self.session.in_background(move || {
            sender.send(()).unwrap();
            Report::Nothing
        });
        end.recv().unwrap();
    }

    /// Blocks the file thread until the sender sends or is dropped.
    fn hold(&self) -> Sender<()> {
        let (sender, go) = channel::<()>();
        self.session.in_background(move || {
            let _ = go.recv();
            Report::Nothing
        });
        sender
    }

    /// Watches `a.png`, has it rewritten, and waits until the change is noticed.
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
    for is_canceled in [true, false] {
        let mut room = Room::new();
        let held = room.hold();
        room.open("missing.png");
        room.rewrite_watched(larger);
        if is_canceled {
            room.cancel();
        }
        drop(held);
        room.wait_for(|session| session.opened().unwrap().size()[0] == 32);
    }
}

#[test]
fn a_version_that_is_broken_or_canceled_is_not_read_again() {
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
