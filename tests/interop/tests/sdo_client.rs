//! The SDO client of `ecss-can` against a server that others wrote: `canopen.LocalNode`, node 5 of `python/serving.py`.
//!
//! Both hang on the nominal bus of a spacecraft that flies as usual, with a master of its own.

use ecss_can::od::{AbortCode, Address};
use ecss_can::sdo::{Error, Mode, Payload};
use interop::host::Host;
use interop::program::Twin;
use interop::script::Companion;

const SERVER: u8 = 5;

const BYTE: Address = Address::new(0x2001, 0);
const WORD: Address = Address::new(0x2002, 0);
const THREE_BYTES: Address = Address::new(0x2003, 0);
const LONG: Address = Address::new(0x2004, 0);
const EIGHT_BYTES: Address = Address::new(0x2005, 0);
const STRING: Address = Address::new(0x2006, 0);
const OCTETS: Address = Address::new(0x2007, 0);
const DOMAIN: Address = Address::new(0x2008, 0);
const CONSTANT: Address = Address::new(0x2009, 0);
const TEXT: Address = Address::new(0x200A, 0);
const KEY: Address = Address::new(0x200B, 0);
const NOTHING: Address = Address::new(0x200C, 0);

/// The default of objects that are bytes, as `python/serving.py` has it.
fn pattern(size: usize) -> Vec<u8> {
    (0..size).map(|at| (at * 167 % 251) as u8).collect()
}

/// Other bytes.
fn other(size: usize) -> Vec<u8> {
    pattern(size).into_iter().map(|byte| !byte).collect()
}

struct Flight {
    host: Host,
    server: Companion,
    twin: Twin,
}

impl Flight {
    fn begin() -> Flight {
        let twin = must(Twin::start(&["--profile", "librecube", "--slaves", "2"]));
        let mut server = must(Companion::start("serving.py", &twin));
        assert_eq!(must(server.next_line()), "serving");
        let host = must(Host::new(&twin.nominal, SERVER));
        Flight { host, server, twin }
    }

    /// Writes a value, of which the server says what it has got.
    fn writes(&mut self, at: Address, value: &[u8], mode: Mode) {
        assert_eq!(must(self.host.download(at, value, mode)), Ok(value.len()), "{at:?}");
        let digits: String = value.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(must(self.server.next_line()), format!("{:04X} {:02X} {digits}", at.index, at.sub));
    }

    fn reads(&mut self, at: Address, value: &[u8], mode: Mode) {
        assert_eq!(must(self.host.upload(at, 2000, mode)), Ok(value.to_vec()), "{at:?}");
    }

    /// Command specifiers of requests and responses, those of the first four frames.
    fn commands(&self) -> Vec<u8> {
        self.host.exchanged.iter().take(4).map(|[command, ..]| *command).collect()
    }

    /// Frames of the transfer.
    fn frames(&self) -> usize {
        self.host.exchanged.len()
    }

    /// Everything has gone well, and nothing was written that was not to be.
    fn end(self) {
        assert_eq!(must(self.server.end()), [""; 0]);
        must(self.twin.end());
    }
}

fn must<T>(result: anyhow::Result<T>) -> T {
    result.unwrap_or_else(|failure| panic!("{failure:#}"))
}

/// Verifies: ECSS 6.1a
#[test]
fn values_of_up_to_four_bytes_are_expedited() {
    let mut flight = Flight::begin();
    for (at, value, new, upload, download) in [
        (BYTE, &[0x5A][..], &[0xC3][..], 0x4F, 0x2F),
        (WORD, &[0x34, 0x12], &[0xFE, 0xCA], 0x4B, 0x2B),
        (THREE_BYTES, &[0x56, 0x34, 0x12], &[1, 2, 0xFF], 0x47, 0x27),
        (LONG, &[0x78, 0x56, 0x34, 0x12], &[0xEF, 0xBE, 0xAD, 0xDE], 0x43, 0x23),
    ] {
        flight.reads(at, value, Mode::Segmented);
        assert_eq!(flight.commands(), [0x40, upload]);
        flight.writes(at, new, Mode::Segmented);
        assert_eq!(flight.commands(), [download, 0x60]);
        // Asked for by blocks, of which the server knows none.
        flight.reads(at, new, Mode::Auto);
        assert_eq!(flight.commands(), [0xA4, upload]);
    }
    flight.end();
}

/// Verifies: ECSS 6.1a
#[test]
fn longer_values_move_in_segments() {
    let mut flight = Flight::begin();
    let text = b"ECSS-E-ST-50-15C ".repeat(6);
    let values = [
        (EIGHT_BYTES, vec![0xF0, 0xDE, 0xBC, 0x9A, 0x78, 0x56, 0x34, 0x12], other(8)),
        (STRING, text, b"nominal and redundant ".repeat(5)),
        (OCTETS, pattern(100), other(100)),
        (DOMAIN, pattern(1000), other(1000)),
    ];
    for (at, value, new) in values {
        flight.reads(at, &value, Mode::Segmented);
        assert_eq!(flight.commands(), [0x40, 0x41, 0x60, 0x00]);
        assert_eq!(flight.frames(), 2 + 2 * value.len().div_ceil(7));
        flight.writes(at, &new, Mode::Segmented);
        assert_eq!(flight.commands(), [0x21, 0x60, 0x00, 0x20]);
        assert_eq!(flight.frames(), 2 + 2 * new.len().div_ceil(7));
        flight.reads(at, &new, Mode::Segmented);
    }
    flight.end();
}

/// CiA 301 7.2.4.2.8: blocks are optional. The server answers a block upload with segments and aborts a block download.
#[test]
fn a_server_without_blocks_is_served_by_segments() {
    let mut flight = Flight::begin();
    for (at, size) in [(OCTETS, 100), (DOMAIN, 1000)] {
        flight.reads(at, &pattern(size), Mode::Auto);
        assert_eq!(flight.commands(), [0xA4, 0x41, 0x60, 0x00]);
        flight.writes(at, &other(size), Mode::Auto);
        assert_eq!(flight.commands(), [0xC6, 0x80, 0x21, 0x60]);
        assert_eq!(flight.host.exchanged.get(1).map(abort_code), Some(0x0504_0001));
        flight.reads(at, &other(size), Mode::Auto);
    }
    let refused = Err(Error::Abort(AbortCode::CommandSpecifier));
    assert_eq!(must(flight.host.download(DOMAIN, &pattern(1000), Mode::Block)), refused);
    flight.end();
}

fn abort_code(payload: &Payload) -> u32 {
    let [_, _, _, _, code @ ..] = *payload;
    u32::from_le_bytes(code)
}

/// Verifies: ECSS 6.1a
#[test]
fn refusals_have_their_abort_codes() {
    use AbortCode::{Length, NoConnection, NoData, NoObject, NoSubIndex, ReadOnly, WriteOnly};
    let mut flight = Flight::begin();
    let unknown = Address::new(0x5FFF, 0);
    let no_member = Address::new(0x2010, 9);
    for (at, mode, code) in [
        (unknown, Mode::Segmented, NoObject),
        (unknown, Mode::Auto, NoObject),
        (no_member, Mode::Segmented, NoSubIndex),
        (KEY, Mode::Auto, WriteOnly),
        // Its code for an object without a value.
        (NOTHING, Mode::Segmented, NoConnection),
    ] {
        assert_eq!(must(flight.host.upload(at, 2000, mode)), Err(Error::Abort(code)), "{at:?}");
    }
    for (at, value, code) in [
        (unknown, vec![1], NoObject),
        (no_member, vec![1], NoSubIndex),
        (CONSTANT, vec![1, 2, 3, 4], ReadOnly),
        // Which it tells after the last segment.
        (TEXT, pattern(100), ReadOnly),
        (WORD, vec![1], Length),
        (EIGHT_BYTES, pattern(9), Length),
    ] {
        assert_eq!(
            must(flight.host.download(at, &value, Mode::Segmented)),
            Err(Error::Abort(code)),
            "{at:?}"
        );
    }
    // An empty value is one, but not for this server when it is read.
    flight.writes(DOMAIN, &[], Mode::Auto);
    assert_eq!(must(flight.host.upload(DOMAIN, 2000, Mode::Auto)), Err(Error::Abort(NoData)));
    // More than the application takes.
    assert_eq!(must(flight.host.upload(OCTETS, 99, Mode::Segmented)), Err(Error::TooLarge));
    flight.reads(OCTETS, &pattern(100), Mode::Segmented);
    flight.end();
}
