//! Sub-blocks of the client: what is lost, what comes twice, room and pace.
//!
//! Verifies: ECSS 6.1a

use async_canopen::sdo::Mode;
use async_canopen::sdo::machine::WINDOW;
use async_canopen::sdo::{Error, STAGING};
use async_canopen::types::AbortCode;

use super::{AT, Bench, frames, segments};
use crate::sdo::fixture::{PAUSE, TIMEOUT, frame, hex, pattern};

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

/// Verifies: ECSS 5.3.3.2.3k.1
/// Notices: ECSS 5.3.3.2.3k.1: segments that were lost in noise are not repeated.
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
fn segments_of_cancelled_upload_do_not_disturb_the_next() {
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

/// A server that repeats a segment which does not count holds the client no longer than one that sends nothing.
#[test]
fn segments_that_bring_nothing_do_not_keep_an_upload_alive() {
    let mut bench = Bench::uploading(1_000, Mode::Block);
    bench.poll();
    bench.answer(frame("C6 00 20 01 E8 03 00 00"));
    let mut sent = vec![];
    for _ in 0..20 * 127 {
        sent.extend(bench.answer(frame("05 01 02 03 04 05 06 07")));
        sent.extend(bench.wait(async_canopen::types::Duration::from_millis(1)));
    }
    assert_eq!(bench.client.deadline(), None, "it still waits");
    assert_eq!(hex(&sent).last(), hex(&frames("80 00 20 01 00 00 04 05")).last());
    assert_eq!(bench.client.outcome(), Some(Err(Error::Timeout)));
}
