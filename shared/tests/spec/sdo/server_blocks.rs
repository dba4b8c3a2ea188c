//! The server: block transfers, lost and repeated segments, sub-blocks that are sent again.

use ecss_can::sdo::{Payload, WINDOW};
use ecss_can::time::Duration;

use super::fixture::{Bench, DOMAIN, DOMAIN_MOST, PAUSE, TEXT, TIMEOUT, frame, hex, pattern};

/// A segment of a sub-block.
fn segment(seqno: u8, last: bool, data: &[u8]) -> Payload {
    let mut payload = [0; 8];
    payload[0] = seqno | if last { 0x80 } else { 0 };
    payload[1..=data.len()].copy_from_slice(data);
    payload
}

/// The checksum, bit by bit as the standard has it.
pub fn checksum(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, byte| {
        (0..8).rev().fold(crc, |crc: u16, bit| {
            let feedback = (crc >> 15) ^ u16::from(byte >> bit & 1);
            (crc << 1) ^ (feedback * 0x1021)
        })
    })
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

/// Verifies: ECSS 6.1a
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

/// Verifies: ECSS 6.1a
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
fn a_download_of_several_sub_blocks_passes_in_parts() {
    let value = pattern(2_000);
    let mut bench = downloading("C6 08 20 00 D0 07");
    let count = value.chunks(7).count();
    for (at, part) in value.chunks(7).enumerate() {
        let seqno = (at % 127) as u8 + 1;
        let is_last = at + 1 == count;
        let ack = if seqno == 127 || is_last { format!("A2 {seqno:02X} 7F") } else { String::new() };
        answers(&mut bench, segment(seqno, is_last, part), &ack);
    }
    assert!(bench.objects.changes.is_empty());
    answers(&mut bench, end(2, checksum(&value)), "A1");
    assert_eq!(bench.objects.changes, [(DOMAIN, value)]);
    assert!(bench.objects.largest_part <= 72);
}

/// Verifies: ECSS 6.1a
#[test]
fn segments_after_a_lost_one_are_ignored_and_sent_again() {
    let value = pattern(42);
    let mut bench = downloading("C6 08 20 00 2A");
    let part = |at: usize| &value[at * 7..at * 7 + 7];
    answers(&mut bench, segment(1, false, part(0)), "");
    answers(&mut bench, segment(2, false, part(1)), "");
    for (seqno, at) in [(4, 3), (5, 4)] {
        answers(&mut bench, segment(seqno, false, part(at)), "");
    }
    answers(&mut bench, segment(6, true, part(5)), "A2 02 7F");
    answers(&mut bench, segment(1, false, part(2)), "");
    answers(&mut bench, segment(2, false, part(3)), "");
    answers(&mut bench, segment(3, false, part(4)), "");
    answers(&mut bench, segment(4, true, part(5)), "A2 04 7F");
    answers(&mut bench, end(0, checksum(&value)), "A1");
    assert_eq!(bench.objects.changes, [(DOMAIN, value)]);
}

#[test]
fn sequence_number_zero_does_not_count() {
    let mut bench = downloading("C6 08 20 00 0E");
    answers(&mut bench, segment(1, false, b"1234567"), "");
    answers(&mut bench, segment(0, false, b"-------"), "");
    answers(&mut bench, segment(2, true, b"7654321"), "A2 02 7F");
    answers(&mut bench, end(0, checksum(b"12345677654321")), "A1");

    let mut bench = downloading("C6 08 20 00 0E");
    answers(&mut bench, segment(0, false, b"-------"), "");
    assert_eq!(hex(&bench.wait(PAUSE)), hex(&[frame("A2 00 7F")]));
}

#[test]
fn a_segment_that_comes_twice_counts_once() {
    let value = pattern(20);
    let mut bench = downloading("C6 08 20 00 14");
    for _ in 0..2 {
        answers(&mut bench, segment(1, false, &value[..7]), "");
    }
    answers(&mut bench, segment(2, false, &value[7..14]), "");
    answers(&mut bench, segment(3, true, &value[14..]), "A2 03 7F");
    bench.ignores(segment(3, true, &value[14..]));
    answers(&mut bench, end(1, checksum(&value)), "A1");
    assert_eq!(bench.objects.changes, [(DOMAIN, value)]);
    // The same number is not enough.
    let mut bench = downloading("C6 08 20 00 07");
    answers(&mut bench, segment(1, true, b"1234567"), "A2 01 7F");
    answers(&mut bench, segment(1, true, b"1234568"), "");
    assert!(!bench.server.is_busy(), "it is an abort");
}

#[test]
fn the_last_segment_of_a_sub_block_may_come_twice() {
    let value = pattern(130 * 7);
    let mut bench = downloading("C6 08 20 00 8E 03");
    for (at, part) in value.chunks(7).enumerate().take(126) {
        answers(&mut bench, segment(at as u8 + 1, false, part), "");
    }
    let last = segment(127, false, &value[126 * 7..127 * 7]);
    answers(&mut bench, last, "A2 7F 7F");
    bench.ignores(last);
    answers(&mut bench, segment(1, false, &value[127 * 7..128 * 7]), "");
    answers(&mut bench, segment(2, false, &value[128 * 7..129 * 7]), "");
    answers(&mut bench, segment(3, true, &value[129 * 7..]), "A2 03 7F");
    answers(&mut bench, end(0, checksum(&value)), "A1");
}

#[test]
fn a_pause_in_a_sub_block_brings_its_acknowledgement() {
    let value = pattern(21);
    let mut bench = downloading("C6 08 20 00 15");
    answers(&mut bench, segment(1, false, &value[..7]), "");
    answers(&mut bench, segment(2, false, &value[7..14]), "");
    assert_eq!(bench.server.deadline(), Some(bench.now + PAUSE));
    assert_eq!(hex(&bench.wait(PAUSE)), hex(&[frame("A2 02 7F")]));
    assert_eq!(bench.server.deadline(), Some(bench.now + TIMEOUT), "nothing is lost twice");
    answers(&mut bench, segment(1, true, &value[14..]), "A2 01 7F");
    answers(&mut bench, end(0, checksum(&value)), "A1");
    assert_eq!(bench.objects.changes, [(DOMAIN, value)]);
}

#[test]
fn a_sub_block_that_does_not_begin_is_no_pause() {
    let mut bench = downloading("C6 08 20 00 15");
    assert!(bench.wait(Duration::from_millis(399)).is_empty());
    assert_eq!(hex(&bench.wait(Duration::from_millis(1))), hex(&[frame("80 08 20 00 00 00 04 05")]));
    assert_eq!(bench.objects.cancelled, 1);
}

#[test]
fn in_a_sub_block_everything_is_a_segment_but_an_abort() {
    let mut bench = downloading("C6 08 20 00 15");
    bench.exchange(&[
        ("40 00 20 00", ""),
        ("23 00 20 00 01 02 03 04", ""),
        ("60", ""),
        ("80 08 20 00 00 00 00 08", ""),
        ("40 00 20 00", "43 00 20 00 78 56 34 12"),
    ]);
    assert!(bench.objects.changes.is_empty());
    assert_eq!(bench.objects.cancelled, 1);
}

#[test]
fn a_client_that_begins_anew_in_a_sub_block_is_served_in_the_end() {
    // It asks again before each timeout; what it asks is a segment out of order.
    let mut bench = downloading("C6 08 20 00 15");
    let retry = Duration::from_micros(TIMEOUT.as_micros() * 3 / 4);
    for attempt in 0..20 {
        if bench.ask(frame("40 00 20 00")) == [frame("43 00 20 00 78 56 34 12")] {
            assert!(attempt >= 9, "a bus that loses eight sub-blocks in a row is borne with");
            return;
        }
        bench.wait(retry);
    }
    panic!("never served");
}

#[test]
fn sub_blocks_that_bring_nothing_end_a_download() {
    let mut bench = downloading("C6 08 20 00 E8 03");
    for _ in 0..8 {
        answers(&mut bench, segment(127, false, &[9; 7]), "A2 00 7F");
        answers(&mut bench, segment(3, false, &[9; 7]), "");
    }
    answers(&mut bench, segment(127, false, &[9; 7]), "80 08 20 00 03 00 04 05");
    assert!(!bench.server.is_busy());
    assert!(!bench.objects.is_open());
    // One that does starts the count anew.
    let mut bench = downloading("C6 08 20 00 E8 03");
    for turn in 0..3 {
        for _ in 0..8 {
            answers(&mut bench, segment(126, false, &[9; 7]), "");
            answers(&mut bench, segment(127, false, &[9; 7]), "A2 00 7F");
        }
        answers(&mut bench, segment(1, false, &[turn; 7]), "");
        answers(&mut bench, segment(127, false, &[9; 7]), "A2 01 7F");
    }
}

#[test]
fn an_upload_of_which_nothing_is_acknowledged_ends() {
    let value = pattern(75);
    let (mut bench, _) = uploading(&value, 5);
    for _ in 0..8 {
        bench.left(5);
        assert_eq!(hex(&bench.ask(frame("A2 00 05"))), hex(&segments(&value, 0, 5)));
    }
    bench.left(5);
    answers(&mut bench, frame("A2 00 05"), "80 08 20 00 03 00 04 05");
}

/// Each script is a download of [`DOMAIN`] that fails at its last frame.
///
/// Verifies: ECSS 6.1a
#[test]
fn every_bad_block_download_has_its_abort_code() {
    const CRC: &str = "80 08 20 00 04 00 04 05";
    const TOO_LONG: &str = "80 08 20 00 12 00 07 06";
    const TOO_SHORT: &str = "80 08 20 00 13 00 07 06";
    const SPECIFIER: &str = "80 08 20 00 01 00 04 05";
    let nine = "C6 08 20 00 09";
    let one = ("01 31 32 33 34 35 36 37", "");
    let two = ("82 38 39", "A2 02 7F");
    type Row<'a> = (&'a str, &'a str, &'a [(&'a str, &'a str)]);
    let table: &[Row] = &[
        ("checksum wrong", nine, &[one, two, ("D5 C3 32", CRC)]),
        ("checksum of the unused bytes, too", nine, &[one, two, ("D5 C4 31", CRC)]),
        ("one unused byte less", nine, &[one, two, ("D1 C3 31", TOO_LONG)]),
        ("one unused byte more", nine, &[one, two, ("D9 C3 31", TOO_SHORT)]),
        ("a segment less than told", "C6 08 20 00 10", &[one, two, ("C1 C3 31", TOO_SHORT)]),
        ("a segment more than told", "C6 08 20 00 07", &[one, two, ("C1 C3 31", TOO_LONG)]),
        ("told beyond the end of a sub-block", "C6 08 20 00 03", &[one, ("82", "80 08 20 00 12 00 07 06")]),
        ("another specifier at the end", nine, &[one, two, ("E0", SPECIFIER)]),
        ("a download segment at the end", nine, &[one, two, ("00", SPECIFIER)]),
        ("an upload frame at the end", nine, &[one, two, ("A3", SPECIFIER)]),
    ];
    for (what, initiate, script) in table {
        let mut bench = downloading(initiate);
        bench.exchange(script);
        assert!(bench.objects.changes.is_empty(), "{what}");
        assert!(!bench.objects.is_open(), "{what}");
        assert!(!bench.server.is_busy(), "{what}");
        bench.exchange(&[("40 00 20 00", "43 00 20 00 78 56 34 12")]);
    }
}

#[test]
fn a_block_download_that_is_refused_at_its_initiate() {
    for (request, answer) in [
        ("C6 08 20 00 89 13", "80 08 20 00 12 00 07 06"),
        ("C6 07 20 00 41", "80 07 20 00 05 00 04 05"),
        ("C6 00 20 00 05", "80 00 20 00 12 00 07 06"),
    ] {
        let mut bench = Bench::new();
        bench.exchange(&[(request, answer)]);
        assert!(!bench.server.is_busy());
        assert!(!bench.objects.is_open());
    }
}

#[test]
fn a_refusal_in_a_sub_block_waits_for_its_end() {
    // The dictionary refuses byte 100, in segment 15 or later.
    let mut bench = Bench::new();
    bench.exchange(&[("C4 0A 20 00", "A4 0A 20 00 7F")]);
    for seqno in 1..127 {
        // Some of these would be commands: 23h writes 2000h, 40h reads it.
        answers(&mut bench, segment(seqno, false, &[0x00, 0x20, 0, 9, 9, 9, 9]), "");
    }
    assert_eq!(bench.objects.cancelled, 0, "a part that fails cancels its stream itself");
    assert!(!bench.objects.is_open());
    answers(&mut bench, segment(127, false, &[9; 7]), "80 0A 20 00 00 00 06 06");
    assert!(!bench.server.is_busy());
    assert!(bench.objects.changes.is_empty());
}

#[test]
fn a_refusal_at_the_end_of_a_sub_block_is_told_at_once() {
    let mut bench = downloading("C6 08 20 00 75 03");
    for seqno in 1..127 {
        answers(&mut bench, segment(seqno, false, &[9; 7]), "");
    }
    answers(&mut bench, segment(127, false, &[9; 7]), "80 08 20 00 12 00 07 06");
    assert_eq!(bench.objects.cancelled, 1);
    assert!(!bench.server.is_busy());
}

#[test]
fn a_refusal_is_told_after_a_pause_when_the_end_is_lost() {
    let mut bench = downloading("C6 08 20 00 03");
    answers(&mut bench, segment(1, false, &[9; 7]), "");
    assert_eq!(hex(&bench.wait(PAUSE)), hex(&[frame("80 08 20 00 12 00 07 06")]));
    assert!(!bench.server.is_busy());
}

#[test]
fn segments_that_are_late_write_nothing() {
    // The 34th would write 2000h, were it a command.
    let command = [0x00, 0x20, 0x00, 1, 2, 3, 4];
    type End = fn(&mut Bench);
    let ends: [(u8, End); 3] = [
        (34, |bench| {
            assert_eq!(bench.wait(PAUSE), [frame("A2 22 7F")]);
            for seqno in 1..=34 {
                assert!(bench.ask(segment(seqno, false, &[9; 7])).is_empty());
            }
            bench.server.abort(ecss_can::od::AbortCode::DeviceState, &mut bench.objects, &mut |_| {});
        }),
        (34, |bench| bench.server.reset(&mut bench.objects)),
        (32, |bench| bench.server.reset(&mut bench.objects)),
    ];
    for (before, end) in ends {
        let mut bench = downloading("C6 08 20 00 E8 03");
        for seqno in 1..=before {
            answers(&mut bench, segment(seqno, false, &[9; 7]), "");
        }
        end(&mut bench);
        assert!(!bench.server.is_busy());
        for seqno in 35..=127 {
            answers(&mut bench, segment(seqno, false, &command), "");
        }
        assert!(bench.objects.changes.is_empty());
        bench.exchange(&[("40 00 20 00", "43 00 20 00 78 56 34 12")]);
    }
}

#[test]
fn segments_that_are_late_may_have_gaps() {
    let mut bench = downloading("C6 08 20 00 E8 03");
    for seqno in 1..=30 {
        answers(&mut bench, segment(seqno, false, &[9; 7]), "");
    }
    bench.server.reset(&mut bench.objects);
    // 22h, 26h, 2Ah and 2Eh write.
    for seqno in (34..=46).step_by(4) {
        bench.ignores(segment(seqno, false, &[0x00, 0x20, 0, 1, 2, 3, 4]));
    }
    // One more is missing: a request.
    answers(&mut bench, segment(51, false, &[0x00, 0x20, 0, 1, 2, 3, 4]), "60 00 20 00");
}

#[test]
fn late_segments_end_with_the_last_one() {
    let mut bench = downloading("C6 08 20 00 E8 03");
    for seqno in 1..=30 {
        answers(&mut bench, segment(seqno, false, &[9; 7]), "");
    }
    bench.server.reset(&mut bench.objects);
    bench.ignores(segment(31, false, &[9; 7]));
    bench.ignores(segment(32, true, &[9; 7]));
    bench.exchange(&[("23 00 20 00 01 02 03 04", "60 00 20 00")]);
}

#[test]
fn after_a_timeout_in_a_download_late_segments_write_nothing() {
    let mut bench = downloading("C6 08 20 00 E8 03");
    for seqno in 1..=34 {
        answers(&mut bench, segment(seqno, false, &[9; 7]), "");
    }
    assert_eq!(hex(&bench.wait(PAUSE)), hex(&[frame("A2 22 7F")]));
    assert_eq!(hex(&bench.wait(TIMEOUT)), hex(&[frame("80 08 20 00 00 00 04 05")]));
    answers(&mut bench, segment(1, false, &[9; 7]), "");
    answers(&mut bench, segment(2, false, &[9; 7]), "");
    bench.exchange(&[("23 00 20 00 01 02 03 04", "60 00 20 00")]);
}

#[test]
fn a_new_client_is_served_after_a_reset_in_a_sub_block() {
    let mut bench = downloading("C6 08 20 00 E8 03");
    for seqno in 1..=10 {
        answers(&mut bench, segment(seqno, false, &[9; 7]), "");
    }
    bench.server.reset(&mut bench.objects);
    bench.exchange(&[("40 00 20 00", "43 00 20 00 78 56 34 12")]);
}

// Uploads.

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
fn an_upload_is_paced_by_the_bus() {
    let value = pattern(40 * 7);
    let (mut bench, sent) = uploading(&value, 127);
    assert_eq!(sent.len(), usize::from(WINDOW));
    assert!(bench.poll().is_empty(), "the bus has enough");
    let mut all = sent;
    all.extend(bench.left(1));
    assert_eq!(all.len(), 9);
    all.extend(bench.left(5));
    assert_eq!(all.len(), 14);
    while all.len() < 40 {
        let more = bench.left(8);
        assert!(!more.is_empty());
        all.extend(more);
    }
    assert_eq!(hex(&all), hex(&segments(&value, 0, 40)));
    assert!(bench.left(8).is_empty());
    answers(&mut bench, frame("A2 28 7F"), &hex(&[end(0, checksum(&value))])[0]);
}

/// Verifies: ECSS 6.1a
#[test]
fn the_block_size_may_change_between_sub_blocks() {
    let value = pattern(75);
    let (mut bench, sent) = uploading(&value, 4);
    assert_eq!(hex(&sent), hex(&segments(&value, 0, 4)));
    bench.left(4);
    assert_eq!(hex(&bench.ask(frame("A2 04 02"))), hex(&segments(&value, 4, 2)));
    assert_eq!(hex(&bench.ask(frame("A2 02 01"))), hex(&segments(&value, 6, 1)));
    assert_eq!(hex(&bench.ask(frame("A2 01 7F"))), hex(&segments(&value, 7, 4)));
    answers(&mut bench, frame("A2 04 01"), &hex(&[end(2, checksum(&value))])[0]);
    bench.exchange(&[("A1", "")]);
    assert!(!bench.server.is_busy());
}

/// Verifies: ECSS 6.1a
#[test]
fn what_was_not_acknowledged_is_sent_again() {
    let value = pattern(75);
    let (mut bench, _) = uploading(&value, 5);
    bench.left(5);
    assert_eq!(hex(&bench.ask(frame("A2 02 05"))), hex(&segments(&value, 2, 5)));
    bench.left(5);
    assert_eq!(hex(&bench.ask(frame("A2 00 06"))), hex(&segments(&value, 2, 6)));
    bench.left(6);
    assert_eq!(hex(&bench.ask(frame("A2 06 7F"))), hex(&segments(&value, 8, 3)));
    assert_eq!(hex(&bench.ask(frame("A2 02 7F"))), hex(&segments(&value, 10, 1)));
    answers(&mut bench, frame("A2 01 7F"), &hex(&[end(2, checksum(&value))])[0]);
}

#[test]
fn an_early_acknowledgement_ends_a_sub_block() {
    let value = pattern(300);
    let (mut bench, sent) = uploading(&value, 20);
    assert_eq!(sent.len(), 8);
    assert_eq!(bench.left(4).len(), 4);
    answers(&mut bench, frame("A2 03 14"), "");
    assert_eq!(hex(&bench.left(8)), hex(&segments(&value, 3, 8)), "when the bus has room");
}

#[test]
fn an_acknowledgement_or_a_start_that_comes_twice_is_ignored() {
    let value = pattern(300);
    let (mut bench, _) = uploading(&value, 20);
    bench.ignores(frame("A3"));
    let mut sent = 8;
    while sent < 20 {
        sent += bench.left(8).len();
    }
    assert_eq!(bench.ask(frame("A2 14 14")).len(), 8);
    bench.ignores(frame("A2 14 14"));
    assert!(bench.server.is_busy());

    // All of the next sub-block is on its way, but nothing can have arrived.
    let (mut bench, _) = uploading(&value, 5);
    bench.left(5);
    assert_eq!(hex(&bench.ask(frame("A2 05 05"))), hex(&segments(&value, 5, 5)));
    bench.ignores(frame("A2 05 05"));
    // What has arrived may be acknowledged before the controller tells that it left.
    bench.left(2);
    assert_eq!(hex(&bench.ask(frame("A2 05 05"))), hex(&segments(&value, 10, 5)));

    let (mut bench, _) = uploading(b"123456789", 20);
    bench.exchange(&[("A2 02 14", "D5 C3 31")]);
    bench.ignores(frame("A2 02 14"));
    bench.exchange(&[("A1", "")]);
}

#[test]
fn small_values_are_uploaded_without_blocks_when_the_client_says_so() {
    for (request, answer) in [
        ("A4 00 20 00 7F 04", "43 00 20 00 78 56 34 12"),
        ("A4 00 20 00 7F 03", "C6 00 20 00 04"),
        ("A4 04 20 00 7F 10", "41 04 20 00 10"),
        ("A4 04 20 00 7F 0F", "C6 04 20 00 10"),
        ("A4 0E 20 00 7F 01", "41 0E 20 00 00"),
        ("A4 0E 20 00 7F 00", "C6 0E 20 00 00"),
    ] {
        Bench::new().exchange(&[(request, answer)]);
    }
    Bench::new().exchange(&[("A4 04 20 00 7F 10", "41 04 20 00 10"), ("60", "00 45 43 53 53 2D 45 2D")]);
}

/// Verifies: ECSS 6.1a
#[test]
fn every_bad_block_upload_has_its_abort_code() {
    const BLOCK_SIZE: &str = "02 00 04 05";
    const SEQUENCE: &str = "03 00 04 05";
    const SPECIFIER: &str = "01 00 04 05";
    let begin = Some("A4 04 20 00 7F");
    type Row<'a> = (&'a str, Option<&'a str>, &'a [&'a str], &'a str, &'a str);
    let table: &[Row] = &[
        ("block size 0", None, &[], "A4 04 20 00 00", BLOCK_SIZE),
        ("block size 128", None, &[], "A4 04 20 00 80", BLOCK_SIZE),
        ("block size 255", None, &[], "A4 04 20 00 FF", BLOCK_SIZE),
        ("block size 0 of a small value", None, &[], "A4 04 20 00 00 20", BLOCK_SIZE),
        ("block size 0 in an acknowledgement", begin, &["A3"], "A2 01 00", BLOCK_SIZE),
        ("block size 128 in an acknowledgement", begin, &["A3"], "A2 01 80", BLOCK_SIZE),
        ("more acknowledged than sent", begin, &["A3"], "A2 04 7F", SEQUENCE),
        ("more acknowledged than there is", begin, &["A3"], "A2 FF 7F", SEQUENCE),
        ("acknowledged before the start", begin, &[], "A2 00 7F", SPECIFIER),
        ("ended before the start", begin, &[], "A1", SPECIFIER),
        ("ended before it is acknowledged", begin, &["A3"], "A1", SPECIFIER),
        ("an upload segment", begin, &["A3"], "60", SPECIFIER),
        ("a download segment", begin, &["A3"], "00", SPECIFIER),
        ("the end of a download", begin, &["A3"], "C1", SPECIFIER),
        ("unknown", begin, &["A3"], "E0", SPECIFIER),
        ("started anew later", begin, &["A3", "A2 01 7F"], "A3", SPECIFIER),
        ("started at the end", begin, &["A3", "A2 03 7F"], "A3", SPECIFIER),
        ("unknown at the end", begin, &["A3", "A2 03 7F"], "E0", SPECIFIER),
    ];
    for (what, begin, before, request, code) in table {
        let mut bench = Bench::new();
        if let Some(begin) = begin {
            bench.exchange(&[(begin, "C6 04 20 00 10")]);
        }
        for request in *before {
            assert!(!bench.ask(frame(request)).is_empty());
        }
        let answer = bench.ask(frame(request));
        assert_eq!(hex(&answer), hex(&[frame(&format!("80 04 20 00 {code}"))]), "{what}");
        assert!(!bench.server.is_busy(), "{what}");
    }
}

#[test]
fn an_upload_that_nobody_acknowledges_is_aborted() {
    let (mut bench, _) = uploading(&pattern(300), 127);
    bench.wait(PAUSE);
    bench.left(8);
    assert_eq!(bench.server.deadline(), Some(bench.now + TIMEOUT), "it goes on");
    assert_eq!(hex(&bench.wait(TIMEOUT)), hex(&[frame("80 08 20 00 00 00 04 05")]));
    assert!(!bench.server.is_busy());

    let (mut bench, _) = uploading(b"123456789", 20);
    bench.exchange(&[("A2 02 14", "D5 C3 31")]);
    assert_eq!(hex(&bench.wait(TIMEOUT)), hex(&[frame("80 08 20 00 00 00 04 05")]));
}

#[test]
fn a_domain_that_has_less_than_it_said_ends_a_block_upload() {
    let mut bench = Bench::new();
    bench.exchange(&[("A4 0B 20 00 7F", "C6 0B 20 00 64")]);
    let sent = bench.ask(frame("A3"));
    assert_eq!(sent.len(), 8);
    assert_eq!(hex(&sent[7..]), hex(&[frame("80 0B 20 00 20 00 00 08")]));

    let (mut bench, _) = uploading(&pattern(300), 127);
    bench.objects.set(DOMAIN, &[]);
    let sent = bench.left(8);
    assert_eq!(hex(&sent[2..]), hex(&[frame("80 08 20 00 20 00 00 08")]), "ten segments were read at once");
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
