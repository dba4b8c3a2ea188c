//! The five commands of module control: what a slave does after each, and what it no longer does.
//!
//! Verifies: ECSS 6.5.1a, 6.5.4a

use ecss_can::emcy::{DeviceError, ErrorCode};
use ecss_can::node::DeviceNode;
use ecss_can::node::SlaveEvent;
use ecss_can::redundancy::BusCause;
use ecss_can::types::NmtState;

use super::fixture::{ask, map_tpdo, payloads, powered, read, run_with_master, write_all};
use crate::bench::{Bench, NOMINAL, REDUNDANT, frame, ms, span};
use crate::slave::TestSlave;

/// The number of the application, as an entry of a mapping.
const VALUE: u32 = 0x6210_0020;

/// In Pre-operational, the master heard: TPDO 2 is sent every 10 ms and at events, TPDO 4 and the Local Time PDO with
/// every SYNC.
fn configured() -> Bench<TestSlave> {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    write_all(&mut slave, &[(0x1801, 5, &[10, 0])]);
    map_tpdo(&mut slave, 2, 254, &[VALUE]);
    map_tpdo(&mut slave, 4, 1, &[VALUE]);
    slave
}

/// Each service is asked for once, then half a second passes with the master heard. Returns the COB-IDs of what was
/// sent, each once, in ascending order.
fn services_in_use(slave: &mut Bench<TestSlave>) -> Vec<u16> {
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(1, now));
    slave.receive(NOMINAL, 0x080, &[]);
    slave.receive(NOMINAL, 0x605, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
    slave.touch(|slave, _| slave.raise(DeviceError::new(ErrorCode::TEMPERATURE, 3), [0; 4]));
    slave.touch(|slave, _| slave.clear(DeviceError::new(ErrorCode::TEMPERATURE, 3)));
    slave.receive(NOMINAL, 0x305, &[1; 8]);
    let until = slave.now + span(500);
    run_with_master(slave, until);
    let mut ids: Vec<u16> = slave.sent.iter().map(|sent| sent.frame.id().raw()).collect();
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// States in the heartbeats so far.
fn states(slave: &Bench<TestSlave>) -> Vec<u8> {
    let mut states: Vec<u8> = payloads(slave, 0x705).concat();
    states.dedup();
    states
}

/// Returns whether a command of the master arrived as a PDO.
fn took_pdo(slave: &Bench<TestSlave>) -> bool {
    slave.events.iter().any(|event| matches!(event, SlaveEvent::Pdo(_)))
}

/// Given a slave in Pre-operational or Stopped, when it is started by its Node-ID or with all slaves (node 0), then every
/// service runs: PDOs by timer, event and SYNC as well, in both directions.
///
/// Verifies: ECSS 6.5.1a.1, 6.2a, 6.5.2a
/// Notices: ECSS 6.5.1a.1: a command to all nodes (node 0) is malformed.
/// Notices: ECSS 6.5.1a.1: a stopped slave ignores the command to start.
/// Notices: ECSS 6.5.2a: heartbeats report Pre-operational in Operational.
#[test]
fn a_started_slave_uses_every_service() {
    for (before, target) in [(0x80, 5), (0x02, 5), (0x80, 0), (0x02, 0)] {
        let mut slave = configured();
        slave.receive(NOMINAL, 0x000, &[before, 5]);
        slave.receive(NOMINAL, 0x000, &[0x01, 6]);
        assert_ne!(slave.node.status(slave.now).state, NmtState::Operational, "the command was for node 6");
        slave.receive(NOMINAL, 0x000, &[0x01, target]);
        assert_eq!(services_in_use(&mut slave), [0x085, 0x185, 0x285, 0x485, 0x585, 0x705]);
        assert_eq!(states(&slave), [0x05]);
        assert!(took_pdo(&slave));
        assert!(payloads(&slave, 0x285).len() >= 50, "every 10 ms");
    }
}

/// Given a slave whose PDOs go out by timer, event and SYNC, when it is stopped, then it sends heartbeats alone. When
/// it is started again, then nothing comes late that was due while it was stopped.
///
/// Verifies: ECSS 6.5.1a.2, 6.5.2a, 8.3.3d
/// Notices: ECSS 6.5.1a.2: event timers and SYNC go on sending PDOs in Stopped.
/// Notices: ECSS 6.5.2a: a stopped slave sends no heartbeat.
/// Notices: ECSS 8.3.3d: a slave sends no heartbeat while it is stopped.
#[test]
fn a_stopped_slave_sends_heartbeats_alone() {
    let mut slave = configured();
    slave.receive(NOMINAL, 0x000, &[0x01, 5]);
    slave.run_until(slave.now + span(25));
    assert_eq!(payloads(&slave, 0x285).len(), 2);
    slave.receive(NOMINAL, 0x000, &[0x02, 5]);
    assert_eq!(slave.node.status(slave.now).state, NmtState::Stopped);
    assert_eq!(services_in_use(&mut slave), [0x705]);
    assert_eq!(states(&slave), [0x04]);
    assert!(!took_pdo(&slave));

    slave.clear();
    slave.receive(NOMINAL, 0x000, &[0x01, 5]);
    slave.run_until(slave.now + span(9));
    assert_eq!(payloads(&slave, 0x285).len(), 0, "the event timer starts anew");
    slave.run_until(slave.now + span(1));
    assert_eq!(payloads(&slave, 0x285).len(), 1);
}

/// Given a slave in Operational or Stopped, when it receives Enter Pre-operational, then it answers SDO requests, reports
/// errors and sends heartbeats, and neither sends nor takes a PDO.
///
/// Verifies: ECSS 6.5.1a.3, 6.5.2a
/// Notices: ECSS 6.5.1a.3: a stopped slave ignores the command to enter Pre-operational.
#[test]
fn a_slave_in_pre_operational_uses_every_service_but_pdos() {
    for before in [0x01, 0x02] {
        let mut slave = configured();
        slave.receive(NOMINAL, 0x000, &[before, 0]);
        slave.run_until(slave.now + span(25));
        slave.receive(NOMINAL, 0x000, &[0x80, 5]);
        assert_eq!(slave.node.status(slave.now).state, NmtState::PreOperational);
        assert_eq!(services_in_use(&mut slave), [0x085, 0x585, 0x705], "{before:02X}h");
        assert_eq!(states(&slave), [0x7F]);
        assert!(!took_pdo(&slave));
    }
}

/// Given a slave in any state, when its node is to be reset, then it asks for the reset of the chip and uses no
/// service until then.
///
/// Verifies: ECSS 6.5.1a.4
/// Notices: ECSS 6.5.1a.4: the slave boots up again without a reset of the chip.
#[test]
fn a_slave_to_be_reset_is_silent_until_the_reset() {
    for before in [0x80, 0x01, 0x02] {
        let mut slave = configured();
        slave.receive(NOMINAL, 0x000, &[before, 5]);
        slave.clear();
        slave.receive(NOMINAL, 0x000, &[0x81, 5]);
        assert_eq!(slave.frames(), [], "the boot-up message comes after the reset");
        assert_eq!(slave.events, [SlaveEvent::ResetNode], "{before:02X}h");
        assert_eq!(services_in_use(&mut slave), []);
    }
}

/// Given a slave in any state, with other communication objects than at power-on and a number of the application,
/// when its communication is to be reset, or that of all nodes, then it boots up at once with the objects of power-on. The
/// application and the chip go on.
///
/// Verifies: ECSS 6.5.1a.5, 6.5.3a
/// Notices: ECSS 6.5.1a: Reset communication of all nodes is not obeyed.
/// Notices: ECSS 6.5.1a.5: the PDOs keep what a client wrote.
/// Notices: ECSS 6.5.3a: Reset communication of all nodes brings no boot-up message.
#[test]
fn reset_communication_resets_communication_objects_alone() {
    for (before, target) in [(0x80, 5), (0x01, 5), (0x02, 5), (0x01, 0)] {
        let mut slave = configured();
        write_all(&mut slave, &[(0x6210, 0, &[1, 2, 3, 4]), (0x1017, 0, &[50, 0]), (0x1029, 1, &[1])]);
        slave.receive(NOMINAL, 0x000, &[before, 5]);
        slave.clear();
        slave.receive(NOMINAL, 0x000, &[0x82, target]);
        assert_eq!(slave.frames(), [(NOMINAL, frame(0x705, &[0x00]))], "{before:02X}h");
        assert_eq!(slave.events, [SlaveEvent::State(NmtState::PreOperational)]);
        assert_eq!(read(&mut slave, 0x1017, 0), [100, 0, 0, 0], "100 ms");
        assert_eq!(read(&mut slave, 0x1029, 1), [0; 4]);
        assert_eq!(read(&mut slave, 0x6210, 0), [1, 2, 3, 4]);
        // TPDOs 2 and 4 are gone.
        slave.receive(NOMINAL, 0x000, &[0x01, 5]);
        assert_eq!(services_in_use(&mut slave), [0x085, 0x185, 0x585, 0x705]);
    }
}

/// Given a segmented upload under way, when the communication is reset, then the upload is over: a request for its next segment
/// is aborted.
///
/// Verifies: ECSS 6.5.1a.5, 6.1a
/// Notices: ECSS 6.5.1a.5: an SDO transfer goes on after Reset communication.
#[test]
fn reset_communication_ends_a_transfer() {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    assert_eq!(ask(&mut slave, [0x40, 0x08, 0x10, 0, 0, 0, 0, 0])[0], 0x41);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    assert_eq!(ask(&mut slave, [0x60, 0, 0, 0, 0, 0, 0, 0])[0], 0x80);
}

/// Given a client that switched the search off (1016h, consumer time zero), when the communication is reset, then the slave listens on
/// both buses in turn. Its consumer time is 250 ms again, so it listens 500 ms on each bus.
///
/// Verifies: ECSS 8.3.2b, 6.5.1a.5, 8.3.3d, 8.3.3h
/// Notices: ECSS 8.3.2b: a reset of the communication begins the search with the parameters of before.
/// Notices: ECSS 6.5.1a.5: 1016h keeps what a client wrote.
/// Notices: ECSS 8.3.3h: a slave that has changed the bus sends no heartbeat there.
#[test]
fn reset_communication_begins_a_search_switched_off_before() {
    let mut slave = powered();
    write_all(&mut slave, &[(0x1016, 1, &[0, 0, 1, 0])]);
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.clear();
    slave.run_until(ms(1_100));
    let toggled = |bus| SlaveEvent::ActiveBus { bus, cause: BusCause::Toggled };
    assert_eq!(slave.events, [toggled(REDUNDANT), toggled(NOMINAL)]);
    // A heartbeat every 100 ms, and one at once after each change.
    assert_eq!(slave.times(REDUNDANT, 0x705), [500, 600, 700, 800, 900]);
}

/// Given a slave whose search ended in vain after one change of the bus (Ntoggle 1), when the communication is reset at 1.2 s, then
/// the slave searches anew: it listens 500 ms on its bus, and then on the other one.
///
/// Verifies: ECSS 8.3.2b, 8.3.3i
/// Notices: ECSS 8.3.3i: the switches of the search before a reset of the communication count in the next search.
/// Notices: ECSS 8.3.2b: a reset of the communication after giving up does not clear Ctoggle, so the slave does not toggle.
#[test]
fn reset_communication_begins_another_search_after_giving_up() {
    let mut slave = powered();
    write_all(&mut slave, &[(0x2000, 3, &[1])]);
    slave.run_until(ms(1_200));
    assert!(slave.events.contains(&SlaveEvent::GaveUp { bus: REDUNDANT }));
    slave.receive(REDUNDANT, 0x000, &[0x82, 5]);
    slave.clear();
    slave.run_until(ms(1_950));
    let toggled = SlaveEvent::ActiveBus { bus: NOMINAL, cause: BusCause::Toggled };
    assert_eq!(slave.events, [toggled]);
    assert_eq!(slave.times(NOMINAL, 0x705), [1_700, 1_800, 1_900]);
}
