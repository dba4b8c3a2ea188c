//! Block uploads: their pace, segments that are sent again, and failures.
//!
//! Verifies: ECSS 6.1a

use async_canopen::sdo::machine::WINDOW;
use ecss_can_worlds::judge::sdo::checksum;

use super::{answers, end, segments, uploading};
use crate::sdo::fixture::{Bench, DOMAIN, PAUSE, TIMEOUT, frame, hex, pattern};

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

/// Verifies: ECSS 11.1b
/// Notices: ECSS 11.1b: a value as long as the threshold is uploaded in blocks.
#[test]
fn small_values_are_uploaded_without_blocks_on_client_request() {
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

#[test]
fn a_domain_that_has_less_than_it_said_ends_a_block_upload() {
    let mut bench = Bench::new();
    bench.exchange(&[("A4 0B 20 00 7F", "C6 0B 20 00 64")]);
    let sent = bench.ask(frame("A3"));
    assert_eq!(sent.len(), 8);
    assert_eq!(hex(&sent[7..]), hex(&[frame("80 0B 20 00 20 00 00 08")]));

    let (mut bench, _) = uploading(&pattern(300), 127);
    bench.objects.set(DOMAIN, &[]);
    let sent: Vec<_> = (0..4).flat_map(|_| bench.left(8)).collect();
    assert_eq!(hex(&sent[29..]), hex(&[frame("80 08 20 00 20 00 00 08")]), "37 segments were read at once");
}
