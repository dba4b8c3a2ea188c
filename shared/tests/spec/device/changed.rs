//! What the application of a slave changes itself takes effect as if it had been written over the bus.

use ecss_can::link::port::Filter;
use ecss_can::node::extend::BusCommand;
use ecss_can::node::{DeviceNode, Node, SlaveEvent};
use ecss_can::od::{INVALID, NO_REMOTE};
use ecss_can::types::{AbortCode, Bus, CobId, NmtState, Scet};

use super::fixture::{self as client, Memory, operational, payloads, powered, powered_with};
use crate::bench::{Bench, NOMINAL, REDUNDANT, ms, node, pdos};
use crate::slave::TestSlave;

const VALUE: u32 = 0x6210_0020;

/// The application of the slave writes objects.
fn write_all(slave: &mut Bench<TestSlave>, values: &[((u16, u8), &[u8])]) {
    for (at, value) in values {
        assert_eq!(slave.write(*at, value), Ok(()), "{at:X?}");
    }
}

/// The same, a COB-ID or an entry of four bytes.
fn write(slave: &mut Bench<TestSlave>, at: (u16, u8), value: u32) -> Result<(), AbortCode> {
    slave.write(at, &value.to_le_bytes())
}

/// Verifies: ECSS 8.3.1a, 8.3.3e.2, 8.3.3h, 8.3.3i, 8.3.3j
/// Notices: ECSS 8.3.3h: the switch comes at the first consumer time missed.
/// Notices: ECSS 8.3.3j: a slave with Ntoggle 1 goes back to the first bus.
#[test]
fn the_redundancy_follows_its_parameters() {
    let mut slave = powered();
    write_all(&mut slave, &[((0x2000, 1), &[1])]);
    assert_eq!(slave.node.status(slave.now).redundancy.bdefault, REDUNDANT);
    write_all(&mut slave, &[((0x2000, 2), &[4]), ((0x2000, 3), &[1]), ((0x1016, 1), &[100, 0, 1, 0])]);
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    slave.run_until(ms(99));
    assert_eq!(slave.events, []);
    slave.run_until(ms(399));
    assert_eq!(slave.events[0], SlaveEvent::MasterMissed { bus: NOMINAL });
    assert_eq!(slave.node.status(slave.now).active, NOMINAL);
    slave.run_until(ms(400));
    assert_eq!(slave.node.status(slave.now).active, REDUNDANT);
    // One switch is all that it has.
    slave.run_until(ms(800));
    assert_eq!(slave.events.last(), Some(&SlaveEvent::GaveUp { bus: REDUNDANT }));
}

/// Verifies: ECSS 8.3.3d, 6.5.2a
/// Notices: ECSS 8.3.3d: a written 1017h ends the heartbeat of the slave.
#[test]
fn the_heartbeat_follows_its_period() {
    let mut slave = powered();
    write_all(&mut slave, &[((0x1017, 0), &[50, 0])]);
    slave.clear();
    slave.run_until(ms(200));
    assert_eq!(slave.times(NOMINAL, 0x705), [50, 100, 150, 200]);
}

/// Given a slave whose stored 1017h is zero, when a client writes 50 ms at 100 ms, then the heartbeat begins at once.
///
/// Verifies: ECSS 8.3.3d, 6.5.2a
/// Notices: ECSS 8.3.3d: 1017h that was zero at power-on begins no heartbeat.
#[test]
fn a_slave_without_heartbeat_begins_one_that_is_written() {
    let memory = Memory::default();
    let mut before = powered_with(&memory);
    write_all(&mut before, &[((0x1017, 0), &[0, 0])]);
    assert_eq!(client::write(&mut before, 0x1010, 1, b"save"), client::done(0x1010, 1));
    let mut slave = powered_with(&memory);
    slave.run_until(ms(100));
    slave.clear();
    write_all(&mut slave, &[((0x1017, 0), &[50, 0])]);
    slave.run_until(ms(220));
    assert_eq!(slave.times(NOMINAL, 0x705), [100, 150, 200]);
}

/// Verifies: ECSS 6.4a, 6.4a.2, 6.5.2a, 8.2.2a
/// Notices: ECSS 6.5.2a: a slave does not consume the heartbeat of a node that 1016h names from now on.
/// Notices: ECSS 8.2.2a: the filter for a heartbeat is set in the nominal controller alone.
#[test]
fn other_heartbeats_are_consumed_and_pass_the_filters() {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    write_all(&mut slave, &[((0x1016, 2), &[100, 0, 7, 0])]);
    let filter = Filter::exact(CobId::new(0x707).unwrap());
    let told = Bus::ALL.map(|bus| (bus, BusCommand::Filter { number: 5, filter }));
    assert_eq!(slave.controls, told);
    slave.receive(NOMINAL, 0x707, &[5]);
    let heard = SlaveEvent::PeerState { node: node(7), state: NmtState::Operational };
    assert!(slave.events.contains(&heard), "{:?}", slave.events);
    slave.run_until(ms(100));
    assert!(slave.events.contains(&SlaveEvent::PeerMissed { node: node(7) }));
    assert_eq!(payloads(&slave, 0x085), [[0x30, 0x81, 0x11, 7, 0, 0, 0, 0]]);
}

/// Verifies: ECSS 6.9e, 6.10a, 6.3b, 6.4a, 6.10c
/// Notices: ECSS 6.9e: after a write of 1005h the filters still accept the old SYNC only.
/// Notices: ECSS 6.10a: a written 1014h does not reach the producer of EMCY.
/// Notices: ECSS 6.10c: the COB-ID of EMCY cannot be changed.
#[test]
fn sync_and_emergency_follow_their_objects() {
    let mut slave = operational();
    write(&mut slave, (0x1005, 0), 0x82).unwrap();
    let filter = Filter::exact(CobId::new(0x082).unwrap());
    assert!(slave.controls.contains(&(REDUNDANT, BusCommand::Filter { number: 1, filter })));
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(slave.frames(), []);
    slave.receive(NOMINAL, 0x082, &[]);
    assert_eq!(payloads(&slave, 0x185).len(), 1);
    write_all(&mut slave, &[((0x1019, 0), &[5])]);
    write(&mut slave, (0x1014, 0), INVALID | 0x85).unwrap();
    write(&mut slave, (0x1014, 0), 0x86).unwrap();
    slave.clear();
    slave.receive(NOMINAL, 0x082, &[]);
    assert_eq!((payloads(&slave, 0x085).len(), payloads(&slave, 0x086).len()), (0, 1));
    write(&mut slave, (0x1014, 0), INVALID | 0x86).unwrap();
    slave.clear();
    slave.receive(NOMINAL, 0x082, &[1]);
    assert_eq!(slave.sent.len(), 1, "the Local Time PDO alone");
}

/// Verifies: ECSS 7.1.2c
/// Notices: ECSS 7.1.2c: a write of 2010h leaves the clock as it is.
#[test]
fn the_clock_is_set() {
    let mut slave = powered();
    write(&mut slave, (0x2010, 1), 77).unwrap();
    slave.write((0x2010, 2), &[0; 3]).unwrap();
    assert_eq!(slave.node.scet(slave.now), Scet::new(77, 0).unwrap());
}

/// Verifies: ECSS 6.2a, 6.10a, 6.10c
/// Notices: ECSS 6.2a: a TPDO without a mapping becomes valid.
/// Notices: ECSS 6.10c: an RPDO keeps its old COB-ID.
#[test]
fn pdos_come_and_go_as_they_are_configured() {
    let mut slave = operational();
    write(&mut slave, (0x1401, 1), INVALID | NO_REMOTE | 0x305).unwrap();
    write_all(&mut slave, &[((0x1601, 0), &[0]), ((0x1601, 1), &VALUE.to_le_bytes()), ((0x1601, 0), &[1])]);
    write(&mut slave, (0x1401, 1), NO_REMOTE | 0x345).unwrap();
    write_all(&mut slave, &[((0x1801, 2), &[254])]);
    // It carries nothing yet.
    let refused = write(&mut slave, (0x1801, 1), NO_REMOTE | 0x285);
    assert_eq!(refused, Err(AbortCode::ParameterIncompatible));
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(1, now));
    assert_eq!(slave.frames(), []);
    write_all(&mut slave, &[((0x1A01, 0), &[0]), ((0x1A01, 1), &VALUE.to_le_bytes()), ((0x1A01, 0), &[1])]);
    write(&mut slave, (0x1801, 1), NO_REMOTE | 0x285).unwrap();
    slave.clear();
    slave.receive(NOMINAL, 0x305, &[9; 8]);
    slave.receive(NOMINAL, 0x345, &[7, 0, 0, 0]);
    assert_eq!(pdos(&slave.events), [Some((NOMINAL, 1, [7, 0, 0, 0, 0, 0, 0, 0]))]);
    assert_eq!(slave.node.objects().application.value, 7);
    slave.touch(|slave, now| slave.change(now, |objects| objects.value = 8));
    assert_eq!(payloads(&slave, 0x285), [[8, 0, 0, 0]]);
}

/// Given an operational slave with an event-driven PDO of 6210h, when its application changes objects, then the PDO goes out
/// if and only if what it carries is another value than before.
///
/// Verifies: ECSS 6.2a, 6.5.4a
/// Notices: ECSS 6.5.4a: a change in Pre-operational is sent after the next Start.
#[test]
fn a_pdo_goes_out_when_its_content_has_changed() {
    let mut slave = operational();
    write_all(&mut slave, &[((0x1801, 2), &[254]), ((0x1A01, 1), &VALUE.to_le_bytes()), ((0x1A01, 0), &[1])]);
    write(&mut slave, (0x1801, 1), NO_REMOTE | 0x285).unwrap();
    let sent = |slave: &mut Bench<TestSlave>, values: &[u32]| {
        slave.clear();
        slave.touch(|slave, now| {
            slave.change(now, |objects| values.iter().for_each(|value| objects.value = *value));
        });
        payloads(slave, 0x285)
    };
    assert_eq!(sent(&mut slave, &[5]), [[5, 0, 0, 0]]);
    assert_eq!(sent(&mut slave, &[5]), [[0_u8; 4]; 0], "the same value");
    assert_eq!(sent(&mut slave, &[6, 5]), [[0_u8; 4]; 0], "there and back");
    assert_eq!(sent(&mut slave, &[6, 7]), [[7, 0, 0, 0]], "once");
    // What a client wrote is not what the application changed.
    write(&mut slave, (0x6210, 0), 9).unwrap();
    assert_eq!(sent(&mut slave, &[]), [[0_u8; 4]; 0]);
    // Not in Pre-operational, and not later for what happened there.
    slave.receive(NOMINAL, 0x000, &[0x80, 5]);
    assert_eq!(sent(&mut slave, &[10]), [[0_u8; 4]; 0]);
    slave.receive(NOMINAL, 0x000, &[1, 5]);
    assert_eq!(payloads(&slave, 0x285), [[0_u8; 4]; 0]);
}

/// The rules for clients hold for the application: what cannot be is refused, and all PDOs go on as they are.
///
/// Verifies: ECSS 6.2a, 6.10b
/// Notices: ECSS 6.10b: a TPDO takes the COB-ID of another TPDO.
#[test]
fn a_pdo_that_cannot_be_is_refused_and_others_go_on() {
    let telemetry_goes = |slave: &mut Bench<TestSlave>| {
        slave.clear();
        slave.touch(|slave, now| slave.send_pdo(2, now));
        payloads(slave, 0x385).len() == 1
    };
    // The COB-ID of another one.
    let mut slave = operational();
    write_all(&mut slave, &[((0x1801, 2), &[254]), ((0x1A01, 1), &VALUE.to_le_bytes()), ((0x1A01, 0), &[1])]);
    let refused = write(&mut slave, (0x1801, 1), NO_REMOTE | 0x385);
    assert_eq!(refused, Err(AbortCode::ParameterIncompatible));
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(1, now));
    assert_eq!(slave.frames(), []);
    assert!(telemetry_goes(&mut slave));
    // A transmission type that there is not, on one that is valid; a mapping while it is; an object that there is not.
    assert_eq!(slave.write((0x1802, 2), &[245]), Err(AbortCode::ValueRange));
    assert_eq!(slave.write((0x1A02, 0), &[0]), Err(AbortCode::UnsupportedAccess));
    assert_eq!(slave.write((0x1601, 0), &[0]), Err(AbortCode::UnsupportedAccess));
    assert!(telemetry_goes(&mut slave));
    write(&mut slave, (0x1401, 1), INVALID | NO_REMOTE | 0x305).unwrap();
    write_all(&mut slave, &[((0x1601, 0), &[0])]);
    assert_eq!(write(&mut slave, (0x1601, 1), 0x6000_0020), Err(AbortCode::NoObject));
    slave.clear();
    slave.receive(NOMINAL, 0x305, &[9; 8]);
    assert_eq!(slave.events, []);
    assert_ne!(slave.node.objects().application.telecommand.code, 0x0909);
    assert_eq!(payloads(&slave, 0x085), [[0_u8; 8]; 0]);
}

/// Given a slave that hears the master and node 7, then it sends nothing with a COB-ID of these two in the pre-defined
/// connection set; that of a node which it does not know is free.
///
/// Verifies: ECSS 6.10l, 6.10m, 7.2.2d, 7.2.2g, 7.2.3j
/// Notices: ECSS 6.10l: a slave may take a COB-ID of a master that 1016h does not name.
/// Notices: ECSS 6.10m: TPDO 4 of another node is not known as that of another node.
/// Notices: ECSS 7.2.2d: a slave may send 181h when it does not consume the heartbeat of the master.
/// Notices: ECSS 7.2.2g: a slave may send the Local Time PDO of another one.
/// Notices: ECSS 7.2.3j: 180h and Node-ID are not known as those of another node.
#[test]
fn cob_ids_of_other_senders_are_refused() {
    let mut slave = operational();
    write_all(&mut slave, &[((0x1016, 2), &[100, 0, 7, 0])]);
    write(&mut slave, (0x1800, 1), INVALID | NO_REMOTE | 0x185).unwrap();
    write(&mut slave, (0x1014, 0), INVALID | 0x85).unwrap();
    for function in [0x180, 0x280, 0x380, 0x480] {
        for other in [1, 7] {
            let refused = write(&mut slave, (0x1800, 1), NO_REMOTE | function | other);
            assert_eq!(refused, Err(AbortCode::ParameterIncompatible), "{function:X}h + {other}");
        }
        for own in [5, 6] {
            write(&mut slave, (0x1800, 1), NO_REMOTE | function | own).unwrap_or_else(|code| {
                assert_eq!(
                    (code, function, own),
                    (AbortCode::ParameterIncompatible, 0x380, 5),
                    "that of TPDO 3"
                );
            });
            write(&mut slave, (0x1800, 1), INVALID | NO_REMOTE | function | own).unwrap();
        }
    }
    assert_eq!(write(&mut slave, (0x1014, 0), 0x87), Err(AbortCode::ParameterIncompatible));
    write(&mut slave, (0x1014, 0), 0x85).unwrap();
    // The master is another node whether 1016h names it or not.
    write_all(&mut slave, &[((0x1016, 1), &[0; 4])]);
    assert_eq!(write(&mut slave, (0x1800, 1), NO_REMOTE | 0x281), Err(AbortCode::ParameterIncompatible));
    // What others send may be received.
    write(&mut slave, (0x1401, 1), INVALID | NO_REMOTE | 0x305).unwrap();
    write(&mut slave, (0x1401, 1), NO_REMOTE | 0x187).unwrap();
}

/// Given entries of 1016h with the Node-ID of the master, of which one is in use, when the master falls silent, then the slave
/// misses it after the time of that entry. An entry without a time or without a Node-ID is not in use (CiA 301 7.5.2.15).
///
/// Verifies: ECSS 6.5.2b, 8.3.1c, 8.3.3c, 6.5.2a
/// Notices: ECSS 6.5.2b: the first entry of 1016h counts, whatever node it names.
/// Notices: ECSS 8.3.3c: only sub-index 1 of 1016h makes a slave a consumer of the master's heartbeat.
/// Notices: ECSS 6.5.2a: an entry of 1016h without a time is in use.
#[test]
fn master_is_missed_by_its_entry_in_use() {
    const NOT_IN_USE: [[u8; 4]; 4] = [[0, 0, 1, 0], [0; 4], [0xFA, 0, 0, 0], [100, 0, 0x81, 0]];
    for first in NOT_IN_USE {
        let mut slave = powered();
        slave.receive(NOMINAL, 0x701, &[5]);
        write_all(&mut slave, &[((0x1016, 1), &first), ((0x1016, 2), &[0xFA, 0, 1, 0])]);
        slave.clear();
        slave.run_until(ms(249));
        assert_eq!(slave.events, [], "{first:02X?}");
        slave.run_until(ms(250));
        assert_eq!(slave.events.first(), Some(&SlaveEvent::MasterMissed { bus: NOMINAL }), "{first:02X?}");
    }
}

/// Given that no entry in use has the Node-ID of the master, when the master falls silent, then the slave does not miss it.
///
/// Verifies: ECSS 6.5.2b, 8.3.1c, 6.5.2a
/// Notices: ECSS 6.5.2b: a written 1016h is obeyed after the next boot only.
#[test]
fn master_without_an_entry_in_use_is_not_missed() {
    for first in [[0, 0, 1, 0], [0; 4], [0xFA, 0, 0, 0], [0xFA, 0, 0x81, 0]] {
        let mut slave = powered();
        slave.receive(NOMINAL, 0x701, &[5]);
        write_all(&mut slave, &[((0x1016, 1), &first)]);
        slave.clear();
        slave.run_until(ms(10_000));
        assert_eq!(slave.events, [], "{first:02X?}");
    }
}

/// Given an entry of 1016h that is not in use, then no filter admits the heartbeats of its node.
///
/// Verifies: ECSS 6.5.2a
#[test]
fn entry_without_a_time_admits_no_heartbeat() {
    let mut slave = powered();
    write_all(&mut slave, &[((0x1016, 2), &[0, 0, 7, 0])]);
    let heartbeat = CobId::new(0x707).unwrap();
    assert!(slave.node.filters().iter().all(|filter| !filter.admits(heartbeat)));
}
