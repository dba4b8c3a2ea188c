//! What the application of a slave changes itself takes effect as if it had been written over the bus.

use ecss_can::link::port::Filter;
use ecss_can::node::{BusCommand, SlaveEvent};
use ecss_can::od::{INVALID, NO_REMOTE};
use ecss_can::pdo::Mapping;
use ecss_can::types::{Address, Bus, CobId, NmtState, Scet};
use mission::MissionObjects;

use super::fixture::{operational, payloads, powered};
use crate::bench::{Bench, NOMINAL, REDUNDANT, ms, node};
use crate::slave::TestSlave;

const VALUE: u32 = 0x6210_0020;

/// Changes an object of the slave and tells it.
fn change(
    slave: &mut Bench<TestSlave>,
    at: (u16, u8),
    change: impl FnOnce(&mut ecss_can::node::NodeObjects<mission::MissionObjects<Vec<u8>>>),
) {
    slave.touch(|slave, now| {
        change(slave.objects_mut());
        slave.changed(Address::new(at.0, at.1), now);
    });
}

#[test]
fn the_redundancy_follows_its_parameters() {
    let mut slave = powered();
    change(&mut slave, (0x2000, 1), |objects| objects.spacecraft.redundancy.parameters.bdefault = 1);
    assert_eq!(slave.node.status(slave.now).redundancy.bdefault, REDUNDANT);
    change(&mut slave, (0x2000, 2), |objects| objects.spacecraft.redundancy.parameters.ttoggle = 4);
    change(&mut slave, (0x2000, 3), |objects| objects.spacecraft.redundancy.parameters.ntoggle = 1);
    change(&mut slave, (0x1016, 1), |objects| objects.consumers.consumer_heartbeat[0] = 1 << 16 | 100);
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

#[test]
fn the_heartbeat_follows_its_period() {
    let mut slave = powered();
    change(&mut slave, (0x1017, 0), |objects| objects.communication.heartbeat.time = 50);
    slave.clear();
    slave.run_until(ms(200));
    assert_eq!(slave.times(NOMINAL, 0x705), [50, 100, 150, 200]);
}

#[test]
fn other_heartbeats_are_consumed_and_pass_the_filters() {
    let mut slave = powered();
    slave.receive(NOMINAL, 0x701, &[5]);
    slave.clear();
    change(&mut slave, (0x1016, 2), |objects| objects.consumers.consumer_heartbeat[1] = 7 << 16 | 100);
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

#[test]
fn sync_and_emergency_follow_their_objects() {
    let mut slave = operational();
    change(&mut slave, (0x1005, 0), |objects| objects.communication.sync.cob_id = 0x82);
    let filter = Filter::exact(CobId::new(0x082).unwrap());
    assert!(slave.controls.contains(&(REDUNDANT, BusCommand::Filter { number: 1, filter })));
    slave.clear();
    slave.receive(NOMINAL, 0x080, &[]);
    assert_eq!(slave.frames(), []);
    slave.receive(NOMINAL, 0x082, &[]);
    assert_eq!(payloads(&slave, 0x185).len(), 1);
    change(&mut slave, (0x1019, 0), |objects| objects.communication.sync.overflow = 5);
    change(&mut slave, (0x1014, 0), |objects| objects.communication.emcy.cob_id = 0x86);
    slave.clear();
    slave.receive(NOMINAL, 0x082, &[]);
    assert_eq!((payloads(&slave, 0x085).len(), payloads(&slave, 0x086).len()), (0, 1));
    change(&mut slave, (0x1014, 0), |objects| objects.communication.emcy.cob_id |= INVALID);
    slave.clear();
    slave.receive(NOMINAL, 0x082, &[1]);
    assert_eq!(slave.sent.len(), 1, "the Local Time PDO alone");
}

#[test]
fn the_clock_is_set() {
    let mut slave = powered();
    change(&mut slave, (0x2010, 1), |objects| objects.spacecraft.time.scet_set.coarse = 77);
    assert_eq!(slave.node.scet(slave.now), Scet::new(77, 0).unwrap());
}

#[test]
fn pdos_come_and_go_as_they_are_configured() {
    let mut slave = operational();
    change(&mut slave, (0x1601, 0), |objects| {
        objects.pdos.rpdo_mappings[1].map(&[VALUE]);
    });
    change(&mut slave, (0x1401, 1), |objects| objects.pdos.rpdos[1].cob_id = NO_REMOTE | 0x345);
    change(&mut slave, (0x1801, 1), |objects| {
        objects.pdos.tpdos[1].cob_id = NO_REMOTE | 0x285;
        objects.pdos.tpdos[1].transmission = 254;
    });
    // It carries nothing yet.
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(1, now));
    assert_eq!(slave.frames(), []);
    change(&mut slave, (0x1A01, 0), |objects| {
        objects.pdos.tpdo_mappings[1].map(&[VALUE]);
    });
    change(&mut slave, (0x1801, 1), |objects| objects.pdos.tpdos[1].cob_id = NO_REMOTE | 0x285);
    slave.clear();
    slave.receive(NOMINAL, 0x305, &[9; 8]);
    slave.receive(NOMINAL, 0x345, &[7, 0, 0, 0]);
    assert_eq!(slave.events, [SlaveEvent::Pdo { bus: NOMINAL, number: 1, data: [7, 0, 0, 0, 0, 0, 0, 0] }]);
    assert_eq!(slave.node.objects().application.value, 7);
    change(&mut slave, (MissionObjects::VALUE.address().index, 0), |objects| objects.application.value = 8);
    assert_eq!(payloads(&slave, 0x285), [[8, 0, 0, 0]]);
}

#[test]
fn a_pdo_that_cannot_be_is_not_valid_and_others_go_on() {
    let telemetry_goes = |slave: &mut Bench<TestSlave>| {
        slave.clear();
        slave.touch(|slave, now| slave.send_pdo(2, now));
        payloads(slave, 0x385).len() == 1
    };
    // The COB-ID of another one.
    let mut slave = operational();
    change(&mut slave, (0x1801, 1), |objects| {
        objects.pdos.tpdo_mappings[1].map(&[VALUE]);
        objects.pdos.tpdos[1].cob_id = NO_REMOTE | 0x385;
        objects.pdos.tpdos[1].transmission = 254;
    });
    slave.clear();
    slave.touch(|slave, now| slave.send_pdo(1, now));
    assert_eq!(slave.frames(), []);
    assert!(telemetry_goes(&mut slave));
    // A transmission type that there is not, on one that was valid; and an object that there is not.
    change(&mut slave, (0x1802, 2), |objects| objects.pdos.tpdos[2].transmission = 245);
    assert!(!telemetry_goes(&mut slave));
    change(&mut slave, (0x1802, 2), |objects| objects.pdos.tpdos[2].transmission = 254);
    assert!(!telemetry_goes(&mut slave), "it reads not valid");
    change(&mut slave, (0x1802, 1), |objects| objects.pdos.tpdos[2].cob_id &= !INVALID);
    assert!(telemetry_goes(&mut slave));
    change(&mut slave, (0x1A02, 0), |objects| objects.pdos.tpdo_mappings[2].map(&[0x6000_0020]));
    assert!(!telemetry_goes(&mut slave));
    change(&mut slave, (0x1601, 0), |objects| objects.pdos.rpdo_mappings[1].map(&[0x6000_0020]));
    slave.clear();
    slave.receive(NOMINAL, 0x305, &[9; 8]);
    assert_eq!(slave.events, []);
    assert_ne!(slave.node.objects().application.telecommand.code, 0x0909);
}
