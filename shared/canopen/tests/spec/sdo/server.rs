//! The server: expedited and segmented transfers, refusals, what ends a transfer.
//!
//! Verifies: ECSS 6.1a

use async_canopen::types::{Address, Duration, Instant};

use super::fixture::{Bench, CONST, DOMAIN, PAUSE, TEXT, TIMEOUT, U8, U32, frame, hex, pattern};

#[test]
fn values_of_one_to_four_bytes_are_uploaded_expedited() {
    for (request, response) in [
        ("40 01 20 00", "4F 01 20 00 5A 00 00 00"),
        ("40 02 20 00", "4B 02 20 00 34 12 00 00"),
        ("40 03 20 05", "47 03 20 05 01 02 03 00"),
        ("40 00 20 00", "43 00 20 00 78 56 34 12"),
    ] {
        Bench::new().exchange(&[(request, response)]);
    }
}

#[test]
fn values_of_one_to_four_bytes_are_downloaded_expedited() {
    for (request, response, value) in [
        ("2F 01 20 00 11 22 33 44", "60 01 20 00", &[0x11][..]),
        ("2B 02 20 00 11 22 33 44", "60 02 20 00", &[0x11, 0x22]),
        ("27 03 20 05 11 22 33 44", "60 03 20 05", &[0x11, 0x22, 0x33]),
        ("23 00 20 00 11 22 33 44", "60 00 20 00", &[0x11, 0x22, 0x33, 0x44]),
        ("2F 08 20 00 11 22 33 44", "60 08 20 00", &[0x11]),
    ] {
        let mut bench = Bench::new();
        bench.exchange(&[(request, response)]);
        assert_eq!(bench.objects.changes.len(), 1);
        assert_eq!(bench.objects.changes[0].1, value);
        assert!(!bench.server.is_busy());
    }
}

#[test]
fn expedited_download_without_size_has_the_size_of_the_object() {
    for (request, response, value) in [
        ("22 01 20 00 11 22 33 44", "60 01 20 00", &[0x11][..]),
        ("22 02 20 00 11 22 33 44", "60 02 20 00", &[0x11, 0x22]),
        ("22 00 20 00 11 22 33 44", "60 00 20 00", &[0x11, 0x22, 0x33, 0x44]),
        ("22 04 20 00 11 22 33 44", "60 04 20 00", &[0x11, 0x22, 0x33, 0x44]),
        ("22 0E 20 00 11 22 33 44", "60 0E 20 00", &[0x11, 0x22, 0x33]),
    ] {
        let mut bench = Bench::new();
        bench.exchange(&[(request, response)]);
        assert_eq!(bench.objects.changes[0].1, value, "{request}");
    }
}

#[test]
fn longer_values_are_uploaded_in_segments_with_the_size_first() {
    let mut bench = Bench::new();
    bench.exchange(&[
        ("40 04 20 00", "41 04 20 00 10 00 00 00"),
        ("60", "00 45 43 53 53 2D 45 2D"),
        ("70", "10 53 54 2D 35 30 2D 31"),
        ("60", "0B 35 43 00 00 00 00 00"),
    ]);
    assert!(!bench.server.is_busy());
}

#[test]
fn longer_values_are_downloaded_in_segments_and_written_at_once() {
    let mut bench = Bench::new();
    bench.exchange(&[
        ("21 04 20 00 09 00 00 00", "60 04 20 00"),
        ("00 61 62 63 64 65 66 67", "20"),
        ("1B 68 69 FF FF FF FF FF", "30"),
    ]);
    assert_eq!(bench.objects.changes, [(TEXT, b"abcdefghi".to_vec())]);
    assert!(!bench.server.is_busy());
}

#[test]
fn a_download_need_not_tell_its_size() {
    let mut bench = Bench::new();
    bench.exchange(&[
        ("20 04 20 00", "60 04 20 00"),
        ("00 61 62 63 64 65 66 67", "20"),
        ("11 68 69 6A 6B 6C 6D 6E", "30"),
    ]);
    assert_eq!(bench.objects.changes, [(TEXT, b"abcdefghijklmn".to_vec())]);
}

#[test]
fn an_empty_value_is_one_empty_segment() {
    let mut bench = Bench::new();
    bench.exchange(&[("40 0E 20 00", "41 0E 20 00"), ("60", "0F")]);
    bench.exchange(&[("21 04 20 00", "60 04 20 00"), ("0F", "20")]);
    assert_eq!(bench.objects.changes, [(TEXT, vec![])]);
    bench.exchange(&[("21 08 20 00", "60 08 20 00"), ("0F", "20")]);
    assert_eq!(bench.objects.changes[1], (DOMAIN, vec![]));
}

#[test]
fn a_domain_passes_in_parts() {
    let value = pattern(1_000);
    let mut bench = Bench::new();
    bench.exchange(&[("21 08 20 00 E8 03 00 00", "60 08 20 00")]);
    for (at, part) in value.chunks(7).enumerate() {
        let mut segment = [0; 8];
        let is_last = part.len() < 7;
        segment[0] = (at as u8 & 1) << 4 | (7 - part.len() as u8) << 1 | u8::from(is_last);
        segment[1..=part.len()].copy_from_slice(part);
        let answer = bench.ask(segment);
        assert_eq!(answer, [[0x20 | (at as u8 & 1) << 4, 0, 0, 0, 0, 0, 0, 0]]);
    }
    assert_eq!(bench.objects.value(DOMAIN), value);
    let mut back: Vec<u8> = vec![];
    bench.exchange(&[("40 08 20 00", "41 08 20 00 E8 03 00 00")]);
    for at in 0..143 {
        let answer = bench.ask([0x60 | (at & 1) << 4, 0, 0, 0, 0, 0, 0, 0])[0];
        assert_eq!(answer[0] >> 4, at & 1);
        assert_eq!(answer[0] & 1 == 1, at == 142);
        back.extend(&answer[1..8 - usize::from(answer[0] >> 1 & 7)]);
    }
    assert_eq!(back, value);
    assert!(bench.objects.largest_part <= 264, "nobody needs the value in memory twice");
}

#[test]
fn an_upload_of_a_value_is_consistent() {
    let mut bench = Bench::new();
    bench.exchange(&[("40 04 20 00", "41 04 20 00 10 00 00 00")]);
    bench.objects.set(TEXT, b"something else, and longer");
    bench.exchange(&[
        ("60", "00 45 43 53 53 2D 45 2D"),
        ("70", "10 53 54 2D 35 30 2D 31"),
        ("60", "0B 35 43"),
    ]);
}

#[test]
fn a_value_of_64_bytes_is_moved_whole() {
    let mut bench = Bench::new();
    bench.exchange(&[("21 04 20 00 40 00 00 00", "60 04 20 00")]);
    for at in 0..10 {
        let command = (at & 1) << 4 | if at == 9 { 0x0D } else { 0 };
        let answer = bench.ask([command, at, at, at, at, at, at, at]);
        assert_eq!(answer, [[0x20 | (at & 1) << 4, 0, 0, 0, 0, 0, 0, 0]]);
        assert_eq!(bench.objects.changes.is_empty(), at < 9, "written at the end");
    }
    assert_eq!(bench.objects.value(TEXT).len(), 64);
}

/// Each script ends with a request that is refused; nothing is written, no transfer is left.
///
/// Verifies: ECSS 11.1a
/// Notices: ECSS 6.1a: the first segment of an upload is sent whatever its toggle bit.
/// Notices: ECSS 11.1a: a segment with a wrong toggle bit is ignored without an abort.
#[test]
fn every_bad_request_has_its_abort_code() {
    const TOGGLE: &str = "00 00 03 05";
    const SPECIFIER: &str = "01 00 04 05";
    const TOO_LONG: &str = "12 00 07 06";
    const TOO_SHORT: &str = "13 00 07 06";
    const OUT_OF_MEMORY: &str = "05 00 04 05";
    let upload_text = ("40 04 20 00", "41 04 20 00 10");
    let download_text = ("21 04 20 00 09", "60 04 20 00");
    let download_domain = ("21 08 20 00 09", "60 08 20 00");
    let download_unsized = ("20 04 20 00", "60 04 20 00");
    // 36 segments, 252 bytes, fit into 256.
    let segments = (0..36).map(|at| if at % 2 == 0 { ("00", "20") } else { ("10", "30") });
    let too_large: Vec<_> = [("20 07 20 00", "60 07 20 00")].into_iter().chain(segments).collect();
    type Script<'a> = (&'a str, &'a [(&'a str, &'a str)], &'a str, &'a str, &'a str);
    let table: &[Script] = &[
        // What the dictionary refuses.
        ("no such object, upload", &[], "40 FF 2F 00", "FF 2F 00", "00 00 02 06"),
        ("no such object, download", &[], "2F FF 2F 00 01", "FF 2F 00", "00 00 02 06"),
        ("no such object, segmented", &[], "21 FF 2F 00 10", "FF 2F 00", "00 00 02 06"),
        ("no such object, block upload", &[], "A4 FF 2F 00 7F", "FF 2F 00", "00 00 02 06"),
        ("no such object, block download", &[], "C6 FF 2F 00 10", "FF 2F 00", "00 00 02 06"),
        ("no such sub-index", &[], "40 00 20 07", "00 20 07", "11 00 09 06"),
        ("no such sub-index, download", &[], "23 00 20 07", "00 20 07", "11 00 09 06"),
        ("write-only, upload", &[], "40 06 20 00", "06 20 00", "01 00 01 06"),
        ("write-only, block upload", &[], "A4 06 20 00 7F", "06 20 00", "01 00 01 06"),
        ("read-only, download", &[], "23 05 20 00", "05 20 00", "02 00 01 06"),
        ("read-only, segmented", &[], "21 05 20 00 10", "05 20 00", "02 00 01 06"),
        ("read-only, block download", &[], "C2 05 20 00 10", "05 20 00", "02 00 01 06"),
        ("no data", &[], "40 0D 20 00", "0D 20 00", "24 00 00 08"),
        ("value too low", &[], "2F 09 20 00 00", "09 20 00", "32 00 09 06"),
        ("value too high", &[], "2F 09 20 00 0A", "09 20 00", "31 00 09 06"),
        ("less than the object says", &[], "40 0F 20 00", "0F 20 00", "20 00 00 08"),
        ("refused at the end", &[("21 0C 20 00 01", "60 0C 20 00")], "0D 01", "0C 20 00", "22 00 00 08"),
        // Lengths.
        ("expedited too long", &[], "23 02 20 00 01 02 03 04", "02 20 00", TOO_LONG),
        ("expedited longer than the object takes", &[], "2B 09 20 00 01 02", "09 20 00", TOO_LONG),
        ("expedited too long for a domain", &[], "23 0E 20 00 01 02 03 04", "0E 20 00", TOO_LONG),
        ("expedited too short", &[], "2B 00 20 00 01 02 03 04", "00 20 00", TOO_SHORT),
        ("told too long", &[], "21 04 20 00 65", "04 20 00", TOO_LONG),
        ("told too long for a domain", &[], "21 08 20 00 89 13", "08 20 00", TOO_LONG),
        ("told beyond all bounds", &[], "21 08 20 00 FF FF FF FF", "08 20 00", TOO_LONG),
        ("told too short", &[], "21 00 20 00 03", "00 20 00", TOO_SHORT),
        ("too large to move whole, download", &[], "21 07 20 00 01 01", "07 20 00", OUT_OF_MEMORY),
        ("too large to move whole, upload", &[], "40 07 20 00", "07 20 00", OUT_OF_MEMORY),
        ("too large to move whole, block", &[], "A4 07 20 00 7F", "07 20 00", OUT_OF_MEMORY),
        ("more than told", &[download_text, ("00", "20")], "11", "04 20 00", TOO_LONG),
        ("more than told in a domain", &[download_domain, ("00", "20")], "11", "08 20 00", TOO_LONG),
        ("more than told, not last", &[download_text, ("00", "20")], "10", "04 20 00", TOO_LONG),
        ("less than told", &[download_text], "01", "04 20 00", TOO_SHORT),
        ("less than told in a domain", &[download_domain], "01", "08 20 00", TOO_SHORT),
        ("size not told, too short", &[("20 00 20 00", "60 00 20 00")], "09", "00 20 00", TOO_SHORT),
        ("size not told, too long", &[("20 00 20 00", "60 00 20 00")], "01", "00 20 00", TOO_LONG),
        // Toggle.
        ("upload begins with toggle 1", &[upload_text], "70", "04 20 00", TOGGLE),
        ("upload segment twice", &[upload_text, ("60", "00 45 43 53 53 2D 45 2D")], "60", "04 20 00", TOGGLE),
        ("download begins with toggle 1", &[download_text], "10", "04 20 00", TOGGLE),
        ("download segment twice", &[download_text, ("00", "20")], "00", "04 20 00", TOGGLE),
        ("domain segment twice", &[download_domain, ("00", "20")], "00", "08 20 00", TOGGLE),
        // Command specifiers.
        ("unknown", &[], "E0", "00 00 00", SPECIFIER),
        ("unknown, all bits", &[], "FF", "00 00 00", SPECIFIER),
        ("download segment without transfer", &[], "00 11 22 33", "00 00 00", SPECIFIER),
        ("upload segment without transfer", &[], "60", "00 00 00", SPECIFIER),
        ("block upload start without transfer", &[], "A3", "00 00 00", SPECIFIER),
        ("block upload ack without transfer", &[], "A2 01 7F", "00 00 00", SPECIFIER),
        ("block upload end without transfer", &[], "A1", "00 00 00", SPECIFIER),
        ("block download end without transfer", &[], "C1", "00 00 00", SPECIFIER),
        ("unknown in an upload", &[upload_text], "E0", "04 20 00", SPECIFIER),
        ("unknown in a download", &[download_domain], "E0", "08 20 00", SPECIFIER),
        ("download segment in an upload", &[upload_text], "00", "04 20 00", SPECIFIER),
        ("upload segment in a download", &[download_domain], "60", "08 20 00", SPECIFIER),
        ("block frames in an upload", &[upload_text], "A3", "04 20 00", SPECIFIER),
        ("block frames in a download", &[download_text], "C1", "04 20 00", SPECIFIER),
        ("size not told, too large to move whole", &too_large, "00", "07 20 00", OUT_OF_MEMORY),
        (
            "size not told, beyond the most",
            &[
                download_unsized,
                ("00", "20"),
                ("10", "30"),
                ("00", "20"),
                ("10", "30"),
                ("00", "20"),
                ("10", "30"),
                ("00", "20"),
                ("10", "30"),
                ("00", "20"),
            ],
            "10",
            "04 20 00",
            TOO_LONG,
        ),
    ];
    for (what, before, request, at, code) in table {
        let mut bench = Bench::new();
        bench.exchange(before);
        let answer = bench.ask(frame(request));
        assert_eq!(hex(&answer), hex(&[frame(&format!("80 {at} {code}"))]), "{what}");
        assert!(bench.objects.changes.is_empty(), "{what}");
        assert!(!bench.objects.is_open(), "{what}");
        assert!(!bench.server.is_busy(), "{what}");
        bench.exchange(&[("40 00 20 00", "43 00 20 00 78 56 34 12")]);
    }
}

#[test]
fn a_domain_that_fails_while_it_is_written_ends_the_transfer() {
    let mut bench = Bench::new();
    bench.exchange(&[("20 0A 20 00", "60 0A 20 00")]);
    let mut answers = vec![];
    for at in 0..60_u8 {
        answers.extend(bench.ask([(at & 1) << 4, 0, 0, 0, 0, 0, 0, 0]));
        if !bench.server.is_busy() {
            break;
        }
    }
    assert_eq!(answers.pop(), Some(frame("80 0A 20 00 00 00 06 06")));
    assert!(!bench.objects.is_open());
}

#[test]
fn a_domain_that_has_less_than_it_said_ends_the_transfer() {
    let mut bench = Bench::new();
    bench.exchange(&[("40 0B 20 00", "41 0B 20 00 64")]);
    let answers: Vec<_> =
        (0..8).flat_map(|at: u8| bench.ask([0x60 | (at & 1) << 4, 0, 0, 0, 0, 0, 0, 0])).collect();
    assert_eq!(answers[7], frame("80 0B 20 00 20 00 00 08"));
    assert!(!bench.server.is_busy());
}

#[test]
fn an_abort_by_the_client_ends_a_transfer_without_an_answer() {
    for begin in ["40 04 20 00", "21 04 20 00 09", "21 08 20 00 09", "C6 08 20 00 09", "A4 08 20 00 7F"] {
        let mut bench = Bench::new();
        bench.ask(frame(begin));
        assert!(bench.server.is_busy());
        let abort = frame("80 08 20 00 00 00 00 08");
        assert!(bench.server.on_request(&abort, bench.now, &mut bench.objects, &mut |_| panic!("answered")));
        assert!(!bench.server.is_busy(), "{begin}");
        assert!(!bench.objects.is_open());
        assert!(bench.objects.changes.is_empty());
        bench.exchange(&[("60", "80 00 00 00 01 00 04 05")]);
    }
}

#[test]
fn an_abort_without_a_transfer_is_ignored() {
    Bench::new().ignores(frame("80 00 20 00 00 00 04 05"));
}

#[test]
fn a_client_that_begins_anew_is_served() {
    for begin in ["40 04 20 00", "21 04 20 00 09", "21 08 20 00 09", "A4 08 20 00 7F"] {
        for (again, answer) in [
            ("40 00 20 00", "43 00 20 00 78 56 34 12"),
            ("2F 01 20 00 07", "60 01 20 00"),
            ("21 08 20 00 09", "60 08 20 00"),
            ("C6 08 20 00 09", "A4 08 20 00 7F"),
            ("A4 08 20 00 7F", "C6 08 20 00 64"),
        ] {
            let mut bench = Bench::new();
            bench.ask(frame(begin));
            bench.exchange(&[(again, answer)]);
        }
    }
}

#[test]
fn a_transfer_that_stands_still_is_aborted() {
    for (begin, at) in [
        ("40 04 20 00", "04 20 00"),
        ("21 04 20 00 09", "04 20 00"),
        ("21 08 20 00 09", "08 20 00"),
        ("C6 08 20 00 09", "08 20 00"),
        ("A4 08 20 00 7F", "08 20 00"),
    ] {
        let mut bench = Bench::new();
        bench.ask(frame(begin));
        assert_eq!(bench.server.deadline(), Some(bench.now + TIMEOUT));
        assert!(bench.wait(Duration::from_micros(TIMEOUT.as_micros() - 1)).is_empty());
        let sent = bench.wait(Duration::from_micros(1));
        assert_eq!(hex(&sent), hex(&[frame(&format!("80 {at} 00 00 04 05"))]));
        assert_eq!(bench.server.deadline(), None);
        assert!(!bench.objects.is_open());
        assert!(bench.wait(TIMEOUT).is_empty());
    }
}

#[test]
fn every_segment_starts_the_timeout_anew() {
    let mut bench = Bench::new();
    bench.exchange(&[("40 04 20 00", "41 04 20 00 10")]);
    assert!(bench.wait(PAUSE).is_empty());
    bench.exchange(&[("60", "00 45 43 53 53 2D 45 2D")]);
    assert_eq!(bench.server.deadline(), Some(bench.now + TIMEOUT));
}

#[test]
fn without_a_transfer_there_is_no_deadline() {
    let mut bench = Bench::new();
    assert_eq!(bench.server.deadline(), None);
    bench.exchange(&[("40 00 20 00", "43 00 20 00 78 56 34 12")]);
    assert_eq!(bench.server.deadline(), None);
    bench.now = Instant::NEVER;
    assert!(bench.poll().is_empty());
}

#[test]
fn a_reset_ends_a_transfer_without_a_word() {
    let mut bench = Bench::new();
    bench.exchange(&[("21 08 20 00 09", "60 08 20 00"), ("00", "20")]);
    bench.server.reset(&mut bench.objects);
    assert_eq!(bench.objects.cancelled, 1);
    assert!(!bench.server.is_busy());
    assert!(bench.wait(TIMEOUT).is_empty());
}

#[test]
fn a_change_of_bus_is_told_to_the_client() {
    let mut bench = Bench::new();
    let mut sent = vec![];
    bench.server.on_bus_changed(Instant::ZERO, &mut bench.objects, &mut |payload| sent.push(payload));
    assert!(sent.is_empty(), "there is nothing to abort");
    bench.exchange(&[("21 08 20 00 09", "60 08 20 00")]);
    bench.server.on_bus_changed(Instant::ZERO, &mut bench.objects, &mut |payload| sent.push(payload));
    assert_eq!(hex(&sent), hex(&[frame("80 08 20 00 22 00 00 08")]));
    assert_eq!(bench.objects.cancelled, 1);
}

#[test]
fn a_request_after_a_change_of_bus_is_no_segment_of_before() {
    let mut bench = Bench::new();
    bench.exchange(&[("C6 08 20 00 E8 03", "A4 08 20 00 7F")]);
    for seqno in 1..=62 {
        assert!(bench.ask([seqno, 9, 9, 9, 9, 9, 9, 9]).is_empty());
    }
    bench.server.on_bus_changed(Instant::ZERO, &mut bench.objects, &mut |_| {});
    // 40h could be the 64th segment.
    bench.exchange(&[("40 00 20 00", "43 00 20 00 78 56 34 12")]);
}

#[test]
fn reserved_bits_are_not_looked_at() {
    let mut bench = Bench::new();
    bench.exchange(&[("5F 01 20 00 FF FF FF FF", "4F 01 20 00 5A"), ("3F 01 20 00 07", "60 01 20 00")]);
    assert_eq!(bench.objects.value(U8), [7]);
    assert_eq!(bench.objects.value(U32), [0x78, 0x56, 0x34, 0x12]);
    assert_eq!(bench.objects.value(CONST), [1, 0, 0, 0]);
    assert_eq!(Address::new(0x2008, 0), DOMAIN);
}

/// A segment without data is the last one or none: a client that sends nothing else would hold the server for ever.
#[test]
fn an_empty_segment_that_is_not_the_last_ends_a_download() {
    for initiate in ["21 08 20 00 09", "20 08 20 00", "21 04 20 00 09", "20 04 20 00"] {
        let mut bench = Bench::new();
        let object = &initiate[3..11];
        bench.exchange(&[(initiate, &format!("60 {object}")), ("00 01 02 03 04 05 06 07", "20")]);
        bench.exchange(&[("1E", &format!("80 {object} 13 00 07 06"))]);
        assert_eq!(bench.server.deadline(), None);
        assert_eq!(bench.objects.changes, []);
    }
}
