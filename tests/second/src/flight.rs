//! The SDO client of `ecss-can`, a third-party server, and a spacecraft on whose nominal bus they communicate.

use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::types::Address;

use crate::host::Host;
use crate::program::Twin;
use crate::script::Companion;

/// Node of the server, which no board has.
const SERVER: u8 = 5;

/// Client, server and spacecraft. It panics at an error, because it is for tests.
pub struct Flight {
    host: Host,
    server: Companion,
    twin: Twin,
}

impl Flight {
    /// Starts a spacecraft with a master and two slaves, and the server of this script of `python/`.
    pub fn begin(script: &str) -> Flight {
        let twin = must(Twin::start(&["--profile", "librecube", "--slaves", "2"]));
        let mut server = must(Companion::start(script, &twin));
        assert_eq!(must(server.next_line()), "serving");
        let host = must(Host::new(&twin.nominal, SERVER));
        Flight { host, server, twin }
    }

    /// Writes a value, and returns the result of the transfer.
    pub fn download(&mut self, at: Address, value: &[u8], mode: Mode) -> Result<usize, Error> {
        must(self.host.download(at, value, mode))
    }

    /// Reads a value of at most `most` bytes.
    pub fn upload(&mut self, at: Address, most: usize, mode: Mode) -> Result<Vec<u8>, Error> {
        must(self.host.upload(at, most, mode))
    }

    /// Writes a value, and asserts that the server has received it.
    pub fn writes(&mut self, at: Address, value: &[u8], mode: Mode) {
        assert_eq!(self.download(at, value, mode), Ok(value.len()), "{at:?}");
        let digits: String = value.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(must(self.server.next_line()), format!("{:04X} {:02X} {digits}", at.index, at.sub));
    }

    /// Reads a value, and asserts that it is `value`.
    pub fn reads(&mut self, at: Address, value: &[u8], mode: Mode) {
        assert_eq!(self.upload(at, 20_000, mode), Ok(value.to_vec()), "{at:?}");
    }

    /// Reads a value by blocks while the nth frame is lost, and asserts that it is `value`.
    pub fn reads_without(&mut self, nth: usize, at: Address, value: &[u8]) {
        self.host.misses = Some(nth);
        self.reads(at, value, Mode::Block);
        self.host.misses = None;
    }

    /// Returns the command specifiers of the first four frames of the last transfer.
    pub fn commands(&self) -> Vec<u8> {
        self.host.exchanged.iter().take(4).map(|[command, ..]| *command).collect()
    }

    /// Returns the number of frames of the last transfer.
    pub fn frames(&self) -> usize {
        self.host.exchanged.len()
    }

    /// Returns the abort code in the nth frame of the last transfer.
    pub fn abort_code(&self, nth: usize) -> Option<u32> {
        let [_, _, _, _, code @ ..] = *self.host.exchanged.get(nth)?;
        Some(u32::from_le_bytes(code))
    }

    /// Asserts that nothing failed and no unexpected value was written.
    pub fn end(self) {
        assert_eq!(must(self.server.end()), [""; 0]);
        must(self.twin.end());
    }
}

fn must<T>(result: anyhow::Result<T>) -> T {
    result.unwrap_or_else(|failure| panic!("{failure:#}"))
}
