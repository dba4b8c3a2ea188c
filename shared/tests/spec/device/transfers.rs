//! What ends an SDO transfer of a slave, and what becomes of the value.
//!
//! Verifies: ECSS 6.1a

use ecss_can::node::FailCause;

use super::fixture::{ask, done, download, initiate, operational, payloads, read, refused, run_with_master};
use crate::bench::{Bench, NOMINAL, frame, span};
use crate::slave::TestSlave;

/// A block of bytes.
const STORE: u16 = 0x6300;

const ABORT: [u8; 8] = [0x80, 0x00, 0x63, 0, 0, 0, 0, 0x08];

/// Bytes of a file.
fn pattern(len: usize) -> Vec<u8> {
    (0..len).map(|nth| (nth * 7 + 3) as u8).collect()
}

/// With 600 bytes in its store.
fn filled() -> Bench<TestSlave> {
    let mut slave = operational();
    // The last of 86 segments.
    assert_eq!(download(&mut slave, STORE, 0, &pattern(600))[0], 0x30);
    assert_eq!(content(&slave), pattern(600));
    slave
}

fn content(slave: &Bench<TestSlave>) -> Vec<u8> {
    slave.node.objects().application.store.as_bytes().to_vec()
}

/// Everything that was on its way leaves the bus.
fn leaves(slave: &mut Bench<TestSlave>) {
    for sent in std::mem::take(&mut slave.sent) {
        slave.transmitted(sent.bus, sent.frame);
    }
}

/// Verifies: ECSS 6.5.1a.2, 6.5.4a
/// Notices: ECSS 6.5.1a.2: a running SDO transfer goes on after Stop.
#[test]
fn a_transfer_ends_without_a_word_when_the_node_is_stopped() {
    type Begin = fn(&mut Bench<TestSlave>);
    let transfers: [(&str, Begin); 4] = [
        ("block upload", |slave| {
            assert_eq!(ask(slave, [0xA4, 0x00, 0x63, 0, 127, 0, 0, 0])[..4], [0xC6, 0x00, 0x63, 0]);
            slave.clear();
            slave.receive(NOMINAL, 0x605, &[0xA3, 0, 0, 0, 0, 0, 0, 0]);
            assert!(payloads(slave, 0x585).len() > 1);
            // Others follow those that have left.
            leaves(slave);
            assert!(!payloads(slave, 0x585).is_empty());
        }),
        ("segmented upload", |slave| {
            assert_eq!(ask(slave, [0x40, 0x00, 0x63, 0, 0, 0, 0, 0])[0], 0x41);
            assert_eq!(ask(slave, [0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x00);
        }),
        ("segmented download", |slave| {
            assert_eq!(ask(slave, initiate(STORE, 0, 100)), done(STORE, 0));
            assert_eq!(ask(slave, [0x00, 1, 2, 3, 4, 5, 6, 7])[0], 0x20);
        }),
        ("block download", |slave| {
            assert_eq!(ask(slave, [0xC6, 0x00, 0x63, 0, 100, 0, 0, 0])[0], 0xA4);
            slave.receive(NOMINAL, 0x605, &[1, 1, 2, 3, 4, 5, 6, 7]);
        }),
    ];
    for (name, begin) in transfers {
        let mut slave = filled();
        begin(&mut slave);
        slave.receive(NOMINAL, 0x000, &[2, 5]);
        for _ in 0..3 {
            // What was on its way before leaves.
            leaves(&mut slave);
            assert_eq!(payloads(&slave, 0x585), [[0; 8]; 0], "{name}");
        }
        // Nor to segments that come, nor at its timeout.
        slave.receive(NOMINAL, 0x605, &[0x70, 0, 0, 0, 0, 0, 0, 0]);
        slave.receive(NOMINAL, 0x605, &[2, 1, 2, 3, 4, 5, 6, 7]);
        let until = slave.now + span(3_000);
        run_with_master(&mut slave, until);
        assert_eq!(payloads(&slave, 0x585), [[0; 8]; 0], "{name}");
        assert!(payloads(&slave, 0x705).iter().all(|data| *data == [4]), "in Stopped all the time");
        slave.receive(NOMINAL, 0x000, &[1, 5]);
        assert_eq!(payloads(&slave, 0x585), [[0; 8]; 0], "{name}");
        assert_eq!(read(&mut slave, 0x1017, 0), [100, 0, 0, 0], "{name}");
        assert_eq!(content(&slave), pattern(600), "{name}");
    }
}

/// Given a block upload, when its segments on the way are lost in a short, then the next ones are sent as soon as the fault is gone.
///
/// Verifies: ECSS 5.3.3.2.3h
/// Notices: ECSS 5.3.3.2.3h: a block upload stands still after segments that could not be sent.
#[test]
fn block_upload_goes_on_after_its_segments_were_lost() {
    let mut slave = filled();
    assert_eq!(ask(&mut slave, [0xA4, 0x00, 0x63, 0, 127, 0, 0, 0])[..4], [0xC6, 0x00, 0x63, 0]);
    leaves(&mut slave);
    slave.receive(NOMINAL, 0x605, &[0xA3, 0, 0, 0, 0, 0, 0, 0]);
    let numbers =
        |slave: &Bench<TestSlave>| -> Vec<u8> { payloads(slave, 0x585).iter().map(|data| data[0]).collect() };
    assert_eq!(numbers(&slave), [1, 2, 3, 4, 5, 6, 7, 8]);
    for sent in std::mem::take(&mut slave.sent) {
        slave.failed(sent.bus, sent.frame, FailCause::Expired);
    }
    assert_eq!(numbers(&slave), [9, 10, 11, 12, 13, 14, 15, 16]);
}

#[test]
fn block_of_bytes_stays_until_a_byte_of_another_is_written() {
    type End = fn(&mut Bench<TestSlave>);
    let ends: [(&str, End); 6] = [
        ("aborted", |slave| slave.receive(NOMINAL, 0x605, &ABORT)),
        ("timed out", |slave| {
            slave.clear();
            let until = slave.now + span(600);
            run_with_master(slave, until);
            assert_eq!(payloads(slave, 0x585), [refused(STORE, 0, 0x0504_0000)]);
        }),
        ("reset", |slave| slave.receive(NOMINAL, 0x000, &[0x82, 5])),
        ("replaced by another object", |slave| assert_eq!(read(slave, 0x1017, 0), [100, 0, 0, 0])),
        ("replaced by its own upload", |slave| {
            assert_eq!(ask(slave, [0x40, 0x00, 0x63, 0, 0, 0, 0, 0])[..6], [0x41, 0x00, 0x63, 0, 0x58, 2]);
        }),
        ("out of step", |slave| {
            assert_eq!(ask(slave, [0xA3, 0, 0, 0, 0, 0, 0, 0]), refused(STORE, 0, 0x0504_0001));
        }),
    ];
    for (name, end) in ends {
        let mut slave = filled();
        assert_eq!(ask(&mut slave, initiate(STORE, 0, 500)), done(STORE, 0));
        end(&mut slave);
        assert_eq!(content(&slave), pattern(600), "{name}");
    }
    // Once segments of a block may come, only these end it.
    for (name, end) in &ends[..3] {
        let mut slave = filled();
        assert_eq!(ask(&mut slave, [0xC6, 0x00, 0x63, 0, 0xF4, 1, 0, 0])[0], 0xA4);
        end(&mut slave);
        assert_eq!(content(&slave), pattern(600), "{name}");
    }
}

#[test]
fn block_of_bytes_is_empty_once_part_of_another_replaces_it() {
    let mut slave = filled();
    assert_eq!(ask(&mut slave, initiate(STORE, 0, 1_000)), done(STORE, 0));
    let mut toggle = 0;
    let mut segments = 0;
    // The server keeps the first ones: they are not in their place yet.
    while content(&slave) == pattern(600) {
        assert_eq!(ask(&mut slave, [toggle, 9, 9, 9, 9, 9, 9, 9])[0], 0x20 | toggle);
        (toggle, segments) = (toggle ^ 0x10, segments + 1);
        assert!(segments < 1_000 / 7, "nothing is written before the end");
    }
    assert_eq!(content(&slave), Vec::<u8>::new());
    slave.receive(NOMINAL, 0x605, &ABORT);
    assert_eq!(content(&slave), []);
    // And so it is read.
    assert_eq!(ask(&mut slave, [0x40, 0x00, 0x63, 0, 0, 0, 0, 0])[..6], [0x41, 0x00, 0x63, 0, 0, 0]);
    slave.receive(NOMINAL, 0x605, &ABORT);
    assert_eq!(download(&mut slave, STORE, 0, &pattern(30))[0], 0x20);
    assert_eq!(content(&slave), pattern(30));
    assert!(!slave.frames().contains(&(NOMINAL, frame(0x585, &ABORT))));
}
