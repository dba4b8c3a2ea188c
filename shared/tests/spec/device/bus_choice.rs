//! Redundancy objects of a slave, read by its client while the slave chooses its bus.
//!
//! Profile `standard`: consumer time 250 ms, Ttoggle 2, Ntoggle 50, Bdefault nominal. So a search listens 500 ms on each bus.

use ecss_can::node::SlaveEvent;
use ecss_can::types::Bus;

use super::fixture::{ask, ask_on, done, powered, refused, write};
use crate::bench::{Bench, NOMINAL, REDUNDANT, ms, span};
use crate::slave::TestSlave;

const BDEFAULT: u8 = 1;
const NTOGGLE: u8 = 3;
const CTOGGLE: u8 = 4;

/// What a client reads on the active bus: one byte of 2000h.
fn read(slave: &mut Bench<TestSlave>, sub: u8) -> u8 {
    let bus = active(slave);
    let [command, low, high, of, value, rest @ ..] = ask_on(slave, bus, [0x40, 0, 0x20, sub, 0, 0, 0, 0]);
    assert_eq!((command, low, high, of, rest), (0x4F, 0, 0x20, sub, [0; 3]), "one byte");
    value
}

fn active(slave: &Bench<TestSlave>) -> Bus {
    slave.node.status(slave.now).active
}

fn gave_up(slave: &Bench<TestSlave>, bus: Bus) -> bool {
    slave.events.contains(&SlaveEvent::GaveUp { bus })
}

/// Given a slave on the nominal bus, when it follows its master to the other one, toggles away from it in a search, and finds the master
/// there, then Bdefault is the bus where the master was heard last: 1 after the move, unchanged by the toggling, 0 after the find.
///
/// Verifies: ECSS 8.3.3l, 8.3.3k, 8.3.1c
/// Notices: ECSS 8.3.3l: Bdefault that a client reads follows each toggle.
#[test]
fn bdefault_read_by_sdo_is_the_bus_followed_or_found() {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    assert_eq!(read(&mut slave, BDEFAULT), 0);
    slave.run_until(ms(60));
    slave.receive(REDUNDANT, 0x701, &[5]);
    assert_eq!((active(&slave), read(&mut slave, BDEFAULT)), (REDUNDANT, 1));
    // Missed after 250 ms, on the other bus after another 250 ms.
    slave.run_until(ms(560));
    assert_eq!((active(&slave), read(&mut slave, BDEFAULT)), (NOMINAL, 1));
    slave.run_until(ms(600));
    slave.receive(NOMINAL, 0x701, &[5]);
    assert_eq!((active(&slave), read(&mut slave, BDEFAULT)), (NOMINAL, 0));
}

/// Given a slave that gave up its search after two changes of the bus, when the master is heard on the other bus 5 s after power-on, then
/// Bdefault is that bus.
///
/// Verifies: ECSS 8.3.3l, 8.3.3j, 8.3.3g
/// Notices: ECSS 8.3.3l: a bus found after giving up does not become Bdefault.
#[test]
fn bdefault_read_by_sdo_is_a_bus_found_after_giving_up() {
    let mut slave = powered();
    assert_eq!(write(&mut slave, 0x2000, NTOGGLE, &[2]), done(0x2000, NTOGGLE));
    slave.run_until(ms(5_000));
    assert!(gave_up(&slave, NOMINAL));
    assert_eq!((active(&slave), read(&mut slave, BDEFAULT)), (NOMINAL, 0));
    slave.receive(REDUNDANT, 0x701, &[5]);
    assert_eq!((active(&slave), read(&mut slave, BDEFAULT)), (REDUNDANT, 1));
}

/// Given an odd Ntoggle, when the search ends in vain, then the slave listens on the bus that it reached, and Bdefault is unchanged. With
/// an even one it is on Bdefault.
///
/// Verifies: ECSS 8.3.3j, 8.3.3i
/// Notices: ECSS 8.3.3j: giving up makes the bus that was reached Bdefault.
#[test]
fn bdefault_read_by_sdo_stays_when_a_search_is_in_vain() {
    for (bdefault, ntoggle, reached) in
        [(0, 1, REDUNDANT), (0, 3, REDUNDANT), (0, 2, NOMINAL), (1, 1, REDUNDANT), (1, 2, NOMINAL)]
    {
        let mut slave = powered();
        // A written Bdefault counts at the next power-on: the search begins on the nominal bus.
        assert_eq!(write(&mut slave, 0x2000, BDEFAULT, &[bdefault]), done(0x2000, BDEFAULT));
        assert_eq!(write(&mut slave, 0x2000, NTOGGLE, &[ntoggle]), done(0x2000, NTOGGLE));
        for until in [5_000, 20_000] {
            slave.run_until(ms(until));
            assert!(gave_up(&slave, reached), "Ntoggle {ntoggle}");
            assert_eq!(
                (active(&slave), read(&mut slave, BDEFAULT)),
                (reached, bdefault),
                "Ntoggle {ntoggle}"
            );
        }
    }
}

/// Given a slave that searches, when a command for another node is heard on the other bus at 50 ms, then the slave is there. If no
/// heartbeat follows in 250 ms, then it is back, Bdefault too, and it toggles at 500 ms as if there had been no command. If the master
/// sends heartbeats there, then the slave stays.
///
/// Verifies: ECSS 8.3.3k, 8.3.3l, 8.3.3g, 8.3.3h
/// Notices: ECSS 8.3.3k: a bus that a command shows is left again although heartbeats follow.
/// Notices: ECSS 8.3.3h: after a command without a heartbeat the toggling time begins anew.
#[test]
fn search_ends_at_a_command_if_heartbeats_follow() {
    let mut slave = powered();
    slave.run_until(ms(50));
    slave.receive(REDUNDANT, 0x000, &[1, 6]);
    let times = [(50, REDUNDANT), (299, REDUNDANT), (300, NOMINAL), (499, NOMINAL), (500, REDUNDANT)];
    for (until, bus) in times.into_iter().chain([(999, REDUNDANT), (1_000, NOMINAL)]) {
        slave.run_until(ms(until));
        assert_eq!(active(&slave), bus, "{until} ms");
        let bdefault = u8::from(until < 300);
        assert_eq!(read(&mut slave, BDEFAULT), bdefault, "{until} ms");
    }

    let mut slave = powered();
    slave.run_until(ms(50));
    slave.receive(REDUNDANT, 0x000, &[1, 6]);
    slave.clear();
    for at in (250..20_000).step_by(200) {
        slave.run_until(ms(at));
        slave.receive(REDUNDANT, 0x701, &[5]);
        assert_eq!(active(&slave), REDUNDANT, "{at} ms");
    }
    let moved =
        |event: &SlaveEvent| matches!(event, SlaveEvent::ActiveBus { .. } | SlaveEvent::GaveUp { .. });
    assert_eq!(slave.events.iter().find(|event| moved(event)), None);
    assert_eq!((read(&mut slave, BDEFAULT), read(&mut slave, CTOGGLE)), (1, 0));
}

/// Given a slave with Ntoggle 3 that finds its master, misses it and then searches in vain, then Ctoggle is the number of changes of the
/// bus in the search, stays when the search ends, and begins with zero when the master is missed.
///
/// Verifies: ECSS 8.3.3i, 8.3.1a, 8.3.1c
/// Notices: ECSS 8.3.3i: Ctoggle is zero again as soon as the master is found.
/// Notices: ECSS 8.3.3i: Ctoggle is zero again after giving up.
#[test]
fn ctoggle_read_by_sdo_counts_changes_of_one_search() {
    let mut slave = powered();
    assert_eq!(write(&mut slave, 0x2000, NTOGGLE, &[3]), done(0x2000, NTOGGLE));
    for (until, count) in [(0, 0), (499, 0), (500, 1), (999, 1), (1_000, 2), (1_100, 2)] {
        slave.run_until(ms(until));
        assert_eq!(read(&mut slave, CTOGGLE), count, "{until} ms");
    }
    // Found on the bus where it is, the nominal one.
    slave.receive(NOMINAL, 0x701, &[5]);
    for (until, count) in [
        (1_100, 2),
        (1_349, 2),
        (1_350, 0),
        (1_599, 0),
        (1_600, 1),
        (2_100, 2),
        (2_600, 3),
        (3_100, 3),
        (20_000, 3),
    ] {
        slave.run_until(ms(until));
        assert_eq!(read(&mut slave, CTOGGLE), count, "{until} ms");
        assert_eq!(gave_up(&slave, REDUNDANT), until >= 3_100, "{until} ms");
    }
}

/// Given a slave of profile `standard`, then a client reads the objects of Table 8-1 with the sizes of that table: 1016h in four bytes,
/// of which the upper two have the Node-ID, 1017h in two, the parts of 2000h in one.
///
/// Verifies: ECSS 8.3.1a, 8.3.1c, 6.5.2b
/// Notices: ECSS 8.3.1a: an answer with one byte says that it has four.
#[test]
fn slave_has_the_objects_of_table_8_1_in_their_sizes() {
    let mut slave = powered();
    for answer in [
        [0x43, 0x16, 0x10, 1, 0xFA, 0, 1, 0],
        [0x4B, 0x17, 0x10, 0, 100, 0, 0, 0],
        [0x4F, 0, 0x20, 1, 0, 0, 0, 0],
        [0x4F, 0, 0x20, 2, 2, 0, 0, 0],
        [0x4F, 0, 0x20, 3, 50, 0, 0, 0],
        [0x4F, 0, 0x20, 4, 0, 0, 0, 0],
    ] {
        let [_, low, high, sub, ..] = answer;
        assert_eq!(ask(&mut slave, [0x40, low, high, sub, 0, 0, 0, 0]), answer);
        // Written with another size: too long or too short.
        let index = u16::from_le_bytes([low, high]);
        for size in (1..=4).filter(|size| *size != 4 - usize::from(answer[0] >> 2 & 3)) {
            let code = if size > 4 - usize::from(answer[0] >> 2 & 3) { 0x0607_0012 } else { 0x0607_0013 };
            assert_eq!(write(&mut slave, index, sub, &[0; 4][..size]), refused(index, sub, code), "{size}");
        }
    }
    assert_eq!(ask(&mut slave, [0x40, 0, 0x20, 5, 0, 0, 0, 0]), refused(0x2000, 5, 0x0609_0011));
}

/// Given a slave that follows its master, when a client writes another consumer time to 1016h, then the slave misses the master that time
/// after the last heartbeat: later or earlier than before, and again as before when the old time is written.
///
/// Verifies: ECSS 8.3.1c, 6.5.2b, 8.3.3c, 8.3.3e
/// Notices: ECSS 8.3.3e: a time that a client writes to 1016h while the master is followed has no effect.
/// Notices: ECSS 6.5.2b: a time that a client writes to 1016h while the master is heard has no effect.
#[test]
fn consumer_time_written_in_flight_is_when_master_is_missed() {
    for times in [&[600_u16][..], &[100], &[600, 250], &[100, 250]] {
        let mut slave = powered();
        for beat in 0..20 {
            slave.run_until(ms(50 * beat));
            slave.receive(NOMINAL, 0x701, &[5]);
            if beat >= 10
                && let Some(time) = times.get(usize::try_from(beat).unwrap() - 10)
            {
                let [low, high] = time.to_le_bytes();
                assert_eq!(write(&mut slave, 0x1016, 1, &[low, high, 1, 0]), done(0x1016, 1));
            }
        }
        slave.clear();
        let time = u64::from(*times.last().unwrap());
        let last = slave.now;
        let missed = SlaveEvent::MasterMissed { bus: NOMINAL };
        slave.run_until(last + span(time - 1));
        assert!(!slave.events.contains(&missed), "{times:?}");
        slave.run_until(last + span(time));
        assert!(slave.events.contains(&missed), "{times:?}");
    }
}
