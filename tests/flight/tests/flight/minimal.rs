//! Minimal slaves (ECSS 9) fly with the shipped master beside full slaves.

use std::sync::LazyLock;

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;
use flight::minimal::{
    MINIMAL, MIXED_CUT, QUEUEING, SELECTIVE, TELEMETRY_DELAY, assert_slaves_followed, mixed,
};
use flight::*;

static MIXED: LazyLock<Recording> = LazyLock::new(|| mixed(PYBOARD_V11));

/// Verifies: ECSS 9.4.7.1b, 7.2.3f, 9.4.7.1a, 11.1c
#[test]
fn nobody_sends_the_time_stamp_object() {
    assert_eq!(MIXED.with_id(0x100).count(), 0);
}

/// Verifies: ECSS 8.3.3b, 8.3.3e.2, 8.3.3g, 9.4.9.1.1a
#[test]
fn full_and_minimal_slaves_follow_the_master_to_the_other_bus() {
    assert_slaves_followed(&MIXED);
}

/// Given a minimal slave 6 in the profile, then the master does not identify it by SDO. Slave 5, which is not in the
/// profile, is asked once and does not answer.
#[test]
fn minimal_slave_that_the_master_knows_is_not_asked_by_sdo() {
    let number = |id: u16| MIXED.with_id(id).count();
    assert_eq!(number(0x600 + u16::from(SELECTIVE)), 0);
    assert!(number(0x600 + u16::from(MINIMAL)) > 0);
    assert_eq!(MIXED.said(MASTER, "node 6 does not answer", Time::ZERO), None);
    assert_eq!([0x585, 0x586].map(number), [0, 0], "answers");
}

/// Given profile `librecube`, then a minimal slave keeps the time (ECSS 7.1, 7.2.3). SYNC comes every 5 s, the
/// spacecraft time every 10 s. At the third SYNC after power-on it has been set, and two crystals differ by 100 ppm at
/// most.
///
/// Verifies: ECSS 7.2.1a, 7.2.2g, 7.2.3h, 7.2.3i, 9.4.3b.2
#[test]
fn minimal_slave_sends_its_local_time_with_sync() {
    let units = |data: &[u8]| data.iter().rev().fold(0_i64, |units, byte| units << 8 | i64::from(*byte));
    let set = MIXED.with_id(0x181).next().unwrap().end;
    let last = MIXED.with_id(0x080).next_back().unwrap();
    assert!(last.end > set + ms(4_000), "{set:?}");
    let time = |id| MIXED.first_after(last.end, |seen| seen.id() == Some(id)).unwrap();
    let (full, minimal) = (time(0x182), time(0x180 + u16::from(MINIMAL)));
    assert!(minimal.end.since(last.end) < TELEMETRY_DELAY + QUEUEING);
    let apart = ((units(minimal.data()) - units(full.data())) * 1_000_000) >> 24;
    assert!(apart.abs() < 1_100, "{apart} us");
    assert_eq!((full.data().len(), minimal.data().len()), (7, 7));
}

/// Given full and minimal slaves with a clock, among commands and telemetry, then each of them sends one Local Time PDO after each SYNC
/// on its bus, and no other board sends its COB-ID.
///
/// Verifies: ECSS 7.2.3i, 7.2.3j, 7.2.2f, 7.2.2g
#[test]
fn each_slave_with_a_clock_sends_one_local_time_pdo() {
    let slaves = [2, 3, MINIMAL, SELECTIVE];
    let mut number = 0;
    for sync in MIXED.with_id(0x080).map(|seen| seen.end).filter(|sync| *sync > ms(500)) {
        let after = |seen: &&Seen| seen.start >= sync && seen.end < sync + ms(4_000);
        let is_time = |seen: &&Seen| matches!(seen.id(), Some(0x182..0x200));
        let times: Vec<&Seen> = MIXED.frames.iter().filter(after).filter(is_time).collect();
        for node in slaves {
            let own: Vec<_> =
                times.iter().filter(|seen| seen.id() == Some(0x180 + u16::from(node))).collect();
            // The selective slave needs 12.5 s to the other bus.
            if node == SELECTIVE && sync > MIXED_CUT && own.is_empty() {
                continue;
            }
            assert_eq!(own.len(), 1, "node {node} after the SYNC at {} us", sync.as_us());
            assert_eq!(own[0].sender, MIXED.board(node).0);
            number += 1;
        }
        let of_slaves = slaves.map(|node| Some(0x180 + u16::from(node)));
        assert!(times.iter().all(|seen| of_slaves.contains(&seen.id())));
    }
    assert!(number >= 7, "{number}");
}

/// Verifies: ECSS 6.2a, 9.4.1a, 9.4.3a, 9.4.3b.1
#[test]
fn full_and_minimal_slaves_get_commands_and_reply_on_both_buses() {
    for node in [2, 3, MINIMAL, SELECTIVE] {
        for (bus, from) in [(Bus::Nominal, ms(600)), (Bus::Redundant, ms(14_900))] {
            assert_replies(&MIXED, node, bus, from, |data| data[..2] == [3, 1]);
        }
    }
}
