//! The client, byte by byte: what it asks, what it makes of the answers.

use ecss_can::od::{AbortCode, Address};
use ecss_can::sdo::{Client, Error, Mode, Payload, STAGING, WINDOW};
use ecss_can::time::{Duration, Instant};

use super::fixture::{PAUSE, TIMEOUT, frame, hex, pattern};

const AT: Address = Address::new(0x2000, 1);

/// A client without a server.
struct Bench {
    client: Client,
    now: Instant,
}

impl Bench {
    fn uploading(most: usize, mode: Mode) -> Bench {
        let mut bench = Bench { client: Client::new(TIMEOUT), now: Instant::from_micros(1_000_000) };
        bench.client.start_upload(AT, most, mode);
        bench
    }

    fn downloading(value: &[u8], mode: Mode) -> Bench {
        let mut bench = Bench { client: Client::new(TIMEOUT), now: Instant::from_micros(1_000_000) };
        bench.client.start_download(AT, value.len(), mode);
        bench.client.push(value);
        bench
    }

    fn poll(&mut self) -> Vec<Payload> {
        let mut sent = vec![];
        self.client.poll(self.now, &mut |payload| sent.push(payload));
        sent
    }

    fn answer(&mut self, payload: Payload) -> Vec<Payload> {
        let mut sent = vec![];
        self.client.on_response(&payload, self.now, &mut |payload| sent.push(payload));
        sent
    }

    /// A frame that is not of use; nothing is sent.
    #[track_caller]
    fn ignores(&mut self, payload: Payload) {
        assert!(!self.client.on_response(&payload, self.now, &mut |payload| panic!("{payload:02X?}")));
    }

    fn wait(&mut self, span: Duration) -> Vec<Payload> {
        let mut sent = vec![];
        let until = self.now + span;
        while let Some(deadline) = self.client.deadline().filter(|deadline| *deadline <= until) {
            self.now = deadline;
            sent.extend(self.poll());
            assert!(self.client.deadline().is_none_or(|next| next > deadline), "a busy loop");
        }
        self.now = until;
        sent
    }

    fn left(&mut self, frames: usize) -> Vec<Payload> {
        (0..frames).for_each(|_| self.client.on_sent());
        self.poll()
    }

    /// The first request, then: what is answered, what is requested then.
    #[track_caller]
    fn exchange(&mut self, first: &str, script: &[(&str, &str)]) {
        assert_eq!(hex(&self.poll()), hex(&frames(first)));
        self.go_on(script);
    }

    #[track_caller]
    fn go_on(&mut self, script: &[(&str, &str)]) {
        for (response, request) in script {
            assert_eq!(hex(&self.answer(frame(response))), hex(&frames(request)), "after {response}");
        }
    }

    /// The outcome, and what was read.
    fn read(&mut self) -> Option<Result<Vec<u8>, Error>> {
        let outcome = self.client.outcome()?;
        let mut value = [0; STAGING];
        let len = self.client.pull(&mut value);
        Some(outcome.map(|size| {
            assert_eq!(size, len);
            value[..len].to_vec()
        }))
    }
}

/// Frames, separated by bars.
fn frames(digits: &str) -> Vec<Payload> {
    digits.split('|').filter(|digits| !digits.is_empty()).map(frame).collect()
}

fn segments(value: &[u8], first: usize, count: usize) -> Vec<Payload> {
    let total = value.chunks(7).count();
    let parts = value.chunks(7).enumerate().skip(first).take(count);
    let segment = |(at, part): (usize, &[u8])| {
        let mut payload = [0; 8];
        payload[0] = (at - first + 1) as u8 | if at + 1 == total { 0x80 } else { 0 };
        payload[1..=part.len()].copy_from_slice(part);
        payload
    };
    parts.map(segment).collect()
}

/// Verifies: ECSS 6.1a
#[test]
fn one_to_four_bytes_are_read_at_once() {
    for (response, value) in [
        ("4F 00 20 01 5A 00 00 00", &[0x5A][..]),
        ("4B 00 20 01 34 12 00 00", &[0x34, 0x12]),
        ("47 00 20 01 01 02 03 00", &[1, 2, 3]),
        ("43 00 20 01 78 56 34 12", &[0x78, 0x56, 0x34, 0x12]),
        ("42 00 20 01 78 56 34 12", &[0x78, 0x56, 0x34, 0x12]),
    ] {
        let mut bench = Bench::uploading(4, Mode::Segmented);
        bench.exchange("40 00 20 01", &[(response, "")]);
        assert_eq!(bench.client.size(), Some(value.len()));
        assert_eq!(bench.read(), Some(Ok(value.to_vec())));
        assert_eq!(bench.read(), None, "an outcome is told once");
    }
}

#[test]
fn of_a_value_that_does_not_tell_its_size_as_much_is_read_as_is_wanted() {
    let mut bench = Bench::uploading(2, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("42 00 20 01 78 56 34 12", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![0x78, 0x56])));
}

/// Verifies: ECSS 6.1a
#[test]
fn one_to_four_bytes_are_written_at_once() {
    for (value, request) in [
        (&[0x11][..], "2F 00 20 01 11"),
        (&[0x11, 0x22], "2B 00 20 01 11 22"),
        (&[0x11, 0x22, 0x33], "27 00 20 01 11 22 33"),
        (&[0x11, 0x22, 0x33, 0x44], "23 00 20 01 11 22 33 44"),
    ] {
        for mode in [Mode::Auto, Mode::Segmented] {
            let mut bench = Bench::downloading(value, mode);
            bench.exchange(request, &[("60 00 20 01", "")]);
            assert_eq!(bench.client.outcome(), Some(Ok(value.len())));
            assert!(!bench.client.is_busy());
        }
    }
}

#[test]
fn a_value_that_goes_at_once_is_waited_for() {
    let mut bench = Bench::downloading(&[], Mode::Auto);
    bench.client.start_download(AT, 4, Mode::Auto);
    assert!(bench.poll().is_empty());
    assert_eq!(bench.client.push(&[1, 2]), 2);
    assert!(bench.poll().is_empty());
    assert_eq!(bench.client.deadline(), None, "nobody waits for an answer");
    assert_eq!(bench.client.room(), 2);
    assert_eq!(bench.client.push(&[3, 4, 5, 6]), 2, "no more than was said");
    bench.exchange("23 00 20 01 01 02 03 04", &[("60 00 20 01", "")]);
    assert_eq!(bench.client.push(&[7]), 0);
}

/// Verifies: ECSS 6.1a
#[test]
fn longer_values_are_read_in_segments() {
    for (first, size) in [("41 00 20 01 09", Some(9)), ("40 00 20 01", None)] {
        let mut bench = Bench::uploading(9, Mode::Segmented);
        bench.exchange("40 00 20 01", &[(first, "60")]);
        assert_eq!(bench.client.size(), size);
        bench.go_on(&[("00 31 32 33 34 35 36 37", "70"), ("1B 38 39", "")]);
        assert_eq!(bench.read(), Some(Ok(b"123456789".to_vec())));
    }
}

/// Verifies: ECSS 6.1a
#[test]
fn longer_values_are_written_in_segments_and_tell_their_size() {
    let mut bench = Bench::downloading(b"123456789abcdefghijkl", Mode::Auto);
    bench.exchange(
        "21 00 20 01 15",
        &[
            ("60 00 20 01", "00 31 32 33 34 35 36 37"),
            ("20", "10 38 39 61 62 63 64 65"),
            ("30", "01 66 67 68 69 6A 6B 6C"),
            ("20", ""),
        ],
    );
    assert_eq!(bench.client.outcome(), Some(Ok(21)));
}

/// Verifies: ECSS 6.1a
#[test]
fn nine_bytes_are_written_in_a_block() {
    let mut bench = Bench::downloading(b"123456789", Mode::Block);
    bench.exchange(
        "C6 00 20 01 09",
        &[("A4 00 20 01 7F", "01 31 32 33 34 35 36 37|82 38 39"), ("A2 02 7F", "D5 C3 31"), ("A1", "")],
    );
    assert_eq!(bench.client.outcome(), Some(Ok(9)));
}

/// Verifies: ECSS 6.1a
#[test]
fn nine_bytes_are_read_in_a_block() {
    let mut bench = Bench::uploading(100, Mode::Block);
    bench.exchange(
        "A4 00 20 01 7F",
        &[
            ("C6 00 20 01 09", "A3"),
            ("01 31 32 33 34 35 36 37", ""),
            ("82 38 39", "A2 02 7F"),
            ("D5 C3 31", "A1"),
        ],
    );
    assert_eq!(bench.read(), Some(Ok(b"123456789".to_vec())));
}

#[test]
fn a_server_without_checksums_is_served() {
    let mut bench = Bench::downloading(b"123456789", Mode::Block);
    bench.exchange("C6 00 20 01 09", &[("A0 00 20 01 7F", "01 31 32 33 34 35 36 37|82 38 39")]);
    bench.go_on(&[("A2 02 7F", "D5 00 00"), ("A1", "")]);
    assert_eq!(bench.client.outcome(), Some(Ok(9)));
    let mut bench = Bench::uploading(9, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C0 00 20 01", "A3"), ("01 31 32 33 34 35 36 37", "")]);
    assert_eq!(bench.client.size(), None);
    bench.go_on(&[("82 38 39", "A2 02 7F"), ("D5 00 00", "A1")]);
    assert_eq!(bench.read(), Some(Ok(b"123456789".to_vec())));
}

#[test]
fn the_size_decides_between_segments_and_blocks() {
    for (size, request) in
        [(0, "21 00 20 01"), (5, "21 00 20 01 05"), (28, "21 00 20 01 1C"), (29, "C6 00 20 01 1D")]
    {
        assert_eq!(hex(&Bench::downloading(&vec![0; size], Mode::Auto).poll()), hex(&frames(request)));
    }
    // The protocol switch threshold leaves it to the server.
    assert_eq!(hex(&Bench::uploading(4, Mode::Auto).poll()), hex(&frames("A4 00 20 01 7F 1C")));
}

#[test]
fn the_server_may_answer_a_block_upload_without_blocks() {
    let mut bench = Bench::uploading(4, Mode::Auto);
    bench.exchange("A4 00 20 01 7F 1C", &[("43 00 20 01 01 02 03 04", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![1, 2, 3, 4])));
    let mut bench = Bench::uploading(9, Mode::Auto);
    bench.exchange("A4 00 20 01 7F 1C", &[("41 00 20 01 05", "60"), ("05 01 02 03 04 05", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![1, 2, 3, 4, 5])));
}

#[test]
fn a_server_without_blocks_is_asked_for_segments() {
    let mut bench = Bench::downloading(&[7; 30], Mode::Auto);
    bench.exchange(
        "C6 00 20 01 1E",
        &[
            ("80 00 20 01 01 00 04 05", "21 00 20 01 1E"),
            ("60 00 20 01", "00 07 07 07 07 07 07 07"),
            ("20", "10 07 07 07 07 07 07 07"),
            ("30", "00 07 07 07 07 07 07 07"),
            ("20", "10 07 07 07 07 07 07 07"),
            ("30", "0B 07 07"),
            ("20", ""),
        ],
    );
    assert_eq!(bench.client.outcome(), Some(Ok(30)));
    let mut bench = Bench::uploading(4, Mode::Auto);
    bench
        .exchange("A4 00 20 01 7F 1C", &[("80 00 20 01 01 00 04 05", "40 00 20 01"), ("4F 00 20 01 09", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![9])));
    // Who insists on blocks is told.
    let mut bench = Bench::uploading(4, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("80 00 20 01 01 00 04 05", "")]);
    assert_eq!(bench.read(), Some(Err(Error::Abort(AbortCode::CommandSpecifier))));
}

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

#[test]
fn the_late_abort_of_another_transfer_is_ignored() {
    let mut bench = Bench::uploading(4, Mode::Segmented);
    bench.poll();
    bench.ignores(frame("80 00 20 02 00 00 04 05"));
    bench.ignores(frame("80 01 20 01 00 00 04 05"));
    bench.go_on(&[("4F 00 20 01 09", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![9])));
}

/// Each script ends with an answer that does not belong; the server is told why.
///
/// Verifies: ECSS 6.1a
#[test]
fn every_bad_answer_has_its_abort_code() {
    use AbortCode::{
        BlockSize, CommandSpecifier, Crc, ParameterIncompatible, SequenceNumber, Toggle, TooLong, TooShort,
    };
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
        ("upload: another object", up(), &[], "43 01 20 01", ParameterIncompatible),
        ("upload: another sub-index", up(), &[], "43 00 20 02", ParameterIncompatible),
        ("upload: another object, segmented", up(), &[], "41 01 20 01 09", ParameterIncompatible),
        ("upload: answer of a download", up(), &[], OK, CommandSpecifier),
        ("upload: segment at once", up(), &[], "00", CommandSpecifier),
        ("upload: answer of a block upload", up(), &[], SIZE, CommandSpecifier),
        ("upload: unknown", up(), &[], "E0", CommandSpecifier),
        ("upload: toggle", up(), &[NINE], "10", Toggle),
        ("upload: toggle of the second", up(), &[NINE, FIRST], "0B", Toggle),
        ("upload: more than told", up(), &[NINE, FIRST], "19", TooLong),
        ("upload: more than told, not last", up(), &[NINE, FIRST], "18", TooLong),
        ("upload: less than told", up(), &[NINE], "01", TooShort),
        ("upload: initiate twice", up(), &[NINE], NINE, CommandSpecifier),
        ("upload: answer of a download segment", up(), &[NINE], "20", CommandSpecifier),
        ("download: another object", write(), &[], "60 01 20 01", ParameterIncompatible),
        ("download: answer of an upload", write(), &[], "43 00 20 01", CommandSpecifier),
        ("download: answer of a segment", write(), &[], "20", CommandSpecifier),
        ("download: answer of a block download", down(), &[], GRANTED, CommandSpecifier),
        ("download: another object, segmented", down(), &[], "60 00 20 02", ParameterIncompatible),
        ("download: toggle", down(), &[OK], "30", Toggle),
        ("download: upload segment", down(), &[OK], "00", CommandSpecifier),
        ("download: acknowledgement", down(), &[OK], "A2 01 7F", CommandSpecifier),
        ("download: unknown", down(), &[OK], "FF", CommandSpecifier),
        ("block upload: another object", block_up(), &[], "C6 00 20 02 09", ParameterIncompatible),
        ("block upload: answer of a download", block_up(), &[], OK, CommandSpecifier),
        ("block upload: end at once", block_up(), &[], "C1", CommandSpecifier),
        ("block upload: more than told", block_up(), &[SIZE, ONE], "02", TooLong),
        ("block upload: checksum", block_up(), &[SIZE, ONE, TWO], "D5 C3 30", Crc),
        ("block upload: unused one less", block_up(), &[SIZE, ONE, TWO], "D1 C3 31", TooLong),
        ("block upload: unused one more", block_up(), &[SIZE, ONE, TWO], "D9 C3 31", TooShort),
        ("block upload: another frame at the end", block_up(), &[SIZE, ONE, TWO], "A1", CommandSpecifier),
        ("block upload: segment at the end", block_up(), &[SIZE, ONE, TWO], "03", CommandSpecifier),
        ("block download: another object", block_down(), &[], "A4 00 21 01 7F", ParameterIncompatible),
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
        assert!(!bench.client.is_busy());
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
    assert!(!bench.client.is_busy());
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

// Sub-blocks of downloads.

#[test]
fn a_block_download_is_paced_by_the_bus() {
    let value = pattern(40 * 7);
    let mut bench = Bench::downloading(&value, Mode::Block);
    bench.poll();
    let mut all = bench.answer(frame("A4 00 20 01 7F"));
    assert_eq!(all.len(), usize::from(WINDOW));
    assert!(bench.poll().is_empty());
    all.extend(bench.left(3));
    assert_eq!(all.len(), 11);
    while all.len() < 40 {
        all.extend(bench.left(8));
    }
    assert_eq!(hex(&all), hex(&segments(&value, 0, 40)));
}

/// Verifies: ECSS 6.1a
#[test]
fn the_server_chooses_the_size_of_each_sub_block() {
    let value = pattern(75);
    let mut bench = Bench::downloading(&value, Mode::Block);
    bench.poll();
    assert_eq!(hex(&bench.answer(frame("A4 00 20 01 04"))), hex(&segments(&value, 0, 4)));
    bench.left(4);
    assert_eq!(hex(&bench.answer(frame("A2 04 02"))), hex(&segments(&value, 4, 2)));
    assert_eq!(hex(&bench.answer(frame("A2 02 01"))), hex(&segments(&value, 6, 1)));
    assert_eq!(hex(&bench.answer(frame("A2 01 7F"))), hex(&segments(&value, 7, 4)));
    assert_eq!(bench.answer(frame("A2 04 7F"))[0][0], 0xC9, "two bytes are unused");
}

/// Verifies: ECSS 6.1a
#[test]
fn what_the_server_has_not_got_is_sent_again() {
    let value = pattern(75);
    let mut bench = Bench::downloading(&value, Mode::Block);
    bench.poll();
    bench.answer(frame("A4 00 20 01 05"));
    bench.left(5);
    assert_eq!(hex(&bench.answer(frame("A2 02 05"))), hex(&segments(&value, 2, 5)));
    bench.left(5);
    assert_eq!(hex(&bench.answer(frame("A2 00 06"))), hex(&segments(&value, 2, 6)));
    bench.left(6);
    assert_eq!(hex(&bench.answer(frame("A2 06 7F"))), hex(&segments(&value, 8, 3)));
    bench.left(3);
    assert_eq!(hex(&bench.answer(frame("A2 02 7F"))), hex(&segments(&value, 10, 1)));
}

#[test]
fn a_sub_block_stays_until_it_is_acknowledged() {
    let value = pattern(2_000);
    let mut bench = Bench::downloading(&value, Mode::Block);
    assert_eq!(bench.client.room(), 0, "one sub-block, no more");
    bench.poll();
    let mut sent = bench.answer(frame("A4 00 20 01 7F")).len();
    while sent < 127 {
        sent += bench.left(8).len();
    }
    assert_eq!(bench.client.room(), 0);
    bench.left(8);
    // The first 100 arrived; 27 are sent again, then the new ones.
    assert_eq!(hex(&bench.answer(frame("A2 64 7F"))), hex(&segments(&value, 100, 8)));
    assert_eq!(bench.client.room(), 700);
    assert_eq!(bench.client.push(&value[STAGING..]), 700);
    let mut again = 8;
    while again < 127 {
        let sent = bench.left(8);
        let expected = segments(&value, 100, 127)[again..again + sent.len()].to_vec();
        assert_eq!(hex(&sent), hex(&expected));
        again += sent.len();
    }
}

#[test]
fn acknowledgements_that_come_twice_are_ignored() {
    let value = pattern(300);
    let mut bench = Bench::downloading(&value, Mode::Block);
    bench.poll();
    let granted = frame("A4 00 20 01 14");
    let mut sent = bench.answer(granted).len();
    bench.ignores(granted);
    while sent < 20 {
        sent += bench.left(8).len();
    }
    bench.left(8);
    assert_eq!(bench.answer(frame("A2 14 14")).len(), 8);
    bench.ignores(frame("A2 14 14"));

    // All of the next sub-block is on its way, but nothing can have arrived.
    let mut bench = Bench::downloading(&value, Mode::Block);
    bench.poll();
    assert_eq!(bench.answer(frame("A4 00 20 01 05")).len(), 5);
    bench.left(5);
    assert_eq!(hex(&bench.answer(frame("A2 05 05"))), hex(&segments(&value, 5, 5)));
    bench.ignores(frame("A2 05 05"));
    // What has arrived may be acknowledged before the controller tells that it left.
    bench.left(2);
    assert_eq!(hex(&bench.answer(frame("A2 05 05"))), hex(&segments(&value, 10, 5)));

    let mut bench = Bench::downloading(b"12345", Mode::Block);
    bench.exchange("C6 00 20 01 05", &[("A4 00 20 01 7F", "81 31 32 33 34 35")]);
    bench.left(1);
    assert_eq!(bench.answer(frame("A2 01 7F")).len(), 1);
    bench.ignores(frame("A2 01 7F"));
    bench.go_on(&[("A1", "")]);
    assert_eq!(bench.client.outcome(), Some(Ok(5)));
}

// Sub-blocks of uploads.

/// Verifies: ECSS 6.1a
#[test]
fn segments_after_a_lost_one_are_asked_for_again() {
    let value = pattern(42);
    let mut bench = Bench::uploading(42, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 2A", "A3")]);
    let sent = segments(&value, 0, 6);
    for at in [0, 1] {
        assert!(bench.answer(sent[at]).is_empty());
    }
    for at in [3, 4] {
        bench.ignores(sent[at]);
    }
    assert_eq!(hex(&bench.answer(sent[5])), hex(&frames("A2 02 7D")), "there is room for 125");
    for segment in segments(&value, 2, 3) {
        assert!(bench.answer(segment).is_empty());
    }
    assert_eq!(hex(&bench.answer(segments(&value, 2, 4)[3])), hex(&frames("A2 04 7F")));
}

#[test]
fn sub_blocks_that_bring_nothing_end_an_upload() {
    let mut bench = Bench::uploading(1_000, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 E8 03", "A3")]);
    for _ in 0..8 {
        bench.go_on(&[("02", ""), ("7F", "A2 00 7F")]);
    }
    bench.go_on(&[("02", ""), ("7F", "80 00 20 01 03 00 04 05")]);
    assert_eq!(bench.read(), Some(Err(Error::Protocol(AbortCode::SequenceNumber))));
}

#[test]
fn a_pause_in_an_upload_brings_its_acknowledgement() {
    let value = pattern(42);
    let mut bench = Bench::uploading(42, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 2A", "A3")]);
    assert!(bench.wait(PAUSE).is_empty(), "it has not begun");
    for segment in segments(&value, 0, 3) {
        assert!(bench.answer(segment).is_empty());
    }
    assert_eq!(hex(&bench.wait(PAUSE)), hex(&frames("A2 03 7C")));
    assert_eq!(bench.client.deadline(), Some(bench.now + TIMEOUT));
}

#[test]
fn no_more_segments_are_asked_for_than_there_is_room_for() {
    let value = pattern(3_000);
    let mut bench = Bench::uploading(3_000, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 B8 0B", "A3")]);
    let all = segments(&value, 0, 127);
    for segment in &all[..126] {
        assert!(bench.answer(*segment).is_empty());
    }
    assert!(bench.answer(all[126]).is_empty(), "there is no room");
    assert_eq!(bench.client.pull(&mut [0; 6]), 6);
    assert!(bench.poll().is_empty());
    bench.ignores(segments(&value, 127, 1)[0]);
    assert_eq!(bench.client.pull(&mut [0; 21]), 21);
    assert_eq!(hex(&bench.poll()), hex(&frames("A2 7F 03")));
    for segment in &segments(&value, 127, 3)[..2] {
        assert!(bench.answer(*segment).is_empty());
    }
    let mut read = vec![0; 2_000];
    let pulled = bench.client.pull(&mut read);
    assert_eq!(read[..pulled], value[27..129 * 7]);
    assert_eq!(hex(&bench.answer(segments(&value, 127, 3)[2])), hex(&frames("A2 03 7E")));
}

#[test]
fn it_is_told_when_the_application_is_needed() {
    let mut bench = Bench::uploading(2_000, Mode::Block);
    assert!(!bench.client.needs_application());
    bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 D0 07", "A3")]);
    for segment in segments(&pattern(2_000), 0, 127) {
        assert!(!bench.client.needs_application());
        bench.answer(segment);
    }
    assert!(bench.client.needs_application(), "to pull");
    bench.client.pull(&mut [0; 7]);
    bench.poll();
    assert!(!bench.client.needs_application());

    let mut bench = Bench::downloading(&[7; 9], Mode::Segmented);
    assert!(!bench.client.needs_application(), "it has given all");
    bench.client.start_download(AT, 9, Mode::Segmented);
    assert!(bench.client.needs_application(), "to push");
    bench.client.push(&[7; 9]);
    bench.exchange("21 00 20 01 09", &[("80 00 20 01 00 00 00 08", "")]);
    assert!(bench.client.needs_application(), "to ask for the outcome");
}

#[test]
fn segments_wait_for_room() {
    let value = pattern(2_000);
    let mut bench = Bench::uploading(2_000, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("41 00 20 01 D0 07", "60")]);
    for (at, part) in value.chunks(7).take(127).enumerate() {
        let toggle = (at as u8 & 1) << 4;
        let mut segment = [toggle; 8];
        segment[1..].copy_from_slice(part);
        let next = if at < 126 { vec![[0x60 | (toggle ^ 0x10), 0, 0, 0, 0, 0, 0, 0]] } else { vec![] };
        assert_eq!(hex(&bench.answer(segment)), hex(&next));
    }
    assert!(bench.poll().is_empty());
    assert!(bench.client.needs_application());
    bench.client.pull(&mut [0; 7]);
    assert_eq!(hex(&bench.poll()), hex(&frames("70")));
    assert!(!bench.client.needs_application());
}

#[test]
fn the_last_segment_is_kept_until_its_length_is_known() {
    let mut bench = Bench::uploading(100, Mode::Block);
    bench.exchange(
        "A4 00 20 01 7F",
        &[("C6 00 20 01 09", "A3"), ("01 31 32 33 34 35 36 37", ""), ("82 38 39", "A2 02 7F")],
    );
    let mut read = [0; 20];
    assert_eq!(bench.client.pull(&mut read), 7);
    bench.go_on(&[("82 38 39", ""), ("D5 C3 31", "A1")]);
    assert_eq!(bench.client.outcome(), Some(Ok(9)));
    assert_eq!(bench.client.pull(&mut read), 2);
    assert_eq!(read[..2], *b"89");
}

#[test]
fn the_last_segment_of_an_upload_may_come_twice() {
    let value = pattern(33 * 7);
    let uploaded = || {
        let mut bench = Bench::uploading(300, Mode::Block);
        bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 E7", "A3")]);
        for segment in &segments(&value, 0, 33)[..32] {
            assert!(bench.answer(*segment).is_empty());
        }
        bench.go_on(&[(&hex(&segments(&value, 0, 33))[32], "A2 21 7F")]);
        bench
    };
    let last = segments(&value, 0, 33)[32];
    uploaded().ignores(last);
    // The same number is not enough.
    let mut other = last;
    other[4] ^= 1;
    assert_eq!(hex(&uploaded().answer(other)), hex(&frames("80 00 20 01 01 00 04 05")));
}

#[test]
fn segments_of_an_upload_that_was_cancelled_do_not_disturb_the_next() {
    let value = pattern(2_000);
    let mut bench = Bench::uploading(2_000, Mode::Block);
    bench.exchange("A4 00 20 01 7F", &[("C6 00 20 01 D0 07", "A3")]);
    let all = segments(&value, 0, 127);
    for segment in &all[..60] {
        assert!(bench.answer(*segment).is_empty());
    }
    bench.client.cancel(&mut |_| {});
    for segment in &all[60..64] {
        bench.ignores(*segment);
    }
    bench.client.start_upload(AT, 4, Mode::Segmented);
    assert_eq!(hex(&bench.poll()), hex(&frames("40 00 20 01")));
    bench.now += PAUSE;
    bench.go_on(&[("43 00 20 01 01 02 03 04", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![1, 2, 3, 4])));
}
