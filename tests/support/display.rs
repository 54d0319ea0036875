//! An X server without a screen, and a user in front of it.

use image::RgbImage;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt, CreateWindowAux, EventMask,
    ImageFormat, PropMode, SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Core events of XTEST.
const KEY_PRESS: u8 = 2;
const KEY_RELEASE: u8 = 3;
const BUTTON_PRESS: u8 = 4;
const BUTTON_RELEASE: u8 = 5;
const MOTION: u8 = 6;

/// A running server; it ends with its value.
pub struct Display {
    server: Child,
    /// Its name, `:7`.
    pub name: String,
    connection: RustConnection,
    root: Window,
}

impl Display {
    /// Starts a server with a screen of `width` × `height`.
    pub fn start(width: u32, height: u32) -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0"])
            .arg(format!("{width}x{height}x24"))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts: it is in Debian's package xvfb");
        let mut number = String::new();
        let mut out = server.stdout.take().unwrap();
        let mut byte = [0];
        while out.read(&mut byte).unwrap() == 1 && byte[0] != b'\n' {
            number.push(char::from(byte[0]));
        }
        let name = format!(":{}", number.trim());
        let (connection, screen) = RustConnection::connect(Some(&name)).unwrap();
        let root = connection.setup().roots[screen].root;
        let found = connection.extension_information("XTEST").unwrap();
        assert!(found.is_some(), "the server can be sent input");
        Self {
            server,
            name,
            connection,
            root,
        }
    }

    /// The window whose title `is` what is looked for.
    fn find(&self, is: impl Fn(&str) -> bool) -> Option<Window> {
        let tree = self.connection.query_tree(self.root).unwrap();
        let windows = tree.reply().unwrap().children;
        windows.into_iter().find(|w| is(&self.title(*w)))
    }

    /// Waits for a window whose title contains `text`.
    pub fn wait_for_window(&self, text: &str) -> Window {
        let found = || self.find(|title| title.contains(text));
        wait(&format!("a window `{text}`"), found)
    }

    fn atom(&self, name: &str) -> u32 {
        let atom = self.connection.intern_atom(false, name.as_bytes());
        atom.unwrap().reply().unwrap().atom
    }

    /// The title of a window; empty where it has none.
    pub fn title(&self, window: Window) -> String {
        let name = self.atom("_NET_WM_NAME");
        let property = self
            .connection
            .get_property(false, window, name, AtomEnum::ANY, 0, 1024);
        let value = property.unwrap().reply().map(|p| p.value);
        String::from_utf8_lossy(&value.unwrap_or_default()).into_owned()
    }

    fn fake(&self, kind: u8, detail: u8, (x, y): (i16, i16)) {
        let fake = self
            .connection
            .xtest_fake_input(kind, detail, 0, self.root, x, y, 0);
        fake.unwrap().check().unwrap();
    }

    /// Moves the pointer.
    pub fn point(&self, at: (i16, i16)) {
        self.fake(MOTION, 0, at);
    }

    /// Presses or releases a button of the pointer, 1 to 5.
    pub fn button(&self, number: u8, press: bool) {
        let kind = if press { BUTTON_PRESS } else { BUTTON_RELEASE };
        self.fake(kind, number, (0, 0));
    }

    /// Clicks at a point.
    pub fn click(&self, at: (i16, i16)) {
        self.point(at);
        pause(60);
        self.button(1, true);
        pause(60);
        self.button(1, false);
        pause(60);
    }

    /// Drags with a button from one point to another.
    pub fn drag(&self, number: u8, from: (i16, i16), to: (i16, i16)) {
        self.point(from);
        pause(60);
        self.button(number, true);
        for step in 1..=8_i16 {
            let between = |a: i16, b: i16| a + (b - a) / 8 * step;
            self.point((between(from.0, to.0), between(from.1, to.1)));
            pause(20);
        }
        self.point(to);
        pause(20);
        self.button(number, false);
        pause(60);
    }

    /// Presses and releases the key of a symbol, such as `'f'` or 0xffc8 (F11).
    pub fn key(&self, symbol: u32) {
        let code = self.key_code(symbol);
        self.fake(KEY_PRESS, code, (0, 0));
        pause(40);
        self.fake(KEY_RELEASE, code, (0, 0));
        pause(40);
    }

    /// Presses the key of a symbol while others are held.
    pub fn chord(&self, held: &[Option<u32>], symbol: u32) {
        let held: Vec<_> = held.iter().flatten().map(|s| self.key_code(*s)).collect();
        for &code in &held {
            self.fake(KEY_PRESS, code, (0, 0));
        }
        pause(40);
        self.key(symbol);
        for &code in &held {
            self.fake(KEY_RELEASE, code, (0, 0));
        }
    }

    /// Asks a window to close, as a window manager does.
    pub fn ask_to_close(&self, window: Window) {
        let data = [self.atom("WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, self.atom("WM_PROTOCOLS"), data);
        let sent = self
            .connection
            .send_event(false, window, EventMask::NO_EVENT, event);
        sent.unwrap().check().unwrap();
    }

    fn key_code(&self, symbol: u32) -> u8 {
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let mapping = self
            .connection
            .get_keyboard_mapping(first, last - first + 1);
        let mapping = mapping.unwrap().reply().unwrap();
        let per_code = usize::from(mapping.keysyms_per_keycode);
        let mut codes = mapping.keysyms.chunks(per_code);
        let found = codes.position(|symbols| symbols.contains(&symbol));
        first + u8::try_from(found.expect("a key has the symbol")).unwrap()
    }

    /// Gives a window the keyboard.
    pub fn focus(&self, window: Window) {
        let parent = x11rb::protocol::xproto::InputFocus::PARENT;
        let focus = self
            .connection
            .set_input_focus(parent, window, x11rb::CURRENT_TIME);
        focus.unwrap().check().unwrap();
    }

    /// Changes the size of a window.
    pub fn resize(&self, window: Window, width: u32, height: u32) {
        let size = ConfigureWindowAux::new().width(width).height(height);
        let configured = self.connection.configure_window(window, &size);
        configured.unwrap().check().unwrap();
    }

    /// What is on the screen.
    pub fn capture(&self) -> RgbImage {
        let size = self.connection.get_geometry(self.root);
        let size = size.unwrap().reply().unwrap();
        let (width, height) = (size.width, size.height);
        let image =
            self.connection
                .get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, !0);
        let data = image.unwrap().reply().unwrap().data;
        let rgb = data.chunks(4).flat_map(|p| [p[2], p[1], p[0]]).collect();
        RgbImage::from_raw(width.into(), height.into(), rgb).unwrap()
    }

    /// Drops a file on a window, by version 5 of the XDND protocol.
    pub fn drop_file(&self, window: Window, path: &Path) {
        let source = self.connection.generate_id().unwrap();
        let events = CreateWindowAux::new().event_mask(EventMask::PROPERTY_CHANGE);
        let created = self.connection.create_window(
            0,
            source,
            self.root,
            0,
            0,
            1,
            1,
            0,
            WindowClass::INPUT_OUTPUT,
            0,
            &events,
        );
        created.unwrap().check().unwrap();
        let atoms = ["XdndSelection", "XdndEnter", "XdndPosition", "XdndDrop"];
        let [selection, enter, position, drop] = atoms.map(|name| self.atom(name));
        let (list, copy) = (self.atom("text/uri-list"), self.atom("XdndActionCopy"));
        let time = x11rb::CURRENT_TIME;
        let owned = self.connection.set_selection_owner(source, selection, time);
        owned.unwrap().check().unwrap();
        let send = |kind: u32, data: [u32; 4]| {
            let [a, b, c, d] = data;
            let event = ClientMessageEvent::new(32, window, kind, [source, a, b, c, d]);
            let sent = self
                .connection
                .send_event(false, window, EventMask::NO_EVENT, event);
            sent.unwrap().check().unwrap();
        };
        send(enter, [5 << 24, list, 0, 0]);
        send(position, [0, 100 << 16 | 100, time, copy]);
        let uri = format!("file://{}\r\n", path.display());
        let end = Instant::now() + Duration::from_secs(10);
        let mut dropped = false;
        loop {
            assert!(
                Instant::now() < end,
                "the window takes what is dropped on it"
            );
            match self.connection.poll_for_event().unwrap() {
                Some(Event::SelectionRequest(request)) => {
                    let bytes = uri.as_bytes();
                    let (to, property) = (request.requestor, request.property);
                    let changed = self.connection.change_property8(
                        PropMode::REPLACE,
                        to,
                        property,
                        list,
                        bytes,
                    );
                    changed.unwrap().check().unwrap();
                    let answer = SelectionNotifyEvent {
                        response_type: SELECTION_NOTIFY_EVENT,
                        sequence: 0,
                        time: request.time,
                        requestor: to,
                        selection: request.selection,
                        target: request.target,
                        property,
                    };
                    let sent = self
                        .connection
                        .send_event(false, to, EventMask::NO_EVENT, answer);
                    sent.unwrap().check().unwrap();
                }
                Some(Event::ClientMessage(message)) => {
                    let finished = message.type_ == self.atom("XdndFinished");
                    let accepts = message.type_ == self.atom("XdndStatus");
                    if finished {
                        return;
                    }
                    if accepts && !dropped {
                        send(drop, [0, time, 0, 0]);
                        dropped = true;
                    }
                }
                _ => pause(10),
            }
        }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Lets time pass.
pub fn pause(milliseconds: u64) {
    std::thread::sleep(Duration::from_millis(milliseconds));
}

/// Waits until `found` finds something.
pub fn wait<T>(what: &str, mut found: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + Duration::from_secs(60);
    loop {
        if let Some(found) = found() {
            return found;
        }
        assert!(Instant::now() < end, "waited in vain for {what}");
        pause(20);
    }
}
