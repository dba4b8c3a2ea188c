//! Two nodes with the Node-ID of one slave: the master reports them and goes on commanding the slave.
//!
//! Profile `standard`: heartbeat 100 ms, consumer time 250 ms.
//!
//! Verifies: ECSS 6.10h

use ecss_can::node::MasterEvent;
use ecss_can::types::NmtState;

use crate::bench::{Bench, Master, NOMINAL, REDUNDANT, ms, node};
use crate::console;
use crate::instrument::STANDARD;
use crate::master_device::{powered, read};

const OPERATIONAL: u8 = 0x05;
const PRE_OPERATIONAL: u8 = 0x7F;
const STOPPED: u8 = 0x04;

/// Heartbeats of slave 2 every 100 ms from 10 ms on, and of a foreign node with its Node-ID, which reports `state` every
/// `period` ms from `from` on. A command each 10 ms. Returns how many of 200 were refused.
fn refused_commands(master: &mut Bench<Master>, state: u8, period: u64, from: u64) -> usize {
    let mut refused = 0;
    for at in 2..=2_001 {
        master.run_until(ms(at));
        if at % 100 == 10 {
            master.receive(NOMINAL, 0x702, &[OPERATIONAL]);
        }
        if at >= from && (at - from).is_multiple_of(period) {
            master.receive(NOMINAL, 0x702, &[state]);
        }
        if at % 10 == 1 {
            let sent = master.touch(|master, now| console::command(master, node(2), [1; 8], now));
            refused += usize::from(sent.is_err());
        }
    }
    refused
}

/// Code and Node-ID of the last error in 1003h.
fn last_error(master: &mut Bench<Master>) -> Option<(u32, u32)> {
    if read(master, 0x1003, 0) == 0 {
        return None;
    }
    let error = read(master, 0x1003, 1);
    Some((error & 0xFFFF, error >> 16))
}

/// Given a slave that is Operational
/// When a foreign node sends heartbeats with its Node-ID and another state, in step, faster or slower
/// Then the master commands the slave all the time but before the third turn, and reports a collision (8150h).
///
/// Verifies: ECSS 6.4a.2
#[test]
fn slave_with_a_foreign_double_is_commanded_all_the_time() {
    for (state, period, most) in [
        (PRE_OPERATIONAL, 100, 30),
        (PRE_OPERATIONAL, 99, 30),
        (PRE_OPERATIONAL, 40, 35),
        (STOPPED, 100, 30),
        // Seen once in 500 ms: three times before it is known.
        (PRE_OPERATIONAL, 500, 35),
    ] {
        let mut master = powered(&STANDARD);
        let refused = refused_commands(&mut master, state, period, 75);
        assert!(refused <= most, "{refused} of 200 refused, {state:02X}h every {period} ms");
        assert_eq!(last_error(&mut master), Some((0x8150, 2)), "{state:02X}h every {period} ms");
    }
}

/// Given a clash, then its event comes once, and the states of the foreign node are no news: no state, no start, no question.
#[test]
fn known_clash_makes_no_news_of_the_foreign_states() {
    let mut master = powered(&STANDARD);
    refused_commands(&mut master, PRE_OPERATIONAL, 100, 75);
    let clashes = master.events.iter().filter(|event| **event == MasterEvent::Clash { node: node(2) });
    assert_eq!(clashes.count(), 1);
    master.clear();
    for beat in 0..5 {
        master.run_until(ms(2_010 + 100 * beat));
        master.receive(NOMINAL, 0x702, &[OPERATIONAL]);
        master.run_until(ms(2_050 + 100 * beat));
        master.receive(REDUNDANT, 0x702, &[PRE_OPERATIONAL]);
        master.receive(NOMINAL, 0x702, &[PRE_OPERATIONAL]);
    }
    let states = master.events.iter().filter(|event| matches!(event, MasterEvent::SlaveState { .. }));
    assert_eq!(states.count(), 0, "{:?}", master.events);
    assert_eq!(master.times(NOMINAL, 0x000), [] as [u64; 0]);
}

/// Given a clash, when the slave that was Operational is silent, then after a consumer time the state of the other node
/// counts: it is started.
///
/// Verifies: ECSS 8.3.3f
/// Notices: ECSS 8.3.3f: a slave in Pre-operational is not started after a clash.
#[test]
fn silence_of_the_operational_node_ends_its_precedence() {
    let mut master = powered(&STANDARD);
    refused_commands(&mut master, PRE_OPERATIONAL, 100, 75);
    assert_eq!(master.node.slave_state(node(2)), Some(NmtState::Operational));
    master.clear();
    // Its last heartbeat ended at 1,910 ms.
    for at in [2_010, 2_110, 2_159] {
        master.run_until(ms(at));
        master.receive(NOMINAL, 0x702, &[PRE_OPERATIONAL]);
        assert_eq!(master.node.slave_state(node(2)), Some(NmtState::Operational), "{at} ms");
    }
    assert_eq!(master.times(NOMINAL, 0x000), [] as [u64; 0]);
    master.run_until(ms(2_160));
    master.receive(NOMINAL, 0x702, &[PRE_OPERATIONAL]);
    assert_eq!(master.node.slave_state(node(2)), Some(NmtState::PreOperational));
    assert_eq!(master.times(NOMINAL, 0x000), [2_160], "the start");
}

/// Given a clash, when the node that is Operational is heard on the other bus only, then it takes no commands here: the slave on
/// the active bus is started.
///
/// Verifies: ECSS 8.3.3f
#[test]
fn operational_node_on_the_other_bus_has_no_precedence() {
    let mut master = powered(&STANDARD);
    refused_commands(&mut master, PRE_OPERATIONAL, 100, 75);
    master.clear();
    for at in [2_010, 2_110, 2_210] {
        master.run_until(ms(at));
        master.receive(REDUNDANT, 0x702, &[OPERATIONAL]);
        master.receive(NOMINAL, 0x702, &[PRE_OPERATIONAL]);
    }
    // A consumer time after 1,910 ms.
    assert_eq!(master.times(NOMINAL, 0x000), [2_210], "the start");
}

/// Given a clash, when the foreign node is gone for ten consumer times, then that is an event, and the error register is
/// clear at the next heartbeat of the master.
#[test]
fn clash_is_over_when_the_foreign_node_is_gone() {
    let mut master = powered(&STANDARD);
    refused_commands(&mut master, PRE_OPERATIONAL, 100, 75);
    assert_eq!(read(&mut master, 0x1001, 0), 0x11);
    // The last foreign heartbeat ended at 1,975 ms.
    let over = MasterEvent::ClashOver { node: node(2) };
    for at in (2_010..=4_410).step_by(100) {
        master.run_until(ms(at));
        master.receive(NOMINAL, 0x702, &[OPERATIONAL]);
    }
    assert!(!master.events.contains(&over));
    master.run_until(ms(4_510));
    assert!(master.events.contains(&over), "{:?}", master.events);
    assert_eq!(read(&mut master, 0x1001, 0), 0);
}

/// Given one slave that leaves Operational and is started again, in all ways that the protocol knows, then that is no clash:
/// its next heartbeat a period later, a boot-up message, or a report at once of each state, twice.
///
/// Verifies: ECSS 6.4a.1
/// Notices: ECSS 6.4a.1: a slave that is restarted is reported as a collision.
#[test]
fn one_slave_that_changes_its_state_is_no_clash() {
    const BOOT_UP: u8 = 0x00;
    let restarted = [(0, 5), (100, 0x7F), (200, 5), (300, 0x7F), (400, 5), (500, 0x7F), (600, 5), (700, 5)];
    let rebooted =
        [(0, 5), (20, BOOT_UP), (40, 5), (60, BOOT_UP), (80, 5), (100, BOOT_UP), (120, 5), (140, 5)];
    let reported = [(0, 5), (20, 0x7F), (21, 5), (121, 5), (150, 0x7F), (151, 5), (251, 5), (351, 5)];
    for history in [restarted, rebooted, reported] {
        let mut master = powered(&STANDARD);
        for (at, state) in history {
            master.run_until(ms(10 + at));
            master.receive(NOMINAL, 0x702, &[state]);
        }
        assert_eq!(last_error(&mut master), None, "{history:?}");
    }
}
