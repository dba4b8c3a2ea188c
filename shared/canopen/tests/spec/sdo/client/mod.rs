//! The client, byte by byte: what it asks, what it makes of the answers.
//!
//! Verifies: ECSS 6.1a

mod blocks;
mod errors;

use async_canopen::sdo::Mode;
use async_canopen::sdo::machine::{Client, Payload};
use async_canopen::sdo::{Error, STAGING};
use async_canopen::types::{AbortCode, Address, Duration, Instant};

use super::fixture::{TIMEOUT, frame, hex};

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
        assert_eq!(bench.read(), Some(Ok(value.to_vec())));
        assert_eq!(bench.read(), None, "an outcome is told once");
    }
}

#[test]
fn value_without_size_is_read_as_far_as_wanted() {
    let mut bench = Bench::uploading(2, Mode::Segmented);
    bench.exchange("40 00 20 01", &[("42 00 20 01 78 56 34 12", "")]);
    assert_eq!(bench.read(), Some(Ok(vec![0x78, 0x56])));
}

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
            assert_eq!(bench.client.deadline(), None);
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

#[test]
fn longer_values_are_read_in_segments() {
    for first in ["41 00 20 01 09", "40 00 20 01"] {
        let mut bench = Bench::uploading(9, Mode::Segmented);
        bench.exchange("40 00 20 01", &[(first, "60")]);
        bench.go_on(&[("00 31 32 33 34 35 36 37", "70"), ("1B 38 39", "")]);
        assert_eq!(bench.read(), Some(Ok(b"123456789".to_vec())));
    }
}

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

#[test]
fn nine_bytes_are_written_in_a_block() {
    let mut bench = Bench::downloading(b"123456789", Mode::Block);
    bench.exchange(
        "C6 00 20 01 09",
        &[("A4 00 20 01 7F", "01 31 32 33 34 35 36 37|82 38 39"), ("A2 02 7F", "D5 C3 31"), ("A1", "")],
    );
    assert_eq!(bench.client.outcome(), Some(Ok(9)));
}

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
