//! Drags a file onto a window and drops it there, as a file manager does, by version 5 of the XDND
//! protocol (<https://freedesktop.org/wiki/Specifications/XDND>).

use std::fmt::Write as _;
use std::path::Path;

use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConnectionExt as _, EventMask, PropMode, SELECTION_NOTIFY_EVENT,
    SelectionNotifyEvent, SelectionRequestEvent, Window,
};
use x11rb::wrapper::ConnectionExt as _;

use crate::display::Display;

/// The format in which files are offered.
const KIND: &str = "text/uri-list";

/// The window that files are dragged from.
struct Source<'a> {
    display: &'a Display,
    window: Window,
    list: String,
}

/// Drops a file on a window; returns whether the window accepted it.
pub(crate) fn drop_file(display: &Display, onto: Window, file: &Path) -> bool {
    let source = Source { display, window: display.hidden_window(), list: uri(file) + "\r\n" };
    let (own, selection) = (source.window, display.atom("XdndSelection"));
    let owned = display.connection.set_selection_owner(own, selection, x11rb::CURRENT_TIME);
    owned.unwrap().check().unwrap();
    source.is_wanted(onto) && source.drop(onto)
}

impl Source<'_> {
    /// Moves over the window, which requests the list and answers whether it would accept it.
    fn is_wanted(&self, onto: Window) -> bool {
        const VERSION: u32 = 5 << 24;
        let (own, atom) = (self.window, |name| self.display.atom(name));
        self.display.send(onto, "XdndEnter", [own, VERSION, atom(KIND), 0, 0]);
        // x and y, 16 bits each.
        let (at, copy) = (0x0190_0190, atom("XdndActionCopy"));
        self.display.send(onto, "XdndPosition", [own, 0, at, x11rb::CURRENT_TIME, copy]);
        let [mut is_asked, mut is_wanted] = [false; 2];
        while !(is_asked && is_wanted) {
            match self.next() {
                Event::SelectionRequest(request) => {
                    self.give(&request);
                    is_asked = true;
                }
                Event::ClientMessage(status) if is_yes(&status) => is_wanted = true,
                Event::ClientMessage(_) => return false,
                _ => {}
            }
        }
        true
    }

    fn drop(&self, onto: Window) -> bool {
        self.display.send(onto, "XdndDrop", [self.window, 0, x11rb::CURRENT_TIME, 0, 0]);
        let finished = self.display.atom("XdndFinished");
        loop {
            if let Event::ClientMessage(end) = self.next()
                && end.type_ == finished
            {
                return is_yes(&end);
            }
        }
    }

    fn next(&self) -> Event {
        Display::wait_for("an answer", || self.display.connection.poll_for_event().unwrap())
    }

    /// Sends the list of files.
    fn give(&self, request: &SelectionRequestEvent) {
        let connection = &self.display.connection;
        let &SelectionRequestEvent { requestor, selection, target, property, time, .. } = request;
        let list = self.list.as_bytes();
        connection.change_property8(PropMode::REPLACE, requestor, property, target, list).unwrap();
        let told = SelectionNotifyEvent {
            response_type: SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time,
            requestor,
            selection,
            target,
            property,
        };
        connection.send_event(false, requestor, EventMask::NO_EVENT, told).unwrap();
        connection.flush().unwrap();
    }
}

/// Whether the window accepts the drop.
fn is_yes(answer: &ClientMessageEvent) -> bool {
    answer.data.as_data32()[1] & 1 == 1
}

/// The path as a URI.
fn uri(path: &Path) -> String {
    let path = std::path::absolute(path).unwrap();
    let mut uri = String::from("file://");
    for byte in path.to_string_lossy().bytes() {
        if byte.is_ascii_alphanumeric() || b"/.-_".contains(&byte) {
            uri.push(byte.into());
        } else {
            let _ = write!(uri, "%{byte:02X}");
        }
    }
    uri
}
