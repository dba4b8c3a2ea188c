//! A minimal slave of profile `librecube` and the frames of the LibreCube prototype, byte by byte.
//!
//! Only node 2 and a foreign node are on the buses. The foreign node sends what the prototype's master sends. Identifiers are those of
//! the table of objects in the prototype's slides (CAN in Space workshop, June 2017), contents those of its listing of a slave.

use can_twin::wire::time::Time;
use ecss_can::node::Node;
use ecss_can::node::minimal::MinimalSlave;
use ecss_can::types::{Bus, CobId, NodeId};
use ecss_can_worlds::World;
use mission::LIBRECUBE;
use mission::minimal::MinimalMission;
use mission::minimal::prototype::PrototypeMission;

use crate::indicators::IndicatorLog;
use crate::mission_world::minimal_application;
use crate::support::*;

/// Spacecraft time 305,419,896.5 s: fine time, then coarse time, both little-endian.
const TIME: [u8; 7] = [0x00, 0x00, 0x80, 0x78, 0x56, 0x34, 0x12];
/// Units of 2^-24 s in two microseconds.
const TWO_US: i64 = 34;

/// Returns a world after the first heartbeats of node 2 and of the master.
fn powered() -> World {
    powered_nodes(&[TWO])
}

/// Returns a world as [`powered`] does, with these nodes.
fn powered_nodes(nodes: &[NodeId]) -> World {
    let slave = |id| MinimalSlave::builder(id, &LIBRECUBE, PrototypeMission::new()).build();
    let mut builder = World::builder();
    for &id in nodes {
        let application =
            move |slave, events| minimal_application(slave, events, id, IndicatorLog::default());
        builder = builder.board(id, move |_| slave(id), application);
    }
    let mut world = builder.build();
    world.run_until(ms(100));
    asks(&mut world, 0x701, &[0x05]);
    world
}

/// Sends a frame, and returns the frames of node 2 within 20 ms except its heartbeat.
fn asks(world: &mut World, id: u16, data: &[u8]) -> Vec<(u16, Vec<u8>)> {
    let from = world.now();
    world.inject(Bus::Nominal, standard(id, data));
    world.run_for(ms(20));
    assert!(world.frames(Bus::Redundant).is_empty());
    let frames = world.frames(Bus::Nominal).iter();
    let sent = frames.filter(|sent| sent.end > from && sent.node == Some(TWO) && sent.id() != Some(0x702));
    sent.map(|sent| (sent.id().unwrap(), sent.frame.payload().to_vec())).collect()
}

/// Returns the only frame.
fn only(mut frames: Vec<(u16, Vec<u8>)>) -> (u16, Vec<u8>) {
    assert_eq!(frames.len(), 1, "{frames:02X?}");
    frames.remove(0)
}

/// Returns coarse and fine time as one number, units of 2^-24 s.
fn units(data: &[u8]) -> i64 {
    data.iter().rev().fold(0, |units, byte| units << 8 | i64::from(*byte))
}

/// Verifies: ECSS 6.5.2a, 9.4.9.2a
#[test]
fn prototype_sends_its_heartbeat_every_250_ms() {
    let mut world = powered();
    world.run_until(ms(1_100));
    let beats = since(&world, Bus::Nominal, 0x702, Time::ZERO);
    assert_eq!(beats.len(), 5);
    assert!(beats.iter().all(|sent| sent.frame.payload() == [0x05]));
    let periods = periods_us(&beats);
    // The first one is pending until a node acknowledges it.
    assert!(periods[1..].iter().all(|period| (249_800..250_200).contains(period)), "{periods:?}");
}

/// The listing answers request 0001h with the data 665544332211h, whatever stands behind the code.
///
/// Verifies: ECSS 9.4.2b, 9.4.3b.1, 9.4.1a, 9.4.3a
#[test]
fn request_brings_the_telemetry_of_the_prototype() {
    let mut world = powered();
    let dummy = [0x11, 0x22, 0x33, 0x44, 0x55, 0x66];
    for (request, code) in [
        (&[0x01, 0x00][..], [0x01, 0x00]),
        (&[0x01, 0x00, 0xAA, 0xBB, 0xCC, 0xDD, 0xEE, 0xFF], [0x01, 0x00]),
        (&[0xFF, 0xFF, 0x00], [0xFF, 0xFF]),
    ] {
        let telemetry = [&code[..], &dummy].concat();
        assert_eq!(asks(&mut world, 0x402, request), [(0x382, telemetry)]);
    }
    assert_eq!(asks(&mut world, 0x402, &[0x01]), [], "half a code");
    // Only full slaves know this request, for the kind of their stamps.
    assert_eq!(asks(&mut world, 0x402, &[0x04, 0x01]), []);
}

/// Given commands with a code of 2 bytes, up to 6 bytes of data, and no sequence, then each frame is executed.
///
/// Verifies: ECSS 9.4.2a, 9.4.2b, 9.4.1a, 9.4.1c
/// Notices: ECSS 9.4.2b: the prototype exchanges the telemetry of codes 102h and 103h.
#[test]
fn commands_are_executed_as_often_as_they_come() {
    let mut world = powered();
    let command = [0x02, 0x00, 0x78, 0x56, 0x34, 0x12];
    for _ in 0..3 {
        assert_eq!(asks(&mut world, 0x302, &command), []);
    }
    // An unknown command, and one that is too short.
    assert_eq!(asks(&mut world, 0x302, &[0x99, 0x99]), []);
    assert_eq!(asks(&mut world, 0x302, &[0x02]), []);
    let value = only(asks(&mut world, 0x402, &[0x02, 0x01]));
    assert_eq!(value, (0x382, vec![0x02, 0x01, 0x78, 0x56, 0x34, 0x12, 0, 0]));
    let executed = only(asks(&mut world, 0x402, &[0x03, 0x01]));
    assert_eq!(executed, (0x382, vec![0x03, 0x01, 3, 0, 0, 0, 0, 0]));
}

/// Given a SYNC and the spacecraft time of it 20 ms later, when another SYNC comes after a second, then 182h has the time of that SYNC.
///
/// Verifies: ECSS 7.2.2e, 7.2.3c, 7.2.3g, 7.2.3k, 9.4.3b.2
/// Notices: ECSS 7.2.3c: the time is taken for that of its arrival.
#[test]
fn sync_brings_the_local_time_that_181h_has_set() {
    let mut world = powered();
    let (id, data) = only(asks(&mut world, 0x080, &[]));
    assert_eq!((id, data.len()), (0x182, 7));
    // 120 ms after power-on. An unset clock counts from power-on.
    let since_power_on = (units(&data) * 1_000) >> 24;
    assert!((119..=121).contains(&since_power_on), "{since_power_on} ms");
    assert_eq!(asks(&mut world, 0x181, &TIME), []);
    world.run_for(ms(960));
    let (_, data) = only(asks(&mut world, 0x080, &[]));
    let error = units(&data) - (units(&TIME) + (1 << 24));
    assert!(error.abs() <= TWO_US, "{error} units of 2^-24 s");
}

/// Given no SYNC before it, then the spacecraft time is that of the end of its own frame.
///
/// Verifies: ECSS 7.2.2c, 9.4.8a, 7.1.2f, 9.4.3b
/// Notices: ECSS 9.4.3b: the spacecraft time brings telemetry of the prototype.
#[test]
fn time_without_sync_is_that_of_its_frame() {
    let mut world = powered();
    assert_eq!(asks(&mut world, 0x181, &TIME), []);
    let (id, data) = only(asks(&mut world, 0x080, &[]));
    assert_eq!(id, 0x182);
    // 20 ms, less 48 bits of SYNC instead of more than 100 of the time.
    let later = ((units(&data) - units(&TIME)) * 1_000_000) >> 24;
    assert!((19_850..=20_000).contains(&later), "{later} us");
    // Six bytes are not a valid time.
    assert_eq!(asks(&mut world, 0x181, &[0; 6]), []);
    let (_, data) = only(asks(&mut world, 0x080, &[]));
    assert!(units(&data) > units(&TIME), "as before");
}

/// Given the spacecraft time by 181h, when time stamp objects come, with the six bytes of CiA 301 or with as many as the spacecraft time,
/// then SYNC brings the local time that 181h has set. The filters of no shipped device admit 100h.
///
/// Verifies: ECSS 9.4.7.1a
/// Notices: ECSS 9.4.7.1a: RPDO 1 of the prototype is 100h.
#[test]
fn time_stamp_object_does_not_set_the_local_time() {
    let mut world = powered();
    assert_eq!(asks(&mut world, 0x181, &TIME), []);
    for stamp in [&[0x11; 6][..], &[0x11; 7]] {
        assert_eq!(asks(&mut world, 0x100, stamp), []);
    }
    let (_, data) = only(asks(&mut world, 0x080, &[]));
    // Three times 20 ms.
    let later = ((units(&data) - units(&TIME)) * 1_000) >> 24;
    assert!((59..=60).contains(&later), "{later} ms");

    let prototype = MinimalSlave::builder(TWO, &LIBRECUBE, PrototypeMission::new()).build().filters();
    let standard = MinimalSlave::builder(TWO, &LIBRECUBE, MinimalMission::new()).build().filters();
    let stamp = CobId::new(0x100).unwrap();
    assert!(prototype.iter().chain(&standard).all(|filter| !filter.admits(stamp)));
}

/// RPDO 1 is 181h, so no node receives 202h, and three receive PDOs are left. The fourth is both command and request.
///
/// Verifies: ECSS 9.4.3a, 9.4.1a, 9.4.3b.1
#[test]
fn three_receive_pdos_are_left_for_commands_and_requests() {
    let mut world = powered();
    assert_eq!(asks(&mut world, 0x202, &[1, 2, 3]), []);
    assert_eq!(asks(&mut world, 0x502, &[1, 2, 3]), [(0x482, vec![])]);
    assert_eq!(asks(&mut world, 0x502, &[]), [(0x482, vec![1, 2, 3])]);
    assert_eq!(asks(&mut world, 0x502, &[9; 8]), [(0x482, vec![])]);
    assert_eq!(asks(&mut world, 0x502, &[]), [(0x482, vec![9; 8])]);
}

/// Verifies: ECSS 9.4.6.1a, 9.4.7.1a, 9.4.7.2a, 9.4.7.2b, 9.4.8a
#[test]
fn prototype_answers_neither_nmt_nor_sdo_nor_time_stamp() {
    let mut world = powered();
    let frames: [(u16, &[u8]); 6] = [
        (0x000, &[0x02, 2]),
        (0x000, &[0x81, 0]),
        (0x100, &[0; 6]),
        (0x602, &[0x40, 0x10, 0x20, 1, 0, 0, 0, 0]),
        (0x082, &[0x00, 0x10, 1, 0, 0, 0, 0, 0]),
        (0x080, &[1]),
    ];
    for (id, data) in frames {
        assert_eq!(asks(&mut world, id, data), [], "{id:03X}h");
    }
    let beats = since(&world, Bus::Nominal, 0x702, Time::ZERO);
    assert!(beats.iter().all(|sent| sent.frame.payload() == [0x05]));
}

/// Given nodes 2 and 3 whose clocks were not set, when a SYNC comes, then each sends its local time once, by 180h and its Node-ID. No
/// node sends 181h.
///
/// Verifies: ECSS 7.2.2d, 7.2.2f, 7.2.2g, 7.2.3i, 7.2.3j
/// Notices: ECSS 7.2.2d: minimal slaves send their local time by 181h.
/// Notices: ECSS 7.2.2g: a minimal slave has no Local Time PDO until its clock is set.
/// Notices: ECSS 7.2.2f: a minimal slave sends no local time before it is set.
/// Notices: ECSS 7.2.3i: SYNC brings no local time of a clock that counts from power-on.
/// Notices: ECSS 7.2.3j: all minimal slaves send their local time by 182h.
#[test]
fn each_prototype_sends_its_own_local_time_before_it_is_set() {
    let mut world = powered_nodes(&[TWO, THREE]);
    let from = world.now();
    world.inject(Bus::Nominal, standard(0x080, &[]));
    world.run_for(ms(20));
    let frames = world.frames(Bus::Nominal).iter().filter(|sent| sent.end > from);
    let times = frames.filter_map(|sent| sent.id().filter(|id| (0x181..0x200).contains(id)).zip(sent.node));
    let mut times: Vec<_> = times.collect();
    times.sort_unstable();
    assert_eq!(times, [(0x182, TWO), (0x183, THREE)]);
}
