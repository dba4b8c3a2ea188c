//! The dictionary of a slave over its bus: SDO requests in, what the node does then.

mod bus_choice;
mod changed;
mod commands;
mod errors;
pub(crate) mod fixture;
mod impossible_pdos;
mod long_values;
mod maintenance;
mod pdos;
mod post_mortem;
mod reset;
mod samples;
mod saving;
mod storing;
mod sync;
mod transfers;
mod upsets;

use ecss_can::link::port::Filter;
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{SelfTest, SlaveEvent};
use ecss_can::types::{Bus, CobId, NmtState};

use self::fixture::{ask, done, powered, read, refused, write};
use crate::bench::{NOMINAL, REDUNDANT, frame, ms, node, span};
use crate::instrument::{self, STANDARD};

/// Verifies: ECSS 6.1a, 6.8a, 6.5.2a, 6.5.4a, 8.3.1c
/// Notices: ECSS 6.5.4a: a slave answers SDO requests in Stopped.
/// Notices: ECSS 6.5.2a: the heartbeat keeps its period when 1017h is written.
#[test]
fn objects_are_read_and_written_where_sdo_is_allowed() {
    let mut slave = powered();
    assert_eq!(read(&mut slave, 0x1017, 0), [100, 0, 0, 0]);
    assert_eq!(write(&mut slave, 0x1017, 0, &[50, 0]), done(0x1017, 0));
    // The heartbeat follows.
    slave.clear();
    slave.run_until(ms(200));
    assert_eq!(slave.times(NOMINAL, 0x705), [50, 100, 150, 200]);
    // Stopped: no SDO. On the bus that is not active: none either.
    slave.receive(NOMINAL, 0x000, &[2, 5]);
    slave.clear();
    slave.receive(NOMINAL, 0x605, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
    slave.receive(REDUNDANT, 0x605, &[0x40, 0x17, 0x10, 0, 0, 0, 0, 0]);
    assert_eq!(slave.frames(), []);
}

/// Verifies: ECSS 6.1a, 6.2a, 6.8a, 6.9d, 11.1c
/// Notices: ECSS 6.1a: a value that is too long is refused with 0607 0013h, too short.
/// Notices: ECSS 6.2a: the mapping of a valid PDO can be written.
/// Notices: ECSS 6.9d: a client makes a slave a producer of SYNC.
/// Notices: ECSS 11.1c: transmission type 252, remote request, is taken.
#[test]
fn what_must_not_be_written_is_refused_with_the_right_code() {
    let mut slave = powered();
    let table: [(u16, u8, &[u8], u32); 23] = [
        (0x1000, 0, &[0; 4], 0x0601_0002),             // device type is read-only
        (0x1004, 0, &[0; 4], 0x0602_0000),             // no such object
        (0x1018, 9, &[0; 4], 0x0609_0011),             // no such sub-index
        (0x1017, 0, &[1], 0x0607_0013),                // too short
        (0x1017, 0, &[1, 0, 0, 0], 0x0607_0012),       // too long
        (0x1003, 0, &[1], 0x0609_0030),                // only zero forgets the errors
        (0x1005, 0, &[0x80, 0, 0, 0x40], 0x0609_0030), // a slave is no SYNC producer
        (0x1014, 0, &[0x86, 0, 0, 0], 0x0609_0030),    // another COB-ID while valid
        (0x1016, 2, &[10, 0, 1, 0], 0x0604_0043),      // node 1 is monitored already
        (0x1019, 0, &[1], 0x0609_0030),                // reserved
        (0x1029, 1, &[3], 0x0609_0030),                // reserved
        (0x1010, 1, &[0; 4], 0x0800_0020),             // not the signature
        (0x1010, 1, b"save", 0x0800_0020),             // nowhere to save to
        (0x1400, 1, &[0x82, 1, 0, 0x40], 0x0601_0000), // another COB-ID while valid
        (0x1600, 0, &[0], 0x0601_0000),                // mapping while valid
        (0x1603, 1, &[8, 1, 0, 0x20], 0x0604_0041),    // Bdefault is for transmit PDOs
        (0x1603, 1, &[8, 4, 0, 0x20], 0x0604_0041),    // Ctoggle as well
        (0x1803, 2, &[252], 0x0609_0030),              // remote requests
        (0x1A03, 1, &[0x20, 0, 0, 0x60], 0x0602_0000), // 6000h is no object
        (0x1A03, 1, &[0x10, 1, 0, 0x62], 0x0604_0041), // 6200h is for receive PDOs
        (0x2000, 1, &[2], 0x0609_0030),                // Bdefault is 0 or 1
        (0x2030, 0, &[2], 0x0609_0031),                // self-test is started with 1
        (0x6100, 1, &[0, 0], 0x0601_0002),             // telemetry is read-only
    ];
    for (index, sub, value, code) in table {
        assert_eq!(
            write(&mut slave, index, sub, value),
            refused(index, sub, code),
            "{index:04X}h:{sub} {value:02X?}"
        );
    }
    assert_eq!(ask(&mut slave, [0x40, 0x30, 0x20, 0, 0, 0, 0, 0]), refused(0x2030, 0, 0x0601_0001));
    assert_eq!(ask(&mut slave, [0x40, 0x03, 0x10, 1, 0, 0, 0, 0]), refused(0x1003, 1, 0x0800_0024));
    assert_eq!(ask(&mut slave, [0xE0, 0, 0, 0, 0, 0, 0, 0]), refused(0, 0, 0x0504_0001));
}

/// Verifies: ECSS 6.5.2a, 6.5.1a.5, 8.2.1a.2, 8.2.2a
/// Notices: ECSS 6.5.1a.5: the filters of 1016h and 1005h stay after Reset communication.
/// Notices: ECSS 8.2.2a: a changed filter is set in the nominal controller alone.
#[test]
fn heartbeat_of_another_slave_passes_filters_once_monitored() {
    let mut slave = powered();
    // Filters that boot-up sends again have to wait for room.
    slave.run_until(ms(5));
    slave.clear();
    let filter = |raw| Filter::exact(CobId::new(raw).unwrap());
    for (value, raw) in [([250, 0, 7, 0], 0x707), ([0; 4], 0x000), ([250, 0, 8, 0], 0x708)] {
        slave.controls.clear();
        assert_eq!(write(&mut slave, 0x1016, 2, &value), done(0x1016, 2));
        let command = BusCommand::Filter { number: 5, filter: filter(raw) };
        assert_eq!(slave.controls, [(NOMINAL, command), (REDUNDANT, command)]);
    }
    slave.receive(NOMINAL, 0x708, &[5]);
    assert!(slave.events.contains(&SlaveEvent::PeerState { node: node(8), state: NmtState::Operational }));
    // Reset communication forgets it, and a SYNC that had moved.
    assert_eq!(write(&mut slave, 0x1005, 0, &[0x81, 0, 0, 0]), done(0x1005, 0));
    slave.controls.clear();
    slave.receive(NOMINAL, 0x000, &[0x82, 5]);
    slave.run_until(ms(10));
    for (number, raw) in [(5, 0x000), (1, 0x080)] {
        let command = BusCommand::Filter { number, filter: filter(raw) };
        for bus in Bus::ALL {
            assert!(slave.controls.contains(&(bus, command)), "{command:?}: {:?}", slave.controls);
        }
    }
    assert_eq!(slave.controls.len(), 4);
}

/// Given a written 1017h, then a heartbeat lives at most one period: an older one is never sent behind it.
#[test]
fn heartbeat_lives_no_longer_than_1017h() {
    let mut slave = powered();
    for (period, lifetime) in [([30, 0], 30), ([100, 0], 100), ([0xE8, 3], 100)] {
        assert_eq!(write(&mut slave, 0x1017, 0, &period), done(0x1017, 0));
        slave.clear();
        let until = slave.now + span(1_000);
        slave.run_until(until);
        let beat = slave.sent.iter().find(|sent| sent.frame.id().raw() == 0x705).expect("a heartbeat");
        assert_eq!(beat.expires.since(beat.at), span(lifetime), "{period:?}");
    }
}

/// Given a slave with an SDO server, then 1200h has the two COB-IDs of its server.
///
/// Verifies: ECSS 9.4.10f, 6.8a, 6.10a
/// Notices: ECSS 9.4.10f: both COB-IDs in 1200h are that of requests.
/// Notices: ECSS 9.4.10f: the COB-IDs in 1200h have the low six bits of the Node-ID.
#[test]
fn sdo_parameters_are_those_of_the_server() {
    let mut slave = powered();
    let parameters = [1, 2].map(|sub| read(&mut slave, 0x1200, sub));
    assert_eq!(parameters, [[0x05, 0x06, 0, 0], [0x85, 0x05, 0, 0]]);
    for raw in [2, 63, 64, 126] {
        let slave = instrument::slave(node(raw), &STANDARD, vec![]);
        let parameters = slave.objects().sdo.sdo_server;
        let expected = [0x600, 0x580].map(|base| base + u32::from(raw));
        assert_eq!([parameters.request, parameters.response], expected, "node {raw}");
    }
}

/// Given each COB-ID from 1921 to 2014 and from 2032 to 2047, when a client writes it to 1005h, 1014h, 1400h or 1800h, then it is
/// refused. The objects are as before.
///
/// Verifies: ECSS 9.5a, 6.10b
/// Notices: ECSS 9.5a: 7F0h to 7FFh are allowed.
#[test]
fn free_cob_ids_are_refused_in_each_object() {
    let mut slave = powered();
    // Not valid, so that their COB-IDs can be changed.
    let invalid = [(0x1014, 0, 0x085, 0x681), (0x1400, 1, 0x181, 0x682), (0x1800, 1, 0x185, 0x683)];
    let raw = |index, id: u32, is_valid: bool| {
        let flags = if index < 0x1400 { 0 } else { 1 << 30 };
        (if is_valid { 0 } else { 1_u32 << 31 } | flags | id).to_le_bytes()
    };
    for (index, sub, id, _) in invalid {
        assert_eq!(write(&mut slave, index, sub, &raw(index, id, false)), done(index, sub));
    }
    for id in (1_921_u32..=2_014).chain(2_032..=2_047) {
        assert_eq!(write(&mut slave, 0x1005, 0, &id.to_le_bytes()), refused(0x1005, 0, 0x0609_0030), "{id}");
        for (index, sub, ..) in invalid {
            let answer = write(&mut slave, index, sub, &raw(index, id, true));
            assert_eq!(answer, refused(index, sub, 0x0609_0030), "{id} in {index:04X}h");
        }
    }
    assert_eq!(read(&mut slave, 0x1005, 0), [0x80, 0, 0, 0]);
    for (index, sub, id, allowed) in invalid {
        assert_eq!(read(&mut slave, index, sub), raw(index, id, false));
        assert_eq!(write(&mut slave, index, sub, &raw(index, allowed, true)), done(index, sub));
    }
}

/// Verifies: ECSS 8.3.1c, 8.3.1a, 8.3.3c, 6.4a.2, 6.5.2b
/// Notices: ECSS 8.3.1c: a written consumer time is not followed.
/// Notices: ECSS 8.3.1a: 2000h sub 4 does not show a toggle.
/// Notices: ECSS 8.3.3c: a written 1016h does not reach the consumer of the master's heartbeat.
/// Notices: ECSS 6.5.2b: a slave does not miss the heartbeat of the redundancy master.
/// Notices: ECSS 6.4a.2: a missed master has another code than 8130h.
#[test]
fn redundancy_parameters_are_written_and_obeyed() {
    let mut slave = powered();
    assert_eq!(write(&mut slave, 0x2000, 2, &[4]), done(0x2000, 2));
    assert_eq!(write(&mut slave, 0x1016, 1, &[100, 0, 1, 0]), done(0x1016, 1));
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    slave.run_until(ms(99));
    assert_eq!(slave.events, []);
    slave.run_until(ms(100));
    assert_eq!(slave.events[0], SlaveEvent::MasterMissed { bus: NOMINAL });
    // EMCY 8130h names the master, and 1003h remembers.
    assert!(slave.frames().contains(&(NOMINAL, frame(0x085, &[0x30, 0x81, 0x11, 1, 0, 0, 0, 0]))));
    slave.clear();
    slave.run_until(ms(399));
    assert_eq!(slave.events, []);
    slave.run_until(ms(400));
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
    assert_eq!(slave.node.objects().extension.redundancy.parameters.ctoggle, 1);
    assert_eq!(slave.node.objects().communication.emcy.errors.errors[0], 0x0001_8130);
}

/// Given a slave that searches, When Ntoggle or Ctoggle is written, Then the search has as many switches as are left.
///
/// Verifies: ECSS 8.3.1c, 8.3.1a, 8.3.3i, 8.3.3j
/// Notices: ECSS 8.3.3i: a search makes one switch more than Ntoggle.
/// Notices: ECSS 8.3.3j: a slave toggles on after Ntoggle switches.
#[test]
fn a_search_has_the_written_ntoggle_and_ctoggle() {
    // Sub-index, value, and switches until the slave gives up; by default Ntoggle is 50.
    for (sub, value, switches) in [(3, 1, 1), (3, 4, 4), (4, 47, 3), (4, 50, 0)] {
        let mut slave = powered();
        assert_eq!(write(&mut slave, 0x2000, sub, &[value]), done(0x2000, sub));
        assert_eq!(read(&mut slave, 0x2000, sub), [value, 0, 0, 0]);
        slave.clear();
        slave.run_until(ms(60_000));
        let toggled = |event: &&SlaveEvent| matches!(event, SlaveEvent::ActiveBus { .. });
        assert_eq!(slave.events.iter().filter(toggled).count(), switches, "sub-index {sub}: {value}");
        let gave_up = |event: &SlaveEvent| matches!(event, SlaveEvent::GaveUp { .. });
        assert!(slave.events.iter().any(gave_up));
    }
}

/// Verifies: ECSS 8.3.1c, 8.3.1a
#[test]
fn a_written_bdefault_is_read_back_and_must_be_a_bus() {
    let mut slave = powered();
    for value in [1, 0] {
        assert_eq!(write(&mut slave, 0x2000, 1, &[value]), done(0x2000, 1));
        assert_eq!(read(&mut slave, 0x2000, 1), [value, 0, 0, 0]);
    }
    assert_eq!(write(&mut slave, 0x2000, 1, &[2]), refused(0x2000, 1, 0x0609_0030));
}

/// Verifies: ECSS 6.7b, 6.7c
/// Notices: ECSS 6.7b: the application does not learn of the write that starts the test.
/// Notices: ECSS 6.7b: a test that did not end cannot be started again.
/// Notices: ECSS 6.7b: a start by a segmented download is stored and begins no test.
/// Notices: ECSS 6.7c: a test that runs leaves the result of the one before.
/// Notices: ECSS 6.7c: the failures of a test are not shown.
/// Notices: ECSS 6.7c: failures of the last test stay while the next one runs.
#[test]
fn the_self_test_is_started_and_its_result_read() {
    let mut slave = powered();
    assert_eq!(read(&mut slave, 0x2031, 1), [0, 0, 0, 0]);
    assert_eq!(write(&mut slave, 0x2030, 0, &[1]), done(0x2030, 0));
    assert!(slave.events.contains(&SlaveEvent::SelfTest));
    assert_eq!(read(&mut slave, 0x2031, 1), [1, 0, 0, 0]);
    slave.touch(|slave, now| {
        slave.report_self_test(SelfTest { progress: SelfTest::PASSED, failures: 0 }, now);
    });
    assert_eq!(read(&mut slave, 0x2031, 1), [2, 0, 0, 0]);
    // A test that does not end is started again.
    for _ in 0..2 {
        slave.clear();
        assert_eq!(write(&mut slave, 0x2030, 0, &[1]), done(0x2030, 0));
        assert!(slave.events.contains(&SlaveEvent::SelfTest));
    }
    slave.touch(|slave, now| {
        slave.report_self_test(SelfTest { progress: SelfTest::FAILED, failures: 0x8000_0002 }, now);
    });
    assert_eq!(read(&mut slave, 0x2031, 1), [3, 0, 0, 0]);
    assert_eq!(read(&mut slave, 0x2031, 2), [2, 0, 0, 0x80]);
    // A segmented download of one byte starts it too.
    slave.clear();
    assert_eq!(ask(&mut slave, [0x21, 0x30, 0x20, 0, 1, 0, 0, 0]), done(0x2030, 0));
    assert_eq!(ask(&mut slave, [0x0D, 1, 0, 0, 0, 0, 0, 0]), [0x20, 0, 0, 0, 0, 0, 0, 0]);
    assert!(slave.events.contains(&SlaveEvent::SelfTest));
    // The next test begins without the failures of the last one.
    assert_eq!(write(&mut slave, 0x2030, 0, &[1]), done(0x2030, 0));
    assert_eq!(read(&mut slave, 0x2031, 1), [1, 0, 0, 0]);
    assert_eq!(read(&mut slave, 0x2031, 2), [0, 0, 0, 0]);
}

/// Verifies: ECSS 5.3.3.2.3i, 6.1a, 8.3.3g
/// Notices: ECSS 5.3.3.2.3i: the SDO server stays in a transfer of the bus that was left.
/// Notices: ECSS 8.3.3g: a slave goes on sending on the bus that the master left.
#[test]
fn a_transfer_under_way_ends_when_the_bus_changes() {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    // A segmented upload of the device name has begun.
    assert_eq!(ask(&mut slave, [0x40, 0x08, 0x10, 0, 0, 0, 0, 0])[0], 0x41);
    slave.clear();
    slave.receive(REDUNDANT, 0x701, &[5]);
    let abort = frame(0x585, &refused(0x1008, 0, 0x0800_0022));
    assert!(slave.frames().contains(&(REDUNDANT, abort)), "{:?}", slave.frames());
    slave.clear();
    slave.run_until(ms(2_000));
    assert!(slave.frames().iter().all(|(_, frame)| frame.id().raw() != 0x585));
}
