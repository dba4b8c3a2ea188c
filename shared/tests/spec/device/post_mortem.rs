//! The last reset: object 2032h, and the emergency that reports it.

use ecss_can::emcy::PostMortem;

use super::fixture::{ask, errors, payloads, read, run_with_master};
use crate::bench::{Bench, NOMINAL, node, span};
use crate::instrument::{self, STANDARD};
use crate::slave::TestSlave;

const DUMP: [u8; 160] = [0x5A; 160];

const RECORD: PostMortem =
    PostMortem { cause: PostMortem::PANIC, row: 2, pc: 0x0801_2345, task: 0x2000_0678, dump: &DUMP };

/// A slave whose board has this record. Its boot-up message has not been sent yet.
fn reset(record: PostMortem) -> Bench<TestSlave> {
    Bench::alone(instrument::builder(node(5), &STANDARD, vec![]).post_mortem(record).build())
}

/// Given a record of the last reset, when the boot-up message was sent, then one emergency reports it, and its end.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.5.3a
/// Notices: ECSS 6.5.3a: an emergency goes out before the boot-up message.
#[test]
fn the_last_reset_is_reported_once_after_the_boot_up_message() {
    let causes = [
        (PostMortem::PANIC, [0x00, 0x61], 0x01),
        (PostMortem::FAULT, [0x00, 0x61], 0x01),
        (PostMortem::STACK_OVERFLOW, [0x00, 0x61], 0x01),
        (PostMortem::LATE_TASK, [0x00, 0x61], 0x01),
        (PostMortem::WATCHDOG, [0x00, 0x61], 0x01),
        (PostMortem::BROWN_OUT, [0x00, 0x32], 0x05),
        (PostMortem::OSCILLATOR, [0x00, 0x50], 0x01),
        (PostMortem::REGISTER, [0x00, 0x50], 0x01),
    ];
    for (cause, [low, high], register) in causes {
        let mut slave = reset(PostMortem { cause, ..RECORD });
        let boot_up = slave.sent[0].frame;
        slave.clear();
        slave.receive(NOMINAL, 0x701, &[5]);
        assert_eq!(
            payloads(&slave, 0x085),
            [[0; 8]; 0],
            "cause {cause}: before the boot-up message was sent"
        );
        slave.is_acknowledged = true;
        slave.transmitted(NOMINAL, boot_up);
        slave.transmitted(NOMINAL, boot_up);
        let until = slave.now + span(100); // the inhibit time
        run_with_master(&mut slave, until);
        let error = [low, high, register, cause, 0x45, 0x23, 0x01, 0x08];
        assert_eq!(payloads(&slave, 0x085), [error, [0, 0, 0, low, high, cause, 0, 0]], "cause {cause}");
        assert_eq!(errors(&mut slave), (0, 1));
    }
}

/// Verifies: ECSS 6.4a, 6.4a.1
/// Notices: ECSS 6.4a.1: a start without an error before it is reported as a software error.
#[test]
fn a_reset_without_a_cause_is_not_reported() {
    let mut slave = reset(PostMortem::default());
    let boot_up = slave.sent[0].frame;
    slave.transmitted(NOMINAL, boot_up);
    assert_eq!(payloads(&slave, 0x085), [[0; 8]; 0]);
    assert_eq!(read(&mut slave, 0x2032, 1), [0; 4]);
}

/// Verifies: ECSS 6.1a
#[test]
fn the_record_of_the_last_reset_is_in_the_dictionary() {
    let mut slave = reset(RECORD);
    let boot_up = slave.sent[0].frame;
    slave.transmitted(NOMINAL, boot_up);
    assert_eq!(read(&mut slave, 0x2032, 1), [1, 0, 0, 0]);
    assert_eq!(read(&mut slave, 0x2032, 2), [2, 0, 0, 0]);
    assert_eq!(read(&mut slave, 0x2032, 3), [0x45, 0x23, 0x01, 0x08]);
    assert_eq!(read(&mut slave, 0x2032, 4), [0x78, 0x06, 0x00, 0x20]);
    // A segmented upload of 160 bytes, and its first segment.
    assert_eq!(ask(&mut slave, [0x40, 0x32, 0x20, 5, 0, 0, 0, 0]), [0x41, 0x32, 0x20, 5, 160, 0, 0, 0]);
    assert_eq!(ask(&mut slave, [0x60, 0, 0, 0, 0, 0, 0, 0]), [0, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A, 0x5A]);
}
