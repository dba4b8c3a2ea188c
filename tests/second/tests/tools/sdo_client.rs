//! The SDO client of `ecss-can` against servers that others wrote, node 5: `canopen.LocalNode` of `python/serving.py`, which
//! knows no blocks, and a node of durand, `python/blocks.py`, which does.
//!
//! Client and server are on the nominal bus of a running spacecraft with its own master.

use ecss_can::sdo::Error;
use ecss_can::sdo::Mode;
use ecss_can::types::{AbortCode, Address};
use second::flight::Flight;

const LOCAL_NODE: &str = "serving.py";
const DURAND: &str = "blocks.py";

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

/// Returns the default of objects with bytes in `python/serving.py`.
fn pattern(size: usize) -> Vec<u8> {
    (0..size).map(|at| (at * 167 % 251) as u8).collect()
}

/// Returns other bytes.
fn other(size: usize) -> Vec<u8> {
    pattern(size).into_iter().map(|byte| !byte).collect()
}

/// Returns random bytes, the same for each call.
fn random(size: usize) -> Vec<u8> {
    let mut random = fastrand::Rng::with_seed(size as u64);
    std::iter::repeat_with(|| random.u8(..)).take(size).collect()
}

/// Verifies: ECSS 6.1a
#[test]
fn values_of_up_to_four_bytes_are_expedited() {
    let mut flight = Flight::begin(LOCAL_NODE);
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
        // Requested by blocks, which the server does not support.
        flight.reads(at, new, Mode::Auto);
        assert_eq!(flight.commands(), [0xA4, upload]);
    }
    flight.end();
}

/// Verifies: ECSS 6.1a
#[test]
fn longer_values_move_in_segments() {
    let mut flight = Flight::begin(LOCAL_NODE);
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
    let mut flight = Flight::begin(LOCAL_NODE);
    for (at, size) in [(OCTETS, 100), (DOMAIN, 1000)] {
        flight.reads(at, &pattern(size), Mode::Auto);
        assert_eq!(flight.commands(), [0xA4, 0x41, 0x60, 0x00]);
        flight.writes(at, &other(size), Mode::Auto);
        assert_eq!(flight.commands(), [0xC6, 0x80, 0x21, 0x60]);
        assert_eq!(flight.abort_code(1), Some(0x0504_0001));
        flight.reads(at, &other(size), Mode::Auto);
    }
    let refused = Err(Error::Abort(AbortCode::CommandSpecifier));
    assert_eq!(flight.download(DOMAIN, &pattern(1000), Mode::Block), refused);
    flight.end();
}

/// Verifies: ECSS 6.1a
#[test]
fn refusals_have_their_abort_codes() {
    use AbortCode::{Length, NoConnection, NoData, NoObject, NoSubIndex, ReadOnly, WriteOnly};
    let mut flight = Flight::begin(LOCAL_NODE);
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
        assert_eq!(flight.upload(at, 2000, mode), Err(Error::Abort(code)), "{at:?}");
    }
    for (at, value, code) in [
        (unknown, vec![1], NoObject),
        (no_member, vec![1], NoSubIndex),
        (CONSTANT, vec![1, 2, 3, 4], ReadOnly),
        // The server reports this after the last segment.
        (TEXT, pattern(100), ReadOnly),
        (WORD, vec![1], Length),
        (EIGHT_BYTES, pattern(9), Length),
    ] {
        assert_eq!(flight.download(at, &value, Mode::Segmented), Err(Error::Abort(code)), "{at:?}");
    }
    // An empty value is valid, but this server cannot read one.
    flight.writes(DOMAIN, &[], Mode::Auto);
    assert_eq!(flight.upload(DOMAIN, 2000, Mode::Auto), Err(Error::Abort(NoData)));
    // More than the application takes.
    assert_eq!(flight.upload(OCTETS, 99, Mode::Segmented), Err(Error::TooLarge));
    flight.reads(OCTETS, &pattern(100), Mode::Segmented);
    flight.end();
}

/// Given values of a byte, a byte more than a segment, sub-blocks with a byte less and more, and 20 kB, full last
/// segments, and refusals, then blocks are transferred.
///
/// Verifies: ECSS 6.1a
#[test]
fn blocks_are_moved_with_a_node_of_durand() {
    use AbortCode::{NoObject, ReadOnly, WriteOnly};
    let mut flight = Flight::begin(DURAND);
    flight.reads(DOMAIN, &pattern(1000), Mode::Block);
    assert_eq!(flight.commands()[..3], [0xA4, 0xC6, 0xA3]);
    let frames = flight.frames();
    // Of 127 segments, an acknowledgement and 16 segments: the first, one in the middle, the last but one. It comes again with
    // those behind it, and with an acknowledgement where there is a sub-block more.
    for (lost, more) in [(3, 127 + 1), (3 + 63, 64), (3 + 127 + 1 + 14, 2 + 1)] {
        flight.reads_without(lost, DOMAIN, &pattern(1000));
        assert_eq!(flight.frames(), frames + more);
    }
    for size in [1, 7, 8, 888, 889, 890, 20_000] {
        let value = random(size);
        flight.writes(DOMAIN, &value, Mode::Block);
        assert_eq!(flight.commands()[..2], [0xC6, 0xA4]);
        assert_eq!(flight.frames(), 4 + size.div_ceil(7) + size.div_ceil(889));
        if size % 7 != 0 {
            flight.reads(DOMAIN, &value, Mode::Block);
            continue;
        }
        // durand 0.5.0 reports that no byte of a full last segment is used.
        let wrong = Err(Error::Protocol(AbortCode::TooShort));
        assert_eq!(flight.upload(DOMAIN, 20_000, Mode::Block), wrong, "{size}");
    }
    // Sizes below and above the limit for blocks.
    for (size, command) in [(4, 0x23), (28, 0x21), (29, 0xC6)] {
        flight.writes(DOMAIN, &other(size), Mode::Auto);
        assert_eq!(flight.commands()[0], command);
        flight.reads(DOMAIN, &other(size), Mode::Auto);
    }

    let unknown = Address::new(0x5FFF, 0);
    for (at, code) in [(unknown, NoObject), (KEY, WriteOnly)] {
        assert_eq!(flight.upload(at, 2000, Mode::Block), Err(Error::Abort(code)), "{at:?}");
    }
    for (at, code) in [(unknown, NoObject), (CONSTANT, ReadOnly)] {
        assert_eq!(flight.download(at, &other(1000), Mode::Block), Err(Error::Abort(code)), "{at:?}");
    }
    // More than the application takes. The server indicates the size at once.
    assert_eq!(flight.upload(DOMAIN, 28, Mode::Block), Err(Error::TooLarge));
    flight.reads(DOMAIN, &other(29), Mode::Block);
    flight.end();
}
