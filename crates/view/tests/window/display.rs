//! A screen without a monitor, with simulated keyboard and mouse.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use image::RgbImage;
use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, ImageFormat,
    InputFocus, Window, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

pub(crate) const SIZE: [u16; 2] = [1400, 900];

/// How long anything may take without a GPU.
const PATIENCE: Duration = Duration::from_mins(2);

/// Xvfb and a connection to it. Dropping it stops the server.
pub(crate) struct Display {
    server: Child,
    /// The display's name, such as `:1`.
    pub(crate) name: String,
    pub(crate) connection: RustConnection,
    root: Window,
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Display {
    /// Starts Xvfb on a free display.
    pub(crate) fn start() -> Self {
        let [width, height] = SIZE;
        let screen = format!("{width}x{height}x24");
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| {
                panic!("Xvfb cannot be started: {error}; .ci/install-display-server installs it")
            });
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let name = format!(":{}", number.trim());
        let (connection, screen) = x11rb::connect(Some(&name)).unwrap();
        let root = connection.setup().roots[screen].root;
        Self { server, name, connection, root }
    }

    /// Waits until `find` returns something.
    pub(crate) fn wait_for<T>(what: &str, mut find: impl FnMut() -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(found) = find() {
                return found;
            }
            assert!(start.elapsed() < PATIENCE, "{what} takes too long");
            sleep(Duration::from_millis(30));
        }
    }

    /// Finds the window whose title contains this word and gives it the keyboard focus.
    pub(crate) fn window(&self, word: &str) -> Window {
        Self::wait_for("the window", || {
            let tree = self.connection.query_tree(self.root).unwrap().reply().unwrap();
            let window = tree.children.into_iter().find(|&w| self.title(w).contains(word))?;
            let focus = InputFocus::POINTER_ROOT;
            let focused = self.connection.set_input_focus(focus, window, x11rb::CURRENT_TIME);
            focused.unwrap().check().ok().map(|()| window)
        })
    }

    pub(crate) fn title(&self, window: Window) -> String {
        let (name, kind) = (AtomEnum::WM_NAME, AtomEnum::ANY);
        let title = self.connection.get_property(false, window, name, kind, 0, 1 << 10).unwrap();
        title.reply().map_or_else(|_| String::new(), |t| String::from_utf8_lossy(&t.value).into())
    }

    /// A picture of the screen.
    pub(crate) fn picture(&self) -> RgbImage {
        let [width, height] = SIZE;
        let format = ImageFormat::Z_PIXMAP;
        let image = self.connection.get_image(format, self.root, 0, 0, width, height, !0);
        let data = image.unwrap().reply().unwrap().data;
        let rgb = data.chunks_exact(4).flat_map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect();
        RgbImage::from_raw(width.into(), height.into(), rgb).unwrap()
    }

    pub(crate) fn move_to(&self, [x, y]: [i16; 2]) {
        self.fake(MOTION, 0, [x, y]);
    }

    /// Turns the wheel away from the user by this many notches.
    pub(crate) fn wheel(&self, notches: usize) {
        const AWAY: u8 = 4;
        (0..notches).for_each(|_| self.stroke(BUTTON, &[AWAY]));
    }

    /// Presses a key with modifiers, such as `Ctrl+s`. Names are those of [`keysym`].
    pub(crate) fn press(&self, keys: &str) {
        let codes: Vec<_> = keys.split('+').map(|key| self.code(keysym(key)).0).collect();
        self.stroke(KEY, &codes);
        sleep(Duration::from_millis(40));
    }

    pub(crate) fn type_text(&self, text: &str) {
        let shift = self.code(keysym("Shift")).0;
        for symbol in text.chars() {
            match self.code(symbol as u32) {
                (code, false) => self.stroke(KEY, &[code]),
                (code, true) => self.stroke(KEY, &[shift, code]),
            }
        }
    }

    /// Runs `act` with a key held.
    pub(crate) fn holding(&self, key: &str, act: impl FnOnce()) {
        let code = self.code(keysym(key)).0;
        self.fake(KEY, code, [0; 2]);
        act();
        self.fake(KEY + 1, code, [0; 2]);
    }

    /// Presses in this order and releases in reverse.
    fn stroke(&self, pressed: u8, details: &[u8]) {
        for detail in details {
            self.fake(pressed, *detail, [0; 2]);
        }
        for detail in details.iter().rev() {
            self.fake(pressed + 1, *detail, [0; 2]);
        }
    }

    /// The key code for a symbol, and whether it needs Shift.
    fn code(&self, symbol: u32) -> (u8, bool) {
        let setup = self.connection.setup();
        let (first, count) = (setup.min_keycode, setup.max_keycode - setup.min_keycode + 1);
        let map = self.connection.get_keyboard_mapping(first, count).unwrap().reply().unwrap();
        let columns = usize::from(map.keysyms_per_keycode);
        let place = |shift: usize| {
            let rows = map.keysyms.chunks_exact(columns);
            rows.into_iter().position(|row| row[shift] == symbol)
        };
        let found = place(0).map(|row| (row, false)).or_else(|| Some((place(1)?, true)));
        let (row, is_shifted) = found.unwrap_or_else(|| panic!("no key for {symbol:#x}"));
        (first + row as u8, is_shifted)
    }

    fn fake(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        let faked = self.connection.xtest_fake_input(kind, detail, 0, self.root, x, y, 0);
        faked.unwrap().check().unwrap();
    }

    pub(crate) fn atom(&self, name: &str) -> u32 {
        self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    /// Sends a window a client message of this kind.
    pub(crate) fn send(&self, window: Window, kind: &str, data: [u32; 5]) {
        let message = ClientMessageEvent::new(32, window, self.atom(kind), data);
        let sent = self.connection.send_event(false, window, EventMask::NO_EVENT, message);
        sent.unwrap().check().unwrap();
    }

    /// Asks a window to close, as its close button does.
    pub(crate) fn close(&self, window: Window) {
        self.send(window, "WM_PROTOCOLS", [self.atom("WM_DELETE_WINDOW"), 0, 0, 0, 0]);
    }

    /// An invisible window for talking to others.
    pub(crate) fn hidden_window(&self) -> Window {
        let window = self.connection.generate_id().unwrap();
        let (class, aux) = (WindowClass::INPUT_ONLY, CreateWindowAux::new());
        let made =
            self.connection.create_window(0, window, self.root, 0, 0, 1, 1, 0, class, 0, &aux);
        made.unwrap().check().unwrap();
        window
    }

    /// The clipboard's contents in this format.
    pub(crate) fn clipboard(&self, kind: &str) -> Vec<u8> {
        let connection = &self.connection;
        let window = self.hidden_window();
        let (property, selection) = (self.atom("PASTED"), self.atom("CLIPBOARD"));
        let (kind, time) = (self.atom(kind), x11rb::CURRENT_TIME);
        connection.convert_selection(window, selection, kind, property, time).unwrap();
        connection.sync().unwrap();
        Self::wait_for("the clipboard", || {
            let event = connection.poll_for_event().unwrap();
            event.filter(|event| matches!(event, Event::SelectionNotify(_)))
        });
        let any = AtomEnum::ANY;
        let value = connection.get_property(true, window, property, any, 0, 1 << 24).unwrap();
        value.reply().unwrap().value
    }
}

/// XTEST event number for a key press; a release is one more.
const KEY: u8 = 2;
const BUTTON: u8 = 4;
const MOTION: u8 = 6;

/// The keysym of a named key or a character.
fn keysym(name: &str) -> u32 {
    match name {
        "Space" => 0x20,
        "Escape" => 0xff1b,
        "Return" => 0xff0d,
        "Ctrl" => 0xffe3,
        "Shift" => 0xffe1,
        character => character.chars().next().expect("a key has a name") as u32,
    }
}
