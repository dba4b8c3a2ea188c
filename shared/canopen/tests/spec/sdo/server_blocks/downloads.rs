//! Block downloads: segments that are lost, repeated or late, and refusals.
//!
//! Verifies: ECSS 6.1a

use async_canopen::types::Duration;
use ecss_can_worlds::judge::sdo::checksum;

use super::{answers, downloading, end, segment};
use crate::sdo::fixture::{Bench, DOMAIN, PAUSE, TIMEOUT, frame, hex, pattern};

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
    assert!(bench.objects.largest_part <= 264);
}

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
fn client_that_restarts_in_a_sub_block_is_served_in_the_end() {
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

/// Each script is a download of [`DOMAIN`] that fails at its last frame.
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
        ("C6 07 20 00 01 01", "80 07 20 00 05 00 04 05"),
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
            bench.server.reset(&mut bench.objects);
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

/// A client that repeats a segment which does not count holds the server no longer than one that sends nothing.
#[test]
fn segments_that_bring_nothing_do_not_keep_a_download_alive() {
    let mut bench = downloading("C6 08 20 00 E8 03 00 00");
    let stray = segment(5, false, &[0; 7]);
    let mut answers = vec![];
    for _ in 0..20 * 127 {
        if bench.server.deadline().is_some() {
            answers.extend(bench.ask(stray));
            answers.extend(bench.wait(Duration::from_millis(1)));
        }
    }
    assert_eq!(bench.server.deadline(), None, "it still waits");
    assert_eq!(hex(&answers), hex(&[frame("A2 00 7F"), frame("80 08 20 00 00 00 04 05")]));
    assert_eq!(bench.objects.changes, []);
}
