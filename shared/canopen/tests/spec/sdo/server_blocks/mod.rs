//! The server: block transfers, byte by byte.
//!
//! Verifies: ECSS 6.1a

mod downloads;
mod uploads;

use async_canopen::sdo::machine::Payload;
use ecss_can_worlds::judge::sdo::checksum;

use super::fixture::{Bench, DOMAIN, DOMAIN_MOST, TEXT, frame, hex, pattern};

/// A segment of a sub-block.
fn segment(seqno: u8, last: bool, data: &[u8]) -> Payload {
    let mut payload = [0; 8];
    payload[0] = seqno | if last { 0x80 } else { 0 };
    payload[1..=data.len()].copy_from_slice(data);
    payload
}

fn end(unused: u8, crc: u16) -> Payload {
    let [low, high] = crc.to_le_bytes();
    [0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]
}

/// A block download of [`DOMAIN`] has begun.
fn downloading(initiate: &str) -> Bench {
    let mut bench = Bench::new();
    bench.exchange(&[(initiate, "A4 08 20 00 7F")]);
    bench
}

#[track_caller]
fn answers(bench: &mut Bench, payload: Payload, expected: &str) {
    let expected: Vec<Payload> = if expected.is_empty() { vec![] } else { vec![frame(expected)] };
    assert_eq!(hex(&bench.ask(payload)), hex(&expected));
}

/// A block upload of this value has begun, with sub-blocks of this size; the first segments.
fn uploading(value: &[u8], block_size: u8) -> (Bench, Vec<Payload>) {
    let mut bench = Bench::new();
    bench.objects.set(DOMAIN, value);
    let [low, high] = (value.len() as u16).to_le_bytes();
    let answer = bench.ask([0xA4, 0x08, 0x20, 0, block_size, 0, 0, 0]);
    assert_eq!(hex(&answer), hex(&[[0xC6, 0x08, 0x20, 0, low, high, 0, 0]]));
    let segments = bench.ask(frame("A3"));
    (bench, segments)
}

/// The segments of a value from its `first`th on, numbered from 1.
fn segments(value: &[u8], first: usize, count: usize) -> Vec<Payload> {
    let total = value.chunks(7).count();
    let parts = value.chunks(7).enumerate().skip(first).take(count);
    parts.map(|(at, part)| segment((at - first + 1) as u8, at + 1 == total, part)).collect()
}

#[test]
fn a_block_download_of_nine_bytes_byte_by_byte() {
    let mut bench = Bench::new();
    bench.exchange(&[
        ("C6 04 20 00 09 00 00 00", "A4 04 20 00 7F 00 00 00"),
        ("01 31 32 33 34 35 36 37", ""),
        ("82 38 39 AA AA AA AA AA", "A2 02 7F"),
        ("D5 C3 31", "A1"),
    ]);
    assert_eq!(bench.objects.changes, [(TEXT, b"123456789".to_vec())]);
    assert!(!bench.server.is_busy());
}

#[test]
fn a_block_upload_of_nine_bytes_byte_by_byte() {
    let mut bench = Bench::new();
    bench.objects.set(TEXT, b"123456789");
    bench.exchange(&[("A4 04 20 00 7F 00 00 00", "C6 04 20 00 09 00 00 00")]);
    let segments = bench.ask(frame("A3"));
    assert_eq!(hex(&segments), hex(&[frame("01 31 32 33 34 35 36 37"), frame("82 38 39")]));
    bench.exchange(&[("A2 02 7F", "D5 C3 31"), ("A1", "")]);
    assert!(!bench.server.is_busy());
}

/// The server offers a checksum only to a client that does.
#[test]
fn a_block_download_without_checksum_and_size() {
    let mut bench = Bench::new();
    bench.exchange(&[("C0 08 20 00", "A0 08 20 00 7F")]);
    answers(&mut bench, segment(1, false, b"1234567"), "");
    answers(&mut bench, segment(2, true, b"89"), "A2 02 7F");
    answers(&mut bench, end(5, 0), "A1");
    assert_eq!(bench.objects.changes, [(DOMAIN, b"123456789".to_vec())]);
}

/// The canopen package compares checksums whenever the server offers them.
#[test]
fn a_block_upload_without_checksum_says_zero() {
    let mut bench = Bench::new();
    bench.objects.set(DOMAIN, b"123456789");
    bench.exchange(&[("A0 08 20 00 7F", "C2 08 20 00 09")]);
    assert_eq!(bench.ask(frame("A3")).len(), 2);
    bench.exchange(&[("A2 02 7F", "D5 00 00"), ("A1", "")]);
}

/// Clients end the download of an empty value in four ways: with one empty segment or with none, and with 7 or with 0 unused
/// bytes in the last segment.
#[test]
fn empty_block_download_ends_in_each_known_way() {
    let empty_segment: &[_] = &[("81", "A2 01 7F")];
    for segments in [empty_segment, &[]] {
        for end in ["DD", "C1"] {
            for initiate in ["C6 08 20 00", "C2 08 20 00"] {
                let mut bench = Bench::new();
                bench.objects.set(DOMAIN, b"before");
                bench.ask(frame(initiate));
                bench.exchange(segments);
                bench.exchange(&[(end, "A1")]);
                assert_eq!(bench.objects.changes, [(DOMAIN, vec![])], "{initiate} {segments:?} {end}");
                assert!(!bench.server.is_busy() && !bench.objects.is_open());
            }
        }
    }
}

/// Given no size, or another one than zero, When the client ends the download without a segment, Then nothing is written: the
/// frame may be the last segment of a sub-block whose other segments were lost.
#[test]
fn block_end_without_segments_needs_the_size_zero() {
    for initiate in ["C4 08 20 00", "C6 08 20 00 01"] {
        for end in ["DD", "C1"] {
            let mut bench = Bench::new();
            bench.ask(frame(initiate));
            bench.exchange(&[(end, "A2 00 7F")]);
            assert!(bench.objects.changes.is_empty(), "{initiate} {end}");
        }
    }
}

/// Given the size zero, When bytes come all the same, Then the download is refused.
#[test]
fn block_download_of_more_than_the_size_zero_is_refused() {
    const TOO_LONG: &str = "80 08 20 00 12 00 07 06";
    let script: [&[_]; 4] = [
        &[("81 01", "A2 01 7F"), ("D9", TOO_LONG)],
        &[("81 01 02 03 04 05 06 07", "A2 01 7F"), ("C1 CD 67", "80 08 20 00 04 00 04 05")],
        &[("01 01 02 03 04 05 06 07", ""), ("82", TOO_LONG)],
        &[("01 01 02 03 04 05 06 07", ""), ("DD", TOO_LONG)],
    ];
    for script in script {
        let mut bench = downloading("C6 08 20 00");
        bench.exchange(script);
        assert!(bench.objects.changes.is_empty() && !bench.server.is_busy(), "{script:?}");
    }
}

#[test]
fn empty_values_move_in_blocks() {
    let mut bench = downloading("C6 08 20 00");
    answers(&mut bench, segment(1, true, &[]), "A2 01 7F");
    answers(&mut bench, end(7, 0), "A1");
    assert_eq!(bench.objects.changes, [(DOMAIN, vec![])]);
    bench.exchange(&[("A4 08 20 00 7F", "C6 08 20 00")]);
    assert_eq!(hex(&bench.ask(frame("A3"))), hex(&[frame("81")]));
    bench.exchange(&[("A2 01 7F", "DD"), ("A1", "")]);
}

#[test]
fn a_value_of_the_greatest_size_goes_both_ways() {
    let value = pattern(DOMAIN_MOST);
    let mut bench = downloading("C6 08 20 00 88 13");
    let total = value.chunks(7).count();
    for (at, part) in value.chunks(7).enumerate() {
        bench.ask(segment((at % 127) as u8 + 1, at + 1 == total, part));
    }
    answers(&mut bench, end(((7 - DOMAIN_MOST % 7) % 7) as u8, checksum(&value)), "A1");
    assert_eq!(bench.objects.value(DOMAIN), value);
}
