//! Nodes that send too much: a slave and a master on the bench.
//!
//! Verifies: ECSS 5.3.3.1b

use ecss_can::link::budget::{BudgetPolicy, Rate};
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::profile::Profile;
use ecss_can::types::{CobId, Duration, NmtState};

use crate::bench::{Bench, Master, NOMINAL, frame, ms, span};
use crate::device::fixture::{payloads, read, run_with_master};
use crate::instrument::{STANDARD, TELEMETRY_TPDO};
use crate::master_device;
use crate::slave::{self, TestSlave};

/// Four frames of a COB-ID at once, and a new one each 10 ms. The node is not the limit.
const OF_COB_ID: Profile =
    Profile { budget: BudgetPolicy { cob_id: Rate::new(4, 100), ..STANDARD.budget }, ..STANDARD };
/// Four frames of a node at once. A COB-ID is not the limit.
const OF_NODE: Profile = Profile {
    budget: BudgetPolicy {
        slave: Rate::new(4, 100),
        master: Rate::new(4, 100),
        silence: Duration::from_millis(400),
        ..STANDARD.budget
    },
    ..STANDARD
};

fn operational(profile: &Profile) -> Bench<TestSlave> {
    let mut slave = slave::powered(profile);
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    slave.clear();
    slave
}

/// The application sends telemetry again and again. How many of these frames left.
fn babble(slave: &mut Bench<TestSlave>, times: usize) -> usize {
    let before = payloads(slave, 0x385).len();
    for _ in 0..times {
        slave.touch(|slave, now| slave.send_pdo(TELEMETRY_TPDO, now));
    }
    payloads(slave, 0x385).len() - before
}

/// Object 2047h: frames refused, COB-ID of the last one, times silenced.
fn refused(slave: &mut Bench<TestSlave>) -> (u32, u16, u16) {
    let [all, last, silenced] = [1, 2, 3].map(|sub| u32::from_le_bytes(read(slave, 0x2047, sub)));
    (all, last as u16, silenced as u16)
}

/// Given an application that sends without end, when the bucket of that COB-ID is empty, then its frames stay away until it is
/// full, one emergency reports it, and another one its end. Other COB-IDs go on.
///
/// Verifies: ECSS 6.4a.1, 6.4a.2
/// Notices: ECSS 6.4a.1: each refused frame is another emergency.
#[test]
fn a_babbling_pdo_is_silent_until_its_bucket_is_full() {
    let mut slave = operational(&OF_COB_ID);
    assert_eq!(babble(&mut slave, 10), 4);
    let babbling = [0x00, 0x81, 0x11, 0x17, 0x85, 0x03, 0, 0];
    assert_eq!(payloads(&slave, 0x085), [babbling]);
    assert_eq!(slave.events, [SlaveEvent::OverBudget { id: CobId::new(0x385).unwrap() }]);
    assert_eq!(slave.node.status(slave.now).counters.nominal.refused, 6);
    run_with_master(&mut slave, ms(39));
    assert_eq!(babble(&mut slave, 1), 0);
    assert_eq!(refused(&mut slave), (7, 0x385, 0));
    run_with_master(&mut slave, ms(40));
    assert_eq!(babble(&mut slave, 5), 4);
    // Reported already.
    slave.clear();
    run_with_master(&mut slave, ms(1_039));
    assert_eq!(payloads(&slave, 0x085), [[0; 8]; 0]);
    assert!(payloads(&slave, 0x705).len() >= 9, "heartbeats");
    run_with_master(&mut slave, ms(1_040));
    assert_eq!(payloads(&slave, 0x085), [[0, 0, 0, 0x00, 0x81, 0x17, 0, 0]]);
    assert_eq!(refused(&mut slave), (8, 0x385, 0));
    // The next time is news again.
    assert_eq!(babble(&mut slave, 5), 4);
    run_with_master(&mut slave, ms(1_200));
    assert_eq!(payloads(&slave, 0x085), [babbling]);
}

/// Given a slave above the budget of the node, then it is in Pre-operational, and no command but a reset ends that. After its
/// time it boots up, with the communication profile of power-on, and is started as any other.
///
/// Verifies: ECSS 6.4a.1, 6.5.3a, 6.5.2a, 8.3.3d
/// Notices: ECSS 6.5.2a: a slave above its budget sends no heartbeat.
/// Notices: ECSS 8.3.3d: a slave above its budget sends no heartbeat.
/// Notices: ECSS 6.5.3a: a slave that was silent for its budget returns without a boot-up message.
#[test]
fn a_babbling_slave_is_silent_for_its_time_and_boots_up() {
    let mut slave = operational(&OF_NODE);
    slave.write((0x1017, 0), &[50, 0]).unwrap();
    slave.clear();
    assert_eq!(babble(&mut slave, 10), 4);
    let id = CobId::new(0x385).unwrap();
    assert_eq!(slave.events, [SlaveEvent::OverBudget { id }, SlaveEvent::State(NmtState::PreOperational)]);
    assert_eq!(payloads(&slave, 0x085), [[0x00, 0x81, 0x11, 0x20, 0x85, 0x03, 0, 0]], "the report");
    assert_eq!(refused(&mut slave), (1, 0x385, 1));
    slave.clear();
    for until in [100, 200, 300, 399] {
        run_with_master(&mut slave, ms(until));
        slave.receive(NOMINAL, 0x000, &[1, 5]);
        assert_eq!(babble(&mut slave, 3), 0, "{until} ms");
    }
    // Every 50 ms, from 50 to 350.
    assert_eq!(payloads(&slave, 0x705), [[0x7F]; 7], "the master hears it");
    slave.clear();
    run_with_master(&mut slave, ms(400));
    assert_eq!(payloads(&slave, 0x705), [[0x00]], "boot-up");
    assert_eq!(u32::from_le_bytes(read(&mut slave, 0x1017, 0)), 100);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(slave.node.status(slave.now).state, NmtState::Operational);
    assert_eq!(babble(&mut slave, 1), 1);
}

/// Given a slave that is silent because it babbled, when the master stops it, then it is stopped.
///
/// Verifies: ECSS 6.5.1a, 6.5.1a.2
/// Notices: ECSS 6.5.1a: a slave above its budget ignores all commands but resets.
/// Notices: ECSS 6.5.1a.2: a slave above its budget cannot be stopped.
#[test]
fn a_silent_slave_is_stopped_by_command() {
    for target in [0, 5] {
        let mut slave = operational(&OF_NODE);
        assert_eq!(babble(&mut slave, 5), 4);
        assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
        slave.receive(NOMINAL, 0x000, &[2, target]);
        assert_eq!(slave.node.status(slave.now).state, NmtState::Stopped, "target {target}");
    }
}

/// Given a slave that is silent because it babbled, when the master resets it, then its application is to reset the chip.
///
/// Verifies: ECSS 6.5.1a.4, 6.5.1a
/// Notices: ECSS 6.5.1a.4: a slave above its budget ignores Reset node.
/// Notices: ECSS 6.5.1a: a slave above its budget does not obey Reset node of all nodes.
#[test]
fn a_silent_slave_is_reset_by_command() {
    for target in [0, 5] {
        let mut slave = operational(&OF_NODE);
        assert_eq!(babble(&mut slave, 5), 4);
        slave.clear();
        slave.receive(NOMINAL, 0x000, &[0x81, target]);
        assert_eq!(slave.events, [SlaveEvent::ResetNode], "target {target}");
        assert_eq!(slave.node.status(slave.now).state, NmtState::Initialising);
    }
}

/// A master with reset communication of its slave: the reset is the other way out of silence.
///
/// Verifies: ECSS 6.5.1a.1
/// Notices: ECSS 6.5.1a.1: a slave whose silence is over ignores Start.
#[test]
fn reset_ends_pre_operational_of_silent_slave_not_its_silence() {
    let mut slave = operational(&OF_NODE);
    assert_eq!(babble(&mut slave, 5), 4);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
    run_with_master(&mut slave, ms(400));
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(slave.node.status(slave.now).state, NmtState::Operational);
}

fn announced(profile: &Profile) -> Bench<Master> {
    let mut master = master_device::powered(profile);
    master.transmitted(NOMINAL, frame(0x701, &[5]));
    master.clear();
    master
}

/// Given an application of a master that sends frames without end, then PDOs and such frames stay away for the time of the
/// profile. Heartbeat and SYNC go on, so that no slave misses its master.
///
/// Verifies: ECSS 6.9d, 8.3.3a
/// Notices: ECSS 8.3.3a: a master above its budget sends no heartbeat.
/// Notices: ECSS 6.9d: a master above its budget sends no SYNC.
#[test]
fn a_babbling_master_keeps_its_network_and_is_silent_otherwise() {
    let mut master = announced(&OF_NODE);
    for _ in 0..10 {
        master.touch(|master, now| {
            let _ = master.send_frame(frame(0x305, &[1, 2]), now);
        });
    }
    let sent = |master: &Bench<Master>, id| {
        master.sent.iter().filter(|sent| sent.frame.id().raw() == id).map(|sent| sent.at).collect::<Vec<_>>()
    };
    assert_eq!(sent(&master, 0x305).len(), 4);
    let id = CobId::new(0x305).unwrap();
    assert!(master.events.contains(&MasterEvent::OverBudget { id }));
    assert_eq!(master.events.last(), Some(&MasterEvent::State(NmtState::PreOperational)));
    assert_eq!(master_device::read(&mut master, 0x2047, 1), 1);
    master.clear();
    let silent_from = master.now;
    master.run_until(silent_from + span(399));
    assert_eq!(master.node.status(master.now).state, NmtState::PreOperational);
    assert_eq!((sent(&master, 0x701).len(), sent(&master, 0x080).len()), (4, 4));
    master.run_until(silent_from + span(400));
    assert_eq!(master.events.last(), Some(&MasterEvent::State(NmtState::Operational)));
    assert_eq!(master.node.send_frame(frame(0x305, &[1, 2]), master.now), Ok(()));
}
