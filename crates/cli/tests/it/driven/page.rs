//! As much of a browser as it takes to drive: the address opened, the cookie kept, WebSocket frames (RFC 6455) by hand.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::Value;

/// Far longer than anything here takes; a page that waits so long has failed.
const PATIENCE: Duration = Duration::from_secs(120);

/// A page's socket.
pub(crate) struct Page(TcpStream);

impl Page {
    /// Opens the address that the program printed.
    pub(crate) fn open(url: &str) -> Self {
        let (host, path) = url
            .strip_prefix("http://")
            .unwrap()
            .split_once('/')
            .unwrap();
        let connect = || {
            let stream = TcpStream::connect(host).unwrap();
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
            stream
        };
        let mut login = connect();
        write!(
            login,
            "GET /{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
        )
        .unwrap();
        let mut answer = String::new();
        login.read_to_string(&mut answer).unwrap();
        let header = |line: &str| {
            let (name, value) = line.split_once(": ")?;
            let cookie = value.split(';').next()?.to_owned();
            name.eq_ignore_ascii_case("set-cookie").then_some(cookie)
        };
        let cookie = answer.lines().find_map(header).unwrap();

        let mut socket = connect();
        write!(
            socket,
            "GET /api/socket HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nCookie: {cookie}\r\n\
             Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
             Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
        )
        .unwrap();
        let mut head = Vec::new();
        while !head.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            socket.read_exact(&mut byte).unwrap();
            head.extend(byte);
        }
        assert!(head.starts_with(b"HTTP/1.1 101"), "{}", head.escape_ascii());
        Self(socket)
    }

    /// Sends a text.
    pub(crate) fn send(&mut self, text: &str) {
        const FINAL_TEXT: u8 = 0x81;
        const MASKED: u8 = 0x80;
        const LENGTH_IN_TWO_BYTES: u8 = 126;
        let mut frame = vec![FINAL_TEXT, MASKED | LENGTH_IN_TWO_BYTES];
        frame.extend(u16::try_from(text.len()).unwrap().to_be_bytes());
        // A mask of zeros leaves the text as it is.
        frame.extend([0; 4]);
        frame.extend(text.as_bytes());
        self.0.write_all(&frame).unwrap();
    }

    /// The first message that will do.
    pub(crate) fn until(&mut self, mut will_do: impl FnMut(&Value) -> bool) -> Value {
        loop {
            let message = self.next();
            if will_do(&message) {
                return message;
            }
        }
    }

    /// The next message.
    pub(crate) fn next(&mut self) -> Value {
        const TEXT: u8 = 1;
        const PING: u8 = 9;
        loop {
            let [first, second] = self.read_bytes();
            let length = match second {
                126 => u64::from(u16::from_be_bytes(self.read_bytes())),
                127 => u64::from_be_bytes(self.read_bytes()),
                short => u64::from(short),
            };
            let mut payload = vec![0; usize::try_from(length).unwrap()];
            self.0.read_exact(&mut payload).unwrap();
            match first & 0x0f {
                TEXT => return serde_json::from_slice(&payload).unwrap(),
                PING => {}
                other => panic!("frame of kind {other}: {}", payload.escape_ascii()),
            }
        }
    }

    fn read_bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        self.0.read_exact(&mut bytes).unwrap();
        bytes
    }
}
