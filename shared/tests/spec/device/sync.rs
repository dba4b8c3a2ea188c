//! SYNC with and without a counter.
//!
//! Verifies: ECSS 6.3a, 6.3b

use super::fixture::{NO_INHIBIT, autostarted, done, errors, payloads, read, refused, write, write_all};
use crate::bench::{NOMINAL, ms};

/// Verifies: ECSS 6.9e
/// Notices: ECSS 6.9e: a SYNC without its counter triggers a PDO.
#[test]
fn with_a_counter_announced_a_sync_must_have_it() {
    let mut slave = autostarted();
    assert_eq!(write(&mut slave, 0x1019, 0, &[10]), done(0x1019, 0));
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[1]);
    assert_eq!(slave.frames().len(), 1, "the Local Time PDO");
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert!(slave.frames().iter().all(|(_, frame)| frame.id().raw() == 0x085), "{:?}", slave.frames());
}

/// Verifies: ECSS 6.4a.1, 6.4a.2, 6.9e
/// Notices: ECSS 6.4a.1: each SYNC of a wrong length is another emergency.
#[test]
fn a_sync_of_wrong_length_is_one_error_until_a_good_one_comes() {
    const SYNC_LENGTH: [u8; 8] = [0x40, 0x82, 0x11, 0, 0, 0, 0, 0];
    const NO_ERROR: [u8; 8] = [0, 0, 0, 0x40, 0x82, 0, 0, 0];
    // Without a counter and with one: a wrong one, a good one, the window of 1007h.
    let cases: [(u8, &[u8], &[u8], u32); 4] =
        [(0, &[1], &[], 0), (10, &[], &[1], 0), (0, &[1], &[], 2_000), (0, &[1, 2], &[], 0)];
    for (overflow, wrong, good, window) in cases {
        let mut slave = autostarted();
        let window = window.to_le_bytes();
        write_all(&mut slave, &[NO_INHIBIT, (0x1019, 0, &[overflow]), (0x1007, 0, &window)]);
        for round in 1..=2 {
            slave.clear();
            (0..3).for_each(|_| slave.receive(NOMINAL, 0x080, wrong));
            assert_eq!(payloads(&slave, 0x085), [SYNC_LENGTH], "round {round}");
            assert_eq!(slave.sent.len(), 1, "no PDO");
            assert_eq!(slave.node.status(slave.now).counters[NOMINAL].malformed, 3 * round);
            assert_eq!(errors(&mut slave), (0x11, 1), "the same error");
            slave.clear();
            slave.receive(NOMINAL, 0x080, good);
            assert_eq!(payloads(&slave, 0x085), [NO_ERROR], "round {round}");
            slave.receive(NOMINAL, 0x080, good);
            assert_eq!(payloads(&slave, 0x085), [NO_ERROR], "round {round}");
            assert_eq!(payloads(&slave, 0x185).len(), 2, "the Local Time PDO answers each");
            assert_eq!(errors(&mut slave), (0, 1));
        }
    }
}

/// What is expected may change while the error lasts.
///
/// Verifies: ECSS 6.4a.1, 6.9e
/// Notices: ECSS 6.3b: a written 1019h is obeyed after the next boot only.
#[test]
fn a_sync_of_wrong_length_is_right_once_1019h_says_so() {
    let mut slave = autostarted();
    write_all(&mut slave, &[NO_INHIBIT]);
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[1]);
    assert_eq!(payloads(&slave, 0x085).len(), 1);
    assert_eq!(write(&mut slave, 0x1019, 0, &[10]), done(0x1019, 0));
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[1]);
    assert_eq!(payloads(&slave, 0x085), [[0, 0, 0, 0x40, 0x82, 0, 0, 0]]);
    assert_eq!(payloads(&slave, 0x185).len(), 1);
    // The same without a counter and a window, of which nothing is looked at when all is well.
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(write(&mut slave, 0x1019, 0, &[0]), done(0x1019, 0));
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(payloads(&slave, 0x085), [[0, 0, 0, 0x40, 0x82, 0, 0, 0]]);
}

/// Given a slave in Operational with a SYNC period, when a client sets bit 30 of its 1005h, then that is refused, and
/// the slave sends no SYNC: the master alone does.
///
/// Verifies: ECSS 6.9d
/// Notices: ECSS 6.9d: a slave accepts bit 30 of 1005h.
/// Notices: ECSS 6.9d: a slave accepts bit 30 of 1005h beside bit 31.
#[test]
fn a_slave_does_not_become_a_producer_of_sync() {
    let mut slave = autostarted();
    write_all(&mut slave, &[(0x1006, 0, &10_000_u32.to_le_bytes())]);
    for cob_id in [0x4000_0080_u32, 0x4000_0090, 0xC000_0080, 0xC000_0090] {
        assert_eq!(write(&mut slave, 0x1005, 0, &cob_id.to_le_bytes()), refused(0x1005, 0, 0x0609_0030));
    }
    assert_eq!(read(&mut slave, 0x1005, 0), [0x80, 0, 0, 0]);
    slave.clear();
    slave.run_until(ms(100));
    assert!(slave.sent.iter().all(|sent| ![0x080, 0x090].contains(&sent.frame.id().raw())));
    assert!(!slave.sent.is_empty(), "heartbeats");
}
