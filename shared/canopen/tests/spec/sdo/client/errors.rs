//! Transfers of the client that fail, are cancelled, or never were.
//!
//! Verifies: ECSS 6.1a

use async_canopen::sdo::Error;
use async_canopen::sdo::Mode;
use async_canopen::sdo::machine::{Client, WINDOW};
use async_canopen::types::{AbortCode, Address, Instant};

use super::{AT, Bench, frames};
use crate::sdo::fixture::{PAUSE, TIMEOUT, frame, hex, pattern};

#[test]
fn aborts_reach_the_application() {
    for (response, error) in [
        ("80 00 20 01 00 00 02 06", Error::Abort(AbortCode::NoObject)),
        ("80 00 20 01 24 00 00 08", Error::Abort(AbortCode::NoData)),
        ("80 00 20 01 78 56 34 12", Error::UnknownAbort(0x1234_5678)),
        ("80 00 00 00 01 00 04 05", Error::Abort(AbortCode::CommandSpecifier)),
    ] {
        let mut bench = Bench::uploading(4, Mode::Segmented);
        bench.exchange("40 00 20 01", &[(response, "")]);
        assert_eq!(bench.read(), Some(Err(error)));
        let mut bench = Bench::downloading(&pattern(500), Mode::Block);
        bench.poll();
        assert_eq!(bench.answer(frame("A4 00 20 01 7F")).len(), usize::from(WINDOW));
        bench.go_on(&[(response, "")]);
        assert_eq!(bench.client.outcome(), Some(Err(error)));
        let mut bench = Bench::uploading(500, Mode::Block);
        bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 64", "A3"), ("01", ""), (response, "")]);
        assert_eq!(bench.read(), Some(Err(error)));
    }
}

#[test]
fn every_error_has_the_code_that_went_over_the_wire() {
    for (error, code) in [
        (Error::Abort(AbortCode::NoObject), 0x0602_0000),
        (Error::UnknownAbort(0x1234_5678), 0x1234_5678),
        (Error::Timeout, 0x0504_0000),
        (Error::Protocol(AbortCode::Crc), 0x0504_0004),
        (Error::TooLarge, 0x0504_0005),
        (Error::BusChanged, 0x0800_0022),
    ] {
        assert_eq!(error.code(), code);
    }
}

#[test]
fn only_the_first_answer_says_that_a_server_knows_no_blocks() {
    let mut bench = Bench::uploading(9, Mode::Auto);
    bench.exchange("A4 00 20 01 7F 1C", &[("C6 00 20 01 09", "A3"), ("80 00 20 01 01 00 04 05", "")]);
    assert_eq!(bench.read(), Some(Err(Error::Abort(AbortCode::CommandSpecifier))));
}

/// Answers of a server to an earlier transfer with another object, or with another sub-index, that timed out.
const LATE: [&str; 12] = [
    "43 00 10 00 91 01",
    "4F 00 20 02 09",
    "42 01 20 01 09",
    "41 00 10 00 09",
    "40 00 21 01",
    "60 10 10 01",
    "60 00 20 00",
    "A4 00 63 00 7F",
    "A0 00 20 02 7F",
    "C6 00 63 00 09",
    "C0 01 20 01",
    "80 10 10 01 00 00 04 05",
];

/// Frames of an earlier transfer that name no object: segments in and outside of blocks, their acknowledgements, ends of blocks, and
/// what no server sends.
const LATE_WITHOUT_NAME: [&str; 16] = [
    "00 01 02 03 04 05 06 07",
    "10 01 02 03 04 05 06 07",
    "0B 01 02",
    "20",
    "30",
    "A2 05 7F",
    "A2 00 00",
    "A1",
    "C1",
    "D5 12 34",
    "01 01 02 03 04 05 06 07",
    "7F 01 02 03 04 05 06 07",
    "81 01 02 03 04 05 06 07",
    "FF 01 02 03 04 05 06 07",
    "A3",
    "E0",
];

/// A transfer of each kind with its answers, the first one first. `true`: a sub-block of an upload follows, in which each frame but an
/// abort is a segment.
type Transfer = (&'static str, fn() -> Bench, &'static [(&'static str, bool)]);

const VALUE: &[u8] = b"123456789";

const TRANSFERS: [Transfer; 8] = [
    ("upload", || Bench::uploading(9, Mode::Segmented), &[("43 00 20 01 31 32 33 34", false)]),
    (
        "segmented upload",
        || Bench::uploading(9, Mode::Segmented),
        &[("41 00 20 01 09", false), ("00 31 32 33 34 35 36 37", false), ("1B 38 39", false)],
    ),
    ("download", || Bench::downloading(&VALUE[..4], Mode::Segmented), &[("60 00 20 01", false)]),
    (
        "segmented download",
        || Bench::downloading(VALUE, Mode::Segmented),
        &[("60 00 20 01", false), ("20", false), ("30", false)],
    ),
    (
        "block upload",
        || Bench::uploading(9, Mode::Block),
        &[
            ("C6 00 20 01 09", true),
            ("01 31 32 33 34 35 36 37", true),
            ("82 38 39", false),
            ("D5 C3 31", false),
        ],
    ),
    (
        "block upload, answered in segments",
        || Bench::uploading(9, Mode::Auto),
        &[("41 00 20 01 09", false), ("00 31 32 33 34 35 36 37", false), ("1B 38 39", false)],
    ),
    (
        "block download",
        || Bench::downloading(VALUE, Mode::Block),
        &[("A4 00 20 01 7F", false), ("A2 02 7F", false), ("A1", false)],
    ),
    (
        "download by a server without blocks",
        || Bench::downloading(&[b'x'; 30], Mode::Auto),
        &[
            ("80 00 20 01 01 00 04 05", false),
            ("60 00 20 01", false),
            ("20", false),
            ("30", false),
            ("20", false),
            ("30", false),
            ("20", false),
        ],
    ),
];

impl Bench {
    /// Answers of an earlier transfer change nothing: nothing is sent, and the transfer waits no longer.
    #[track_caller]
    fn ignores_each(&mut self, late: &[&str]) {
        let deadline = self.client.deadline();
        for payload in late {
            self.ignores(frame(payload));
            assert!(self.poll().is_empty(), "{payload}");
            assert_eq!(self.client.deadline(), deadline, "{payload}");
        }
    }
}

/// Given a transfer of any kind, when answers of earlier transfers come before any of its answers, then they are ignored. After the
/// first own answer, the client cannot distinguish a late answer that names no object from its own.
#[test]
fn late_answers_of_an_earlier_transfer_are_ignored() {
    for (what, begin, answers) in TRANSFERS {
        let mut bench = begin();
        let mut read: Vec<u8> = vec![];
        let mut is_sub_block = false;
        assert_eq!(bench.poll().len(), 1, "{what}");
        bench.ignores_each(&LATE_WITHOUT_NAME);
        for (answer, begins_sub_block) in answers {
            if !is_sub_block {
                bench.ignores_each(&LATE);
            }
            is_sub_block = *begins_sub_block;
            assert!(bench.client.on_response(&frame(answer), bench.now, &mut |_| {}), "{what}: {answer}");
            let mut part = [0; 9];
            let count = bench.client.pull(&mut part);
            read.extend(&part[..count]);
            bench.left(10);
        }
        let outcome = bench.client.outcome();
        let len = outcome.and_then(Result::ok).unwrap_or_else(|| panic!("{what}: {outcome:?}"));
        if what.contains("upload") {
            assert_eq!(read, VALUE[..len], "{what}");
        }
    }
}

/// Given a first transfer of each kind that times out, when its answer comes while the next one with another object waits, then the
/// next one has its own answer.
#[test]
fn transfer_after_a_time_out_has_its_own_answer() {
    for (what, begin, answers) in TRANSFERS {
        for before in 0..answers.len() {
            let mut bench = begin();
            bench.poll();
            for (answer, _) in &answers[..before] {
                bench.client.on_response(&frame(answer), bench.now, &mut |_| {});
                bench.client.pull(&mut [0; 9]);
                bench.left(10);
            }
            while bench.client.outcome().is_none() {
                bench.wait(TIMEOUT);
            }
            bench.client.start_upload(Address::new(0x1018, 1), 4, Mode::Segmented);
            assert_eq!(bench.poll().len(), 1, "{what}");
            for (late, _) in &answers[before..] {
                bench.ignores(frame(late));
            }
            bench.go_on(&[("43 18 10 01 55 01", "")]);
            assert_eq!(bench.read(), Some(Ok(vec![0x55, 1, 0, 0])), "{what}, after {before} answers");
        }
    }
}

/// Each script ends with an answer that does not belong; the server is told why.
#[test]
fn every_bad_answer_has_its_abort_code() {
    use AbortCode::{BlockSize, CommandSpecifier, Crc, SequenceNumber, Toggle, TooLong, TooShort};
    let up = || Bench::uploading(20, Mode::Segmented);
    let down = || Bench::downloading(b"12345", Mode::Segmented);
    let write = || Bench::downloading(b"1", Mode::Segmented);
    let block_up = || Bench::uploading(20, Mode::Block);
    let block_down = || Bench::downloading(b"123456789", Mode::Block);
    const NINE: &str = "41 00 20 01 09";
    const SIZE: &str = "C6 00 20 01 09";
    const OK: &str = "60 00 20 01";
    const GRANTED: &str = "A4 00 20 01 7F";
    const ONE: &str = "01 31 32 33 34 35 36 37";
    const TWO: &str = "82 38 39";
    const FIRST: &str = "00 31 32 33 34 35 36 37";
    type Row<'a> = (&'a str, Bench, &'a [&'a str], &'a str, AbortCode);
    let table: Vec<Row> = vec![
        ("upload: answer of a download", up(), &[], OK, CommandSpecifier),
        ("upload: answer of a block upload", up(), &[], SIZE, CommandSpecifier),
        ("upload: unknown", up(), &[], "E0 00 20 01", CommandSpecifier),
        ("upload: toggle", up(), &[NINE], "10", Toggle),
        ("upload: toggle of the second", up(), &[NINE, FIRST], "0B", Toggle),
        ("upload: more than told", up(), &[NINE, FIRST], "19", TooLong),
        ("upload: more than told, not last", up(), &[NINE, FIRST], "18", TooLong),
        ("upload: less than told", up(), &[NINE], "01", TooShort),
        ("upload: initiate twice", up(), &[NINE], NINE, CommandSpecifier),
        ("upload: answer of a download segment", up(), &[NINE], "20", CommandSpecifier),
        ("download: answer of an upload", write(), &[], "43 00 20 01", CommandSpecifier),
        ("download: answer of a block download", down(), &[], GRANTED, CommandSpecifier),
        ("download: toggle", down(), &[OK], "30", Toggle),
        ("download: upload segment", down(), &[OK], "00", CommandSpecifier),
        ("download: acknowledgement", down(), &[OK], "A2 01 7F", CommandSpecifier),
        ("download: unknown", down(), &[OK], "FF", CommandSpecifier),
        ("block upload: answer of a download", block_up(), &[], OK, CommandSpecifier),
        ("block upload: more than told", block_up(), &[SIZE, ONE], "02", TooLong),
        ("block upload: checksum", block_up(), &[SIZE, ONE, TWO], "D5 C3 30", Crc),
        ("block upload: unused one less", block_up(), &[SIZE, ONE, TWO], "D1 C3 31", TooLong),
        ("block upload: unused one more", block_up(), &[SIZE, ONE, TWO], "D9 C3 31", TooShort),
        ("block upload: another frame at the end", block_up(), &[SIZE, ONE, TWO], "A1", CommandSpecifier),
        ("block upload: segment at the end", block_up(), &[SIZE, ONE, TWO], "03", CommandSpecifier),
        ("block download: answer of a download", block_down(), &[], OK, CommandSpecifier),
        ("block download: block size 0", block_down(), &[], "A4 00 20 01 00", BlockSize),
        ("block download: block size 128", block_down(), &[], "A4 00 20 01 80", BlockSize),
        ("block download: next block size 0", block_down(), &[GRANTED], "A2 01 00", BlockSize),
        ("block download: next block size 128", block_down(), &[GRANTED], "A2 01 80", BlockSize),
        ("block download: more acknowledged than sent", block_down(), &[GRANTED], "A2 03 7F", SequenceNumber),
        ("block download: end before it is acknowledged", block_down(), &[GRANTED], "A1", CommandSpecifier),
        ("block download: download segment", block_down(), &[GRANTED], "20", CommandSpecifier),
        ("block download: no end", block_down(), &[GRANTED, "A2 02 7F"], OK, CommandSpecifier),
        ("block download: unknown sub-command", block_down(), &[GRANTED], "A3", CommandSpecifier),
        (
            "block download: granted again later",
            block_down(),
            &[GRANTED, "A2 01 7F"],
            GRANTED,
            CommandSpecifier,
        ),
    ];
    for (what, mut bench, before, response, code) in table {
        bench.poll();
        for response in before {
            assert!(bench.client.on_response(&frame(response), bench.now, &mut |_| {}), "{what}");
        }
        let [low, high, upper, top] = code.code().to_le_bytes();
        let sent = bench.answer(frame(response));
        assert_eq!(hex(&sent), hex(&[[0x80, 0x00, 0x20, 0x01, low, high, upper, top]]), "{what}");
        assert_eq!(bench.client.outcome(), Some(Err(Error::Protocol(code))), "{what}");
        assert_eq!(bench.client.deadline(), None);
        assert_eq!(bench.client.pull(&mut [0; 10]), 0);
    }
}

#[test]
fn what_is_too_large_is_refused() {
    const OUT_OF_MEMORY: &str = "80 00 20 01 05 00 04 05";
    let mut bench = Bench::uploading(8, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("41 00 20 01 09", OUT_OF_MEMORY)]);
    assert_eq!(bench.read(), Some(Err(Error::TooLarge)));
    let mut bench = Bench::uploading(8, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("40 00 20 01", "60"), ("00", "70"), ("18", OUT_OF_MEMORY)]);
    assert_eq!(bench.read(), Some(Err(Error::TooLarge)));
    let mut bench = Bench::uploading(8, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 09", OUT_OF_MEMORY)]);
    assert_eq!(bench.read(), Some(Err(Error::TooLarge)));
    let mut bench = Bench::uploading(8, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C4 00 20 01", "A3"), ("01", ""), ("02", OUT_OF_MEMORY)]);
    assert_eq!(bench.read(), Some(Err(Error::TooLarge)));
    // More than the size field can tell; the server is not asked.
    #[cfg(target_pointer_width = "64")]
    {
        let mut bench = Bench::uploading(0, Mode::Auto);
        bench.client.start_download(AT, 1 << 32, Mode::Auto);
        assert!(bench.poll().is_empty());
        assert_eq!(bench.client.outcome(), Some(Err(Error::TooLarge)));
    }
    // The server is done with it already.
    let mut bench = Bench::uploading(3, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("43 00 20 01 01 02 03 04", "")]);
    assert_eq!(bench.read(), Some(Err(Error::TooLarge)));
}

/// Verifies: ECSS 5.3.3.2.2a, 5.3.3.2.2b, 5.3.3.2.3k
/// Notices: ECSS 5.3.3.2.2a: an upload from a node that left the bus never ends, and no other node is served.
/// Notices: ECSS 5.3.3.2.2b: a block upload from a node that lost its power never ends.
/// Notices: ECSS 5.3.3.2.3k: a block download that the cut ends never ends, and no node before the cut is served.
#[test]
fn a_server_that_does_not_answer_is_told_so() {
    let abort = "80 00 20 01 00 00 04 05";
    let before: [(Bench, &[&str]); 9] = [
        (Bench::uploading(9, Mode::Segmented), &[]),
        (Bench::uploading(9, Mode::Segmented), &["41 00 20 01 09"]),
        (Bench::downloading(b"1", Mode::Auto), &[]),
        (Bench::downloading(b"12345", Mode::Auto), &["60 00 20 01"]),
        (Bench::uploading(9, Mode::Block), &[]),
        (Bench::uploading(9, Mode::Block), &["C6 00 20 01 09"]),
        (Bench::uploading(9, Mode::Block), &["C6 00 20 01 09", "01", "82"]),
        (Bench::downloading(b"12345", Mode::Block), &["A4 00 20 01 7F"]),
        (Bench::downloading(b"12345", Mode::Block), &["A4 00 20 01 7F", "A2 01 7F"]),
    ];
    for (at, (mut bench, answers)) in before.into_iter().enumerate() {
        assert_eq!(bench.client.deadline(), None);
        bench.poll();
        for answer in answers {
            bench.wait(PAUSE);
            bench.now = bench.client.deadline().unwrap();
            bench.now = Instant::from_micros(bench.now.as_micros() - 300_000);
            assert!(!bench.answer(frame(answer)).is_empty() || *answer == "01", "{at}");
        }
        assert_eq!(bench.client.deadline(), Some(bench.now + TIMEOUT), "{at}");
        assert_eq!(hex(&bench.wait(TIMEOUT)), hex(&frames(abort)), "{at}");
        assert_eq!(bench.client.outcome(), Some(Err(Error::Timeout)));
        assert_eq!(bench.client.deadline(), None);
    }
}

#[test]
fn an_application_that_gives_no_data_is_a_timeout() {
    let mut bench = Bench::downloading(&[], Mode::Auto);
    bench.client.start_download(AT, 9, Mode::Auto);
    bench.exchange("21 00 20 01 09", &[("60 00 20 01", "")]);
    bench.client.push(b"12");
    assert_eq!(hex(&bench.wait(TIMEOUT)), hex(&frames("80 00 20 01 00 00 04 05")));
    assert_eq!(bench.client.outcome(), Some(Err(Error::Timeout)));
}

#[test]
fn a_transfer_may_be_cancelled() {
    let local_control = "80 00 20 01 21 00 00 08";
    let mut bench = Bench::uploading(9, Mode::Segmented);
    let mut sent = vec![];
    bench.client.cancel(&mut |payload| sent.push(payload));
    assert!(sent.is_empty(), "the server does not know of it");
    assert!(bench.poll().is_empty());
    let mut bench = Bench::uploading(9, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("41 00 20 01 09", "60")]);
    bench.client.cancel(&mut |payload| sent.push(payload));
    assert_eq!(hex(&sent), hex(&frames(local_control)));
    assert_eq!(bench.client.outcome(), None);
    bench.ignores(frame("00 31 32 33 34 35 36 37"));
    assert_eq!(bench.client.pull(&mut [0; 8]), 0);
}

#[test]
fn a_change_of_the_bus_ends_a_transfer() {
    let mut bench = Bench::downloading(b"12345", Mode::Block);
    bench.exchange("C6 00 20 01 05", &[("A4 00 20 01 7F", "81 31 32 33 34 35")]);
    let mut sent = vec![];
    bench.client.bus_changed(&mut |payload| sent.push(payload));
    assert_eq!(hex(&sent), hex(&frames("80 00 20 01 22 00 00 08")));
    assert_eq!(bench.client.outcome(), Some(Err(Error::BusChanged)));
    bench.client.bus_changed(&mut |payload| sent.push(payload));
    assert_eq!(sent.len(), 1, "there is nothing to end");
    // What has not begun goes over the new bus.
    let mut bench = Bench::uploading(9, Mode::Segmented);
    bench.client.bus_changed(&mut |_| panic!("sent"));
    bench.exchange("40 00 20 01", &[("4F 00 20 01 07", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![7])));
}

#[test]
fn frames_without_a_transfer_are_ignored() {
    let mut bench = Bench { client: Client::new(TIMEOUT), now: Instant::ZERO };
    for payload in ["43 00 20 01", "60 00 20 01", "00", "80 00 20 01 00 00 04 05", "A1", "E0"] {
        bench.ignores(frame(payload));
    }
    bench.client.start_upload(AT, 4, Mode::Auto);
    bench.ignores(frame("43 00 20 01"));
}

/// A server that sends nothing but empty segments would hold the client for ever.
#[test]
fn an_empty_segment_that_is_not_the_last_ends_an_upload() {
    let mut bench = Bench::uploading(100, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("41 00 20 01 09", "60"), ("0E", "80 00 20 01 13 00 07 06")]);
    assert_eq!(bench.client.outcome(), Some(Err(Error::Protocol(AbortCode::TooShort))));
}
