//! A save that runs between other work of the node.

use ecss_can::node::Node;
use ecss_can::store::ParameterStore;
use ecss_can::types::Duration;

use super::fixture::{Memory, ask, done, payloads, powered_with, read, refused, write};
use crate::bench::{NOMINAL, REDUNDANT, frame};

/// Expedited download of "save" to 1010h sub 1.
const SAVE: [u8; 8] = [0x23, 0x10, 0x10, 1, b's', b'a', b'v', b'e'];

/// Given a save that was asked for, then the client reads meanwhile, writes nothing, and gets one answer at the end.
///
/// Verifies: ECSS 6.1a, 6.8a
/// Notices: ECSS 6.1a: a save is answered twice, at its begin and at its end.
/// Notices: ECSS 6.8a: a write during a save changes what is stored.
#[test]
fn a_save_is_answered_once_when_it_has_ended() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    write(&mut slave, 0x6210, 0, &[7, 0, 0, 0]);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &SAVE);
    assert!(slave.sent.is_empty(), "it runs");
    assert_eq!(slave.node.deadline(), Some(slave.now), "and goes on at once");
    slave.settle();
    assert_eq!(slave.node.deadline(), Some(slave.now + Duration::from_micros(100)), "and pauses");
    assert_eq!(ask(&mut slave, SAVE), refused(0x1010, 1, 0x0800_0022), "a second one");
    assert_eq!(read(&mut slave, 0x6210, 0), [7, 0, 0, 0]);
    for (index, sub, value) in [(0x6210, 0, &[8, 0, 0, 0][..]), (0x1017, 0, &[50, 0]), (0x2000, 1, &[1])] {
        assert_eq!(write(&mut slave, index, sub, value), refused(index, sub, 0x0800_0022), "{index:04X}h");
    }
    assert_eq!(memory.stored_len(), 0);
    slave.clear();
    slave.finish_save();
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x585, &done(0x1010, 1)))]);
    assert_ne!(memory.stored_len(), 0);
    assert_eq!(write(&mut slave, 0x6210, 0, &[8, 0, 0, 0]), done(0x6210, 0));
    assert_eq!(powered_with(&memory).node.objects().application.value, 7);
}

/// Verifies: ECSS 6.1a, 6.8a
/// Notices: ECSS 6.8a: a save that failed is answered as done.
#[test]
fn a_save_that_fails_is_answered_with_its_abort_code_at_the_end() {
    let memory = Memory::broken();
    let mut slave = powered_with(&memory);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &SAVE);
    assert!(slave.sent.is_empty());
    slave.finish_save();
    assert_eq!(slave.frames(), [(NOMINAL, frame(0x585, &refused(0x1010, 1, 0x0606_0000)))]);
}

/// A segmented download of "save": the answer to its last segment waits.
///
/// Verifies: ECSS 6.1a, 6.8a
#[test]
fn a_segmented_save_is_answered_when_it_has_ended() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    assert_eq!(ask(&mut slave, [0x21, 0x10, 0x10, 1, 4, 0, 0, 0]), done(0x1010, 1));
    slave.clear();
    slave.receive(NOMINAL, 0x605, &[0x07, b's', b'a', b'v', b'e', 0, 0, 0]);
    assert!(slave.sent.is_empty());
    slave.finish_save();
    assert_eq!(payloads(&slave, 0x585), [[0x20, 0, 0, 0, 0, 0, 0, 0]]);
    assert_ne!(memory.stored_len(), 0);
}

/// NMT stop, reset communication: the client gets no answer, and the set before is stored.
///
/// Verifies: ECSS 6.5.1a.2, 6.5.1a.5, 6.8a
/// Notices: ECSS 6.5.1a.2: a stopped slave answers the save that ran.
#[test]
fn a_save_ends_where_sdo_ends_and_keeps_the_set_before() {
    for command in [[0x02, 5], [0x82, 5]] {
        let memory = Memory::default();
        let mut slave = powered_with(&memory);
        write(&mut slave, 0x6210, 0, &[7, 0, 0, 0]);
        assert_eq!(write(&mut slave, 0x1010, 1, b"save"), done(0x1010, 1));
        write(&mut slave, 0x6210, 0, &[8, 0, 0, 0]);
        slave.clear();
        slave.receive(NOMINAL, 0x605, &SAVE);
        slave.receive(NOMINAL, 0x000, &command);
        slave.finish_save();
        assert!(payloads(&slave, 0x585).is_empty(), "{command:X?}");
        assert_eq!(powered_with(&memory).node.objects().application.value, 7, "{command:X?}");
    }
}

/// Given a client that gave up and aborts, then its save ends and it gets no answer.
///
/// Verifies: ECSS 6.1a
/// Notices: ECSS 6.1a: a transfer that its client aborted is answered.
#[test]
fn a_client_that_aborts_gets_no_answer_to_its_save() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &SAVE);
    slave.receive(NOMINAL, 0x605, &refused(0x1010, 1, 0x0504_0000));
    slave.finish_save();
    assert!(payloads(&slave, 0x585).is_empty());
    assert_ne!(memory.stored_len(), 0);
}

/// Given a slave that follows its master during a save, then the answer goes out on the new bus.
///
/// Verifies: ECSS 6.1a, 8.3.3g
/// Notices: ECSS 8.3.3g: the answer to a save goes out on the bus that the master left.
#[test]
fn the_answer_to_a_save_follows_the_bus() {
    let memory = Memory::default();
    let mut slave = powered_with(&memory);
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &SAVE);
    slave.receive(REDUNDANT, 0x701, &[5]);
    slave.finish_save();
    let answers: Vec<_> = slave.frames().into_iter().filter(|(_, sent)| sent.id().raw() == 0x585).collect();
    assert_eq!(answers, [(REDUNDANT, frame(0x585, &done(0x1010, 1)))]);
}
