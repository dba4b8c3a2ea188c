//! Minimal slaves with the profiles and devices that images use, in a busy network (ECSS 9).
//!
//! Verifies: ECSS 9.4.1a

use can_twin::wire::time::Time;
use ecss_can::node::minimal::{MinimalDevice, MinimalSlave, Payload};
use ecss_can::node::{MasterRequest, Refusal};
use ecss_can::od::{Access, DataType, Entry, Field, Objects, checked};
use ecss_can::pdo::{Mapping, StaticMapping};
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::runner::extend::WholeNode;
use ecss_can::sdo::Error;
use ecss_can::types::{Address, Bus, Instant, NodeId};
use ecss_can_worlds::World;
use ecss_can_worlds::world::Sent;
use mission::minimal::prototype::{PrototypeMission, PrototypeObjects};
use mission::minimal::{FixedPdo, MinimalMission, MinimalObjects};
use mission::{LIBRECUBE, MissionObjects, STANDARD};

use crate::indicators::IndicatorLog;
use crate::mission_world::{MissionMaster, minimal_application};
use crate::support::*;

const MINIMAL: NodeId = NodeId::of::<5>();

/// The mission with two full slaves, and a minimal one behind them.
const SPACECRAFT: Profile =
    Profile { minimal: &[MinimalNode { node: MINIMAL, has_heartbeat: true }], ..STANDARD };

/// Bit 31 of a COB-ID: the PDO is unused.
const NOT_IN_USE: u32 = 1 << 31;
/// Bit 30: remote frames are not allowed.
const NO_REMOTE: u32 = 1 << 30;
/// All other bits: the CAN-ID of a PDO with a standard frame.
const IDENTIFIER: u32 = !(NOT_IN_USE | NO_REMOTE);

fn entry<D: Objects>(index: u16, sub: u8) -> Option<&'static Entry> {
    D::DECLARED.find(Address::new(index, sub)).map(|(_, _, entry)| entry)
}

/// Asserts the structure of Tables 9-3 to 9-6: sub-indices 0 to 2 with their types, which no client writes, and nothing else.
fn assert_fixed<D: Objects>(objects: &mut D, index: u16) {
    for (sub, data_type) in [(0, DataType::Unsigned8), (1, DataType::Unsigned32), (2, DataType::Unsigned8)] {
        let entry = entry::<D>(index, sub).expect("number, COB-ID and type");
        assert!(!entry.access.is_writable() && entry.data_type == data_type, "{index:04X}h sub {sub}");
    }
    assert!(
        (3..=0xFF).all(|sub| entry::<D>(index, sub).is_none()),
        "{index:04X}h: inhibit time or event time"
    );
    let mut number = [0];
    checked::find(objects, Address::new(index, 0)).expect("it is there").read(0, &mut number);
    assert_eq!(number, [2], "{index:04X}h: number of entries");
}

/// Returns the CAN-ID of each PDO, `None` if it is unused, and its transmission type. Bit 29, which marks extended
/// identifiers, and the bits of such identifiers are kept.
fn of(pdos: [FixedPdo; 4]) -> [(Option<u32>, u8); 4] {
    pdos.map(|pdo| ((pdo.cob_id & NOT_IN_USE == 0).then_some(pdo.cob_id & IDENTIFIER), pdo.transmission))
}

/// Asserts the objects of Tables 9-1 and 9-2, without 1006h, which producers of SYNC have, and 1007h, which Table 9-12
/// forbids.
fn assert_minimal_set<D: Objects>() {
    for (index, sub) in [(0x1016, 1), (0x1017, 0), (0x1005, 0)] {
        assert!(entry::<D>(index, sub).is_some(), "{index:04X}h");
    }
    // The time stamp object, and the synchronous window.
    for index in [0x1012, 0x1013, 0x1007] {
        assert!(entry::<D>(index, 0).is_none(), "{index:04X}h");
    }
}

/// Given the devices of the shipped images, then parameters of commands and of telemetry have the entries of the tables, and they are
/// not changed. No PDO has an inhibit time or an event timer.
///
/// Verifies: ECSS 9.4.1d, 9.4.2d, 9.4.4b, 9.4.4c, 9.4.10e
/// Notices: ECSS 9.4.2d: the COB-ID of a PDO can be written.
#[test]
fn pdo_parameters_of_shipped_images_have_the_structure_of_the_tables() {
    for pdo in 0..4 {
        assert_fixed(&mut MinimalObjects::default(), 0x1400 + pdo);
        assert_fixed(&mut MinimalObjects::default(), 0x1800 + pdo);
        assert_fixed(&mut PrototypeObjects::default(), 0x1400 + pdo);
        assert_fixed(&mut PrototypeObjects::default(), 0x1800 + pdo);
    }
}

/// Given the devices of the shipped images, then no client writes the mapping of a PDO (1600h to 1603h, 1A00h to 1A03h): neither the number
/// of mapped objects nor one of them.
///
/// Verifies: ECSS 9.4.5a
/// Notices: ECSS 9.4.5a: the objects that RPDO 1 maps can be written.
#[test]
fn mappings_of_shipped_images_cannot_be_written() {
    fn assert_read_only<D: Objects>() {
        for index in (0x1600..=0x1603).chain(0x1A00..=0x1A03) {
            let entries: Vec<_> = (0..=0xFF).filter_map(|sub| entry::<D>(index, sub)).collect();
            assert!(entries.len() >= 2, "{index:04X}h: number of objects, and objects");
            assert!(entries.iter().all(|entry| !entry.access.is_writable()), "{index:04X}h");
        }
    }
    assert_read_only::<MinimalObjects>();
    assert_read_only::<PrototypeObjects>();
}

/// First and last index of objects that Table 9-12 forbids, and of SDO parameters, which it allows only for tests.
const FORBIDDEN: [(u16, u16); 8] = [
    (0x1007, 0x1007),
    (0x100C, 0x100D),
    (0x1010, 0x1015),
    (0x1200, 0x12FF),
    (0x1404, 0x15FF),
    (0x1604, 0x17FF),
    (0x1804, 0x19FF),
    (0x1A04, 0x1BFF),
];

/// Given the dictionaries of the shipped images, then no object that Table 9-12 forbids exists, and therefore none is
/// used.
///
/// Verifies: ECSS 9.4.10b, 9.4.10c, 9.4.10d, 9.4.7.3d, 9.4.10e
/// Notices: ECSS 9.4.10c: a minimal slave offers to store parameters (1010h).
/// Notices: ECSS 9.4.10d: 1014h of a minimal slave has a COB-ID that is used.
#[test]
fn dictionaries_of_shipped_images_have_no_forbidden_object() {
    for (first, last) in FORBIDDEN {
        for index in first..=last {
            assert!(entry::<MinimalObjects>(index, 0).is_none(), "{index:04X}h");
            assert!(entry::<PrototypeObjects>(index, 0).is_none(), "{index:04X}h");
        }
    }
    assert!(entry::<MinimalObjects>(0x1403, 0).is_some() && entry::<PrototypeObjects>(0x1A03, 0).is_some());
}

/// Returns a world with the shipped device in node 5 and a foreign node, at this bit rate. The master was heard.
fn alone(kbit: u32) -> World {
    let slave = |_| MinimalSlave::builder(MINIMAL, &SPACECRAFT, MinimalMission::new()).build();
    let application = |slave, events| minimal_application(slave, events, MINIMAL, IndicatorLog::default());
    let mut world = World::builder().board(MINIMAL, slave, application).kbit(kbit).build();
    world.run_until(ms(150));
    world.inject(Bus::Nominal, standard(0x701, &[0x05]));
    world.run_until(ms(210));
    world
}

/// Sends a frame, and returns the frames of the minimal slave within 30 ms except its heartbeat.
fn asked(world: &mut World, id: u16, data: &[u8]) -> Vec<Sent> {
    let from = world.now();
    world.inject(Bus::Nominal, standard(id, data));
    world.run_for(ms(30));
    let of_slave = |sent: &&Sent| sent.node == Some(MINIMAL) && sent.id() != Some(0x705);
    let frames = world.frames(Bus::Nominal).iter().map(|sent| Sent::clone(sent));
    frames.filter(|sent| sent.end > from && of_slave(&sent)).collect()
}

/// Given SDO requests, emergencies, time stamps and a fifth PDO, then the shipped device answers none, and continues as
/// before. It has no SDO, so its dictionary needs no SDO parameters.
///
/// Verifies: ECSS 9.4.10c, 9.4.10f, 9.4.7.1a, 9.4.7.2a, 9.4.8a
/// Notices: ECSS 9.4.10f: the slave answers SDO requests with an abort, without 1200h.
#[test]
fn shipped_device_has_no_service_of_a_forbidden_object() {
    let mut world = alone(1_000);
    let frames: [(u16, &[u8]); 7] = [
        (0x605, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]),
        (0x605, &[0x40, 0x00, 0x12, 1, 0, 0, 0, 0]),
        (0x605, &[0x80, 0x00, 0x12, 1, 0, 0, 0, 0]),
        (0x585, &[0x43, 0x00, 0x10, 0, 0, 0, 0, 0]),
        (0x085, &[0x00, 0x10, 1, 0, 0, 0, 0, 0]),
        (0x100, &[0; 6]),
        (0x6C5, &[1, 2]),
    ];
    for (id, data) in frames {
        assert!(asked(&mut world, id, data).is_empty(), "{id:03X}h");
    }
    assert_eq!(asked(&mut world, 0x505, &[]).len(), 1);
    for index in [0x1200, 0x1280] {
        assert!(entry::<MinimalObjects>(index, 0).is_none(), "{index:04X}h");
    }
}

/// Given known and unknown commands to the shipped device, each delivered twice, as CAN may do, then none is answered,
/// and each value is set once.
///
/// Verifies: ECSS 9.4.1c, 9.4.3b, 9.4.2a, 9.4.2b
/// Notices: ECSS 9.4.1c: a repeated command is echoed by TPDO 3.
/// Notices: ECSS 9.4.2b: after a repeat the request for the number of commands brings the value.
/// Notices: ECSS 9.4.3b: a repeated command brings telemetry.
#[test]
fn shipped_device_answers_no_command() {
    let mut world = alone(1_000);
    // Bytes to be kept, no bytes, LED on, value 7, an unknown code, a bus. The last byte is the sequence.
    let commands: [(u16, &[u8]); 6] = [
        (0x205, &[1, 2, 3]),
        (0x205, &[]),
        (0x305, &[1, 0, 1, 0, 0, 0, 0, 1]),
        (0x405, &[2, 0, 7, 0, 0, 0, 0, 2]),
        (0x305, &[0x77, 0, 0, 0, 0, 0, 0, 3]),
        (0x305, &[4, 0, 1, 0, 0, 0, 0, 4]),
    ];
    for (id, data) in commands {
        for _ in 0..2 {
            assert!(asked(&mut world, id, data).is_empty(), "{id:03X}h {data:?}");
        }
    }
    let executed = asked(&mut world, 0x405, &[3, 1]);
    assert_eq!(executed.len(), 1);
    assert_eq!(executed[0].frame.payload()[..6], [3, 1, 2, 0, 0, 0], "two commands");
}

/// Given the shipped device with a value set by the second of two commands, when RPDO 2 or 3 requests telemetry, then
/// TPDO 3 has the register that the request names. The six bytes after the code are optional.
///
/// Verifies: ECSS 9.4.2b, 9.4.3a, 9.4.3b.1
/// Notices: ECSS 9.4.3a: a request by RPDO 2 brings no telemetry.
/// Notices: ECSS 9.4.2b: the request for the value brings the number of commands.
#[test]
fn shipped_device_returns_the_register_that_a_request_names() {
    let mut world = alone(1_000);
    for command in [[1, 0, 1, 0, 0, 0, 0, 1], [2, 0, 7, 0x0C, 0x0B, 0x0A, 0, 2]] {
        assert!(asked(&mut world, 0x305, &command).is_empty());
    }
    // Codes 0102h and 0103h: value, and commands executed and dropped as repeats.
    for (code, data) in [(2, [7, 0x0C, 0x0B, 0x0A, 0, 0]), (3, [2, 0, 0, 0, 0, 0])] {
        for request in [&[code, 1][..], &[code, 1, 0, 0, 0, 0, 0, 0]] {
            for id in [0x305, 0x405] {
                let telemetry = asked(&mut world, id, request);
                let [sent] = &telemetry[..] else { panic!("one answer to {id:03X}h {request:?}") };
                assert_eq!(
                    (sent.id(), sent.frame.payload()),
                    (Some(0x385), &[&[code, 1][..], &data].concat()[..])
                );
            }
        }
    }
    // Code 0101h: milliseconds since power-on.
    let before = world.now().as_us() / 1_000;
    let telemetry = asked(&mut world, 0x405, &[1, 1]);
    let [1, 1, a, b, 0, 0, 0, 0] = telemetry[0].frame.payload()[..] else { panic!("less than 65 s") };
    let uptime = u64::from(u16::from_le_bytes([a, b]));
    assert!((before..before + 2).contains(&uptime), "{uptime} ms, {before} ms before");
}

/// Given the shipped device, when a command by RPDO 1 has three, eight or no bytes, then it keeps these, and a request reads
/// all of them.
///
/// Verifies: ECSS 9.4.2a, 9.4.3a
/// Notices: ECSS 9.4.1a: a command without bytes is not executed.
/// Notices: ECSS 9.4.2a: the shipped device keeps seven bytes of a command at most.
#[test]
fn shipped_device_executes_a_command_without_bytes() {
    let mut world = alone(1_000);
    for kept in [&[1, 2, 3][..], &[1, 2, 3, 4, 5, 6, 7, 8], &[]] {
        assert!(asked(&mut world, 0x205, kept).is_empty());
        let telemetry = asked(&mut world, 0x505, &[]);
        let [sent] = &telemetry[..] else { panic!("one answer") };
        assert_eq!((sent.id(), sent.frame.payload()), (Some(0x485), kept));
    }
}

/// Given the shipped device with its LED off and on, when a SYNC comes, then TPDO 2 has the objects that its mapping names, in their
/// order: commands executed (four bytes), state of the LED.
///
/// Verifies: ECSS 9.4.5a, 9.4.3b.2
/// Notices: ECSS 9.4.5a: telemetry of SYNC has another order while the LED is on.
#[test]
fn telemetry_of_sync_has_its_mapping_in_each_state_of_the_device() {
    let mut world = alone(1_000);
    for (executed, led) in [(0, 0), (1, 1), (2, 0)] {
        if executed > 0 {
            assert!(asked(&mut world, 0x305, &[1, 0, led, 0, 0, 0, 0, executed]).is_empty());
        }
        let telemetry = asked(&mut world, 0x080, &[]);
        let [sent] = &telemetry[..] else { panic!("one PDO") };
        assert_eq!((sent.id(), sent.frame.payload()), (Some(0x285), &[executed, 0, 0, 0, led][..]));
    }
}

/// Given the devices of the shipped images 5,000 s after power-on, when the uptime is requested, then telemetry has 5,000,000 ms. Their
/// clock counts more than 2^32 us.
///
/// Verifies: ECSS 9.4.3a, 9.4.2b
/// Notices: ECSS 9.4.3a: the uptime begins with zero again after 4,295 s.
#[test]
fn uptime_of_shipped_devices_does_not_wrap_after_71_minutes() {
    let at = Instant::from_micros(5_000_000_000);
    let expected = Payload::from_slice(&[1, 1, 0x40, 0x4B, 0x4C, 0, 0, 0]).unwrap();
    let request = [1, 1];
    assert_eq!(MinimalMission::new().on_pdo(1, &request, at), Some((2, expected.clone())));
    assert_eq!(MinimalMission::new().on_pdo(2, &request, at), Some((2, expected.clone())));
    assert_eq!(PrototypeMission::new().on_pdo(2, &request, at), Some((2, expected)));
}

/// Returns the time from the end of a request to the end of its telemetry, microseconds: 200 in the slave, one frame on
/// its way and the telemetry, 135 bits each.
const fn stated_delay(kbit: u64) -> u64 {
    200 + 2 * 135 * 1_000 / kbit
}

/// Given a free bus of 1 Mbit/s, 125 or 50 kbit/s, or one where a foreign frame begins with the telemetry, when telemetry is requested,
/// then it ends within the delay that the page of the minimal set states.
///
/// Verifies: ECSS 9.4.4a
/// Notices: ECSS 9.4.4a: telemetry waits for the next heartbeat.
#[test]
fn telemetry_ends_within_the_stated_delay() {
    let page = include_str!("../../../../docs/decisions/minimal-set.md");
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(page.contains(
        "200 µs and 270 bit times at most pass from the end of the request to the end of telemetry"
    ));
    assert!(page.contains("470 µs at 1 Mbit/s, 2.36 ms at 125 kbit/s"));
    assert_eq!((stated_delay(1_000), stated_delay(125)), (470, 2_360));
    for kbit in [1_000, 125, 50] {
        let mut world = alone(kbit);
        // Eight bytes to be kept.
        assert!(asked(&mut world, 0x205, &[0; 8]).is_empty());
        let requests: [(u16, &[u8]); 4] =
            [(0x505, &[]), (0x505, &[9; 8]), (0x405, &[2, 1]), (0x305, &[3, 1, 0, 0, 0, 0, 0, 0])];
        for (id, data) in requests {
            for has_neighbour in [false, true] {
                // Heartbeats begin at each 100 ms.
                let begin = world.now().as_us() / 100_000 * 100 + 150;
                world.run_until(ms(begin - 30));
                world.inject(Bus::Nominal, standard(0x701, &[0x05]));
                world.run_until(ms(begin));
                world.inject(Bus::Nominal, standard(id, data));
                if has_neighbour {
                    // It wins the arbitration against the telemetry.
                    world.inject(Bus::Nominal, standard(0x283, &[0x55; 8]));
                }
                world.run_for(ms(60));
                let [request] = &since(&world, Bus::Nominal, id, ms(begin))[..] else {
                    panic!("one request")
                };
                let reply = if id == 0x505 { 0x485 } else { 0x385 };
                let [reply] = &since(&world, Bus::Nominal, reply, ms(begin))[..] else { panic!("{id:03X}h") };
                let delay = reply.end.since(request.end).as_us();
                assert!(delay <= stated_delay(kbit.into()), "{kbit} kbit/s, {id:03X}h: {delay} us");
            }
        }
    }
}

/// Given two requests that follow each other on the bus, or a request that ends while the heartbeat of the slave is due, when telemetry
/// is requested, then each telemetry ends within the stated delay of its request.
///
/// Verifies: ECSS 9.4.4a
/// Notices: ECSS 9.4.4a: the second of two requests within a millisecond brings no telemetry.
#[test]
fn telemetry_of_requests_in_a_row_ends_within_the_delay() {
    for kbit in [1_000, 125, 50] {
        let mut world = alone(kbit);
        for (nth, requests) in
            [[(0x405, 0x385), (0x505, 0x485)], [(0x505, 0x485), (0x405, 0x385)]].iter().enumerate()
        {
            // The heartbeat is due every 100 ms. The request ends at that time, a frame later, or far from it.
            for early_us in
                [270_000 / u64::from(kbit), 135_000 / u64::from(kbit), 67_000 / u64::from(kbit), 0, 50_000]
            {
                let due = Time::from_ms(world.now().as_us() / 100_000 * 100 + 200);
                world.run_until(due - ms(80));
                world.inject(Bus::Nominal, standard(0x701, &[0x05]));
                let begin = due - Time::from_us(early_us);
                world.run_until(begin);
                for (id, _) in requests {
                    world.inject(Bus::Nominal, standard(*id, &[1, 1]));
                }
                world.run_until(due + ms(40));
                for (id, reply) in requests {
                    let [request] = &since(&world, Bus::Nominal, *id, begin)[..] else {
                        panic!("one request")
                    };
                    let [reply] = &since(&world, Bus::Nominal, *reply, begin)[..] else {
                        panic!("{id:03X}h")
                    };
                    let delay = reply.end.since(request.end).as_us();
                    assert!(
                        delay <= stated_delay(kbit.into()),
                        "{kbit} kbit/s, {nth}, {id:03X}h: {delay} us"
                    );
                }
            }
        }
    }
}

/// Given two equal requests that follow each other on the bus, with data or without, then each brings telemetry, the second within the
/// stated delay.
///
/// Verifies: ECSS 9.4.3b.1, 9.4.4a
/// Notices: ECSS 9.4.4a: the second of two equal requests within 100 ms brings no telemetry.
#[test]
fn equal_requests_in_a_row_bring_telemetry_each() {
    let cases: [(u16, &[u8], u16); 3] =
        [(0x505, &[], 0x485), (0x305, &[2, 1], 0x385), (0x405, &[2, 1], 0x385)];
    for (id, data, reply) in cases {
        let mut world = alone(1_000);
        let begin = world.now();
        world.inject(Bus::Nominal, standard(id, data));
        world.inject(Bus::Nominal, standard(id, data));
        world.run_for(ms(5));
        let ends = |id| -> Vec<Time> {
            since(&world, Bus::Nominal, id, begin).iter().map(|sent| sent.end).collect()
        };
        let (requests, replies) = (ends(id), ends(reply));
        assert_eq!((requests.len(), replies.len()), (2, 2), "{id:03X}h");
        let delay = replies[1].since(requests[1]).as_us();
        assert!(delay <= stated_delay(1_000), "{id:03X}h: {delay} us");
    }
}

/// Given the shipped master in profile `librecube`, which sends the spacecraft time every 10 s. Then no node sends the time stamp
/// object, and one from outside does not change the time that the master sends.
///
/// Verifies: ECSS 9.4.7.1b, 7.2.3f, 11.1c
#[test]
fn shipped_master_neither_takes_nor_sends_time_stamps() {
    let mut world = MissionWorld::mixed(LIBRECUBE, 2, |world| world);
    world.run_until(ms(20_500));
    world.inject(Bus::Nominal, standard(0x100, &[0, 0, 0, 0, 0x10, 0x27]));
    world.run_until(ms(41_000));
    let times = since(&world, Bus::Nominal, 0x181, Time::ZERO);
    assert!(times.len() >= 3, "{}", times.len());
    let seconds = |sent: &Sent| u32::from_le_bytes(sent.frame.payload()[3..].try_into().unwrap());
    assert!(times.windows(2).all(|pair| (9..=11).contains(&(seconds(&pair[1]) - seconds(&pair[0])))));
    for bus in Bus::ALL {
        let stamps = since(&world, bus, 0x100, Time::ZERO).into_iter();
        assert_eq!(stamps.filter(|sent| sent.node.is_some()).count(), 0);
    }
}

/// Given the devices of the shipped images, then they have the objects of the minimal set with the parameters of the tables. Two
/// exceptions: telemetry that SYNC brings has its number of SYNCs as type, and the prototype of LibreCube takes the time by RPDO 1.
///
/// Verifies: ECSS 9.3a, 9.4.2d, 9.4.2e, 9.4.4c, 9.4.4d
/// Notices: ECSS 9.3a: TPDO 4 of the minimal slave is not in use.
/// Notices: ECSS 9.4.2e: RPDOs have transmission type 255.
#[test]
fn objects_of_shipped_images_are_those_of_the_tables() {
    assert_minimal_set::<MinimalObjects>();
    assert_minimal_set::<PrototypeObjects>();
    let standard = MinimalObjects::new(MINIMAL, &SPACECRAFT);
    assert_eq!(of(standard.rpdos), [0x205, 0x305, 0x405, 0x505].map(|id| (Some(id), 254)));
    let sent = [(None, 254), (Some(0x285), 1), (Some(0x385), 254), (Some(0x485), 254)];
    assert_eq!(of(standard.tpdos), sent);
    assert_eq!(standard.consumer_heartbeat, [1 << 16 | 250], "the master, 250 ms");
    assert_eq!(standard.producer_heartbeat, 100);
    let six = NodeId::of::<6>();
    let prototype = PrototypeObjects::new(six, &LIBRECUBE);
    assert_eq!(of(prototype.rpdos), [0x181, 0x306, 0x406, 0x506].map(|id| (Some(id), 254)));
    let sent = [(Some(0x186), 1), (None, 254), (Some(0x386), 254), (Some(0x486), 254)];
    assert_eq!(of(prototype.tpdos), sent);
    assert_eq!((prototype.consumer_heartbeat, prototype.producer_heartbeat), ([1 << 16 | 2_500], 250));
}

/// Given the devices of the shipped images with the lowest, a high and the highest Node-ID, then their COB-IDs are those of Tables 9-4 and
/// 9-6, but for the time that the prototype takes by 181h. They are those of standard frames, and remote ones ask for no telemetry.
///
/// Verifies: ECSS 9.4.2d, 9.4.4c
/// Notices: ECSS 9.4.2d: COB-IDs of commands have the low six bits of the Node-ID.
/// Notices: ECSS 9.4.4c: COB-IDs of telemetry have the low six bits of the Node-ID.
/// Notices: ECSS 9.4.4c: COB-IDs of telemetry have bit 29, of extended frames, in place of bit 30.
#[test]
fn cob_ids_of_shipped_images_follow_every_node_id() {
    for raw in [2, 64, 126] {
        let id = NodeId::new(raw).expect("2 to 126");
        let ids = |bases: [u32; 4]| bases.map(|base| Some(base + u32::from(raw)));
        let cob_ids = |pdos| of(pdos).map(|(cob_id, _)| cob_id);
        let standard = MinimalObjects::new(id, &SPACECRAFT);
        assert_eq!(cob_ids(standard.rpdos), ids([0x200, 0x300, 0x400, 0x500]));
        assert_eq!(cob_ids(standard.tpdos)[1..], ids([0x180, 0x280, 0x380, 0x480])[1..]);
        let objects = PrototypeObjects::new(id, &LIBRECUBE);
        assert_eq!(cob_ids(objects.rpdos)[1..], ids([0x200, 0x300, 0x400, 0x500])[1..]);
        let sent = cob_ids(objects.tpdos);
        assert_eq!((sent[0], &sent[2..]), (ids([0x180; 4])[0], &ids([0, 0, 0x380, 0x480])[2..]));
        assert!(standard.tpdos.iter().chain(&objects.tpdos).all(|pdo| pdo.cob_id & NO_REMOTE != 0));
    }
}

/// Returns the entries of a mapping with the eight bytes of this object.
fn eight_bytes(index: u32) -> Vec<u32> {
    (1..=8).map(|sub| index << 16 | sub << 8 | 8).collect()
}

/// Returns the entries of a mapping with code (16 bits) and data (48 bits) of this object.
fn code_and_data(index: u32) -> Vec<u32> {
    vec![index << 16 | 0x0110, index << 16 | 0x0230]
}

/// Given the devices of the shipped images, then each PDO in use maps the objects that it carries, and the one that is not in use
/// maps none.
///
/// Verifies: ECSS 9.4.10e
/// Notices: ECSS 9.4.10e: telemetry by TPDO 4 of the prototype has no mapping.
#[test]
fn pdos_in_use_of_shipped_images_have_their_mappings() {
    let mapped =
        |mappings: &[StaticMapping; 4]| mappings.each_ref().map(|mapping| mapping.objects().to_vec());
    let standard = MinimalObjects::new(MINIMAL, &SPACECRAFT);
    let received = [eight_bytes(0x6200), code_and_data(0x6201), code_and_data(0x6202), eight_bytes(0x6203)];
    assert_eq!(mapped(&standard.rpdo_mappings), received);
    let sent = [vec![], vec![0x6001_0120, 0x6001_0208], code_and_data(0x6002), eight_bytes(0x6000)];
    assert_eq!(mapped(&standard.tpdo_mappings), sent);

    let six = NodeId::of::<6>();
    let prototype = PrototypeObjects::new(six, &LIBRECUBE);
    let time = |index: u32| vec![index << 16 | 0x0218, index << 16 | 0x0120];
    let received = [time(0x2010), code_and_data(0x6200), code_and_data(0x6201), eight_bytes(0x6203)];
    assert_eq!(mapped(&prototype.rpdo_mappings), received);
    let sent = [time(0x2011), vec![], code_and_data(0x6100), eight_bytes(0x6000)];
    assert_eq!(mapped(&prototype.tpdo_mappings), sent);
}

/// Given the minimal slave of profile `librecube`, then its RPDO 1 has Local SCET Set and its TPDO 1 Local SCET Get, in the order of
/// Figure 7-1: fine time, coarse time.
///
/// Verifies: ECSS 7.2.2c, 7.2.2e, 7.2.3g, 7.2.3h, 7.1.2f
/// Notices: ECSS 7.2.2e: a minimal slave maps Local SCET Set to its Local Time PDO.
/// Notices: ECSS 7.2.3h: the Local Time PDO of a minimal slave has no Local SCET Get.
#[test]
fn prototype_maps_its_time_as_figure_7_1_has_it() {
    let six = NodeId::of::<6>();
    let prototype = PrototypeObjects::new(six, &LIBRECUBE);
    let [spacecraft_time, ..] = &prototype.rpdo_mappings;
    assert_eq!(spacecraft_time.objects(), [0x2010_0218, 0x2010_0120]);
    let [local_time, ..] = &prototype.tpdo_mappings;
    assert_eq!(local_time.objects(), [0x2011_0218, 0x2011_0120]);
}

/// Given the images of a mission with minimal slaves, then 1005h of these is 80h and read-only, and they have neither 1006h nor 1007h.
/// The master serves full slaves too: there 1005h and 1006h are `rw`, as CiA 301 has them, and hold what it sends.
///
/// Verifies: ECSS 9.4.7.3a, 9.4.7.3b.1, 9.4.7.3b.2, 9.4.7.3d, 9.4.7.3b
/// Notices: ECSS 9.4.7.3a: 1005h of a minimal slave is 81h.
/// Notices: ECSS 9.4.7.3a: 1005h of the prototype is that of a master, 8000 0080h.
/// Notices: ECSS 9.4.7.3b.2: 1006h has milliseconds.
#[test]
fn sync_objects_of_shipped_images_have_their_access() {
    fn assert_consumer<D: Objects>(cob_id: u32) {
        let entry_of_cob_id = entry::<D>(0x1005, 0).map(|entry| (entry.access, entry.data_type));
        assert_eq!(entry_of_cob_id, Some((Access::Ro, DataType::Unsigned32)));
        assert_eq!(cob_id, 0x80);
        assert!(entry::<D>(0x1006, 0).is_none() && entry::<D>(0x1007, 0).is_none());
    }
    assert_consumer::<MinimalObjects>(MinimalObjects::new(MINIMAL, &SPACECRAFT).cob_id_sync);
    assert_consumer::<PrototypeObjects>(PrototypeObjects::new(MINIMAL, &SPACECRAFT).cob_id_sync);

    fn declared<D: Objects>(_: &D, index: u16) -> Option<(Access, DataType)> {
        entry::<D>(index, 0).map(|entry| (entry.access, entry.data_type))
    }
    for (profile, period_ms) in [(SPACECRAFT, 100), (LIBRECUBE, 5_000)] {
        let mut world = MissionWorld::mixed(profile, 2, |world| world);
        world.run_until(ms(1_000));
        let (cob_id, period, window) = world.master(|master| {
            let objects = master.objects();
            let expected = Some((Access::Rw, DataType::Unsigned32));
            assert_eq!([0x1005, 0x1006].map(|index| declared(objects, index)), [expected; 2]);
            let sync = &objects.communication.sync;
            (sync.cob_id, sync.cycle_period, sync.window)
        });
        assert_eq!((cob_id, period, window), (0x4000_0080, period_ms * 1_000, 0));
        world.run_until(ms(u64::from(2_000 + 3 * period_ms)));
        let periods = periods_us(&since(&world, Bus::Nominal, 0x080, ms(1_000)));
        let expected = u64::from(period_ms) * 1_000;
        assert!(periods.len() >= 2 && periods.iter().all(|us| us.abs_diff(expected) < 2_000), "{periods:?}");
    }
}

/// Returns the COB-ID of the minimal slave's reply: 285h to SYNC, telemetry to a known request by 405h (uptime, value,
/// commands executed), and the kept bytes to a request by 505h.
fn reply_to(id: u16, data: &[u8]) -> Option<u16> {
    match (id, data) {
        (0x080, _) => Some(0x285),
        (0x405, [1..=3, 1, ..]) => Some(0x385),
        (0x505, _) => Some(0x485),
        _ => None,
    }
}

/// Given a network with commands, telemetry, heartbeats and SDO transfers of others, commands to the minimal slave by
/// RPDO 1 and 2 and requests by RPDO 3 and 4, then each frame of the minimal slave except its heartbeat answers one
/// SYNC or request, once and without delay.
///
/// Verifies: ECSS 9.4.3b, 9.4.3c, 9.4.1b, 9.4.6.1a
/// Notices: ECSS 9.4.3c: each telemetry is sent twice.
#[test]
fn a_minimal_slave_in_a_busy_network_sends_what_is_asked() {
    let mut world = MissionWorld::mixed(SPACECRAFT, 2, |world| world.seed(11));
    world.run_until(ms(1_000));
    let from = world.now();
    let transfer = world.on_master(|master| async move {
        for round in 0..20_u8 {
            master.sdo(TWO).write_bytes(MissionObjects::STORE, &[round; 900]).await?;
            let mut name = [0; 64];
            master.sdo(THREE).read_bytes(Field::raw(Address::new(0x1008, 0)), &mut name).await?;
        }
        Ok::<_, Error>(())
    });
    for round in 0..40_u8 {
        for (number, data) in [(0, &[round, 1, 2][..]), (2, &[0x02, 0x01]), (3, &[])] {
            send(&world, number, data).expect("it is operational");
            world.run_for(ms(25));
        }
        // Requests and commands of its neighbours, by Node-ID.
        for id in [0x204, 0x206, 0x404, 0x406, 0x504, 0x506] {
            world.inject(Bus::Nominal, standard(id, &[round]));
        }
    }
    assert_eq!(transfer.take().expect("the transfers ended").1, Ok(()));
    let frames = world.frames(Bus::Nominal).iter().filter(|sent| sent.start > from);
    let mut owed: Vec<(u16, Time)> = vec![];
    let (mut replies, mut heartbeats) = (0, 0);
    for sent in frames {
        let id = sent.id().expect("11 bits");
        if sent.node != Some(MINIMAL) {
            owed.extend(reply_to(id, sent.frame.payload()).map(|reply| (reply, sent.end)));
        } else if id == 0x705 {
            heartbeats += 1;
        } else {
            let place = owed.iter().position(|(reply, _)| *reply == id);
            let (_, asked) =
                owed.remove(place.unwrap_or_else(|| panic!("{id:03X}h at {} us", sent.start.as_us())));
            assert!(sent.end.since(asked) < ms(2), "{id:03X}h after {} us", sent.end.since(asked).as_us());
            replies += 1;
        }
    }
    assert!(replies >= 110 && (29..=31).contains(&heartbeats), "{replies}, {heartbeats}");
    assert!(owed.len() <= 1, "answered, but for what is asked at the end: {owed:03X?}");
    assert!(world.frames(Bus::Redundant).is_empty());
}

fn send(world: &MissionWorld, number: usize, data: &[u8]) -> Result<(), Refusal> {
    let master = world.node::<MissionMaster>(MASTER);
    master.with(|master, now| master.send_to_minimal(MINIMAL, number, data, now))
}

/// Returns the frames of `sender` with this identifier that ended after `from`, on both buses.
fn on_both(world: &MissionWorld, sender: NodeId, id: u16, from: Time) -> Vec<(Bus, Sent)> {
    let of = |bus| since(world, bus, id, from).into_iter().map(move |sent| (bus, sent));
    Bus::ALL.into_iter().flat_map(of).filter(|(_, sent)| sent.node == Some(sender)).collect()
}

/// A PDO to the minimal slave: its number from zero, its identifier and data, and the reply: its identifier and first bytes.
type Case<'a> = (usize, u16, &'a [u8], Option<(u16, &'a [u8])>);

/// Given the shipped master on either bus of a busy network, then each of the four PDOs carries a command or a request
/// to the minimal slave, on the active bus only, and brings the requested telemetry.
///
/// Verifies: ECSS 9.4.2c, 9.4.3b.1, 9.4.1c, 9.4.3a
/// Notices: ECSS 9.4.3b.1: a request without data bytes is not answered.
#[test]
fn shipped_master_commands_and_asks_by_each_of_four_pdos() {
    let mut world = MissionWorld::mixed(SPACECRAFT, 2, |world| world);
    world.run_until(ms(1_000));
    for bus in [Bus::Nominal, Bus::Redundant, Bus::Nominal] {
        if world.master_bus() != bus {
            world.request(MasterRequest::SwitchBus(bus));
            world.run_for(ms(1_000));
        }
        assert_eq!(world.master_bus(), bus);
        let kept = [bus as u8, 0xA5, 0x5A];
        // Codes 0103h and 0102h ask for commands executed and for the value.
        let cases: [Case<'_>; 5] = [
            (0, 0x205, &kept, None),
            (3, 0x505, &[], Some((0x485, &kept))),
            (3, 0x505, &[9; 8], Some((0x485, &kept))),
            (1, 0x305, &[0x03, 0x01], Some((0x385, &[0x03, 0x01]))),
            (2, 0x405, &[0x02, 0x01], Some((0x385, &[0x02, 0x01]))),
        ];
        for (number, id, data, reply) in cases {
            // The traffic of the mission has a period of 100 ms.
            let begin = world.now() - ms(world.now().as_us() / 1_000 % 100) + ms(140);
            world.run_until(begin);
            send(&world, number, data).expect("it is operational");
            world.run_for(ms(5));
            let sent = on_both(&world, MASTER, id, begin);
            let found: Vec<_> = sent.iter().map(|(bus, sent)| (*bus, sent.frame.payload())).collect();
            assert_eq!(found, [(bus, data)], "RPDO {}", number + 1);
            let ids = [0x385, 0x485].into_iter();
            let replies: Vec<_> = ids.flat_map(|id| on_both(&world, MINIMAL, id, begin)).collect();
            let Some((reply, content)) = reply else {
                assert!(replies.is_empty(), "a command is not answered");
                continue;
            };
            let [(on, answer)] = &replies[..] else { panic!("RPDO {}: {replies:?}", number + 1) };
            assert_eq!((*on, answer.id()), (bus, Some(reply)));
            assert_eq!(&answer.frame.payload()[..content.len()], content);
        }
    }
}
