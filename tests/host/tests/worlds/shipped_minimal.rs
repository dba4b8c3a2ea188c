//! Minimal slaves with the profiles and devices that images use, in a busy network (ECSS 9).

use can_wire::time::Time;
use ecss_can::node::minimal::Numbers;
use ecss_can::node::{MasterRequest, Refusal};
use ecss_can::od::{Access, Entry, Objects};
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::sdo::Error;
use ecss_can::types::{Address, Bus, NodeId};
use host_worlds::world::Sent;
use mission::minimal::prototype::PrototypeObjects;
use mission::minimal::{FixedPdo, MinimalObjects};
use mission::{LIBRECUBE, STANDARD};

use crate::mission_world::MissionMaster;
use crate::support::*;

const MINIMAL: NodeId = NodeId::of::<5>();

/// The mission with two full slaves, and a minimal one behind them.
const SPACECRAFT: Profile =
    Profile { minimal: &[MinimalNode { node: MINIMAL, has_heartbeat: true }], ..STANDARD };

/// Bit 31 of a COB-ID: the PDO is not in use.
const NOT_IN_USE: u32 = 1 << 31;

fn entry<D: Objects>(index: u16, sub: u8) -> Option<&'static Entry> {
    D::DECLARED.find(Address::new(index, sub)).map(|(_, _, entry)| entry)
}

/// Asserts the structure of Tables 9-3 to 9-6: sub-indices 0 to 2 that no client writes, and nothing else.
fn assert_fixed<D: Objects>(index: u16) {
    for sub in 0..=2 {
        let access = entry::<D>(index, sub).expect("number, COB-ID and type").access;
        assert!(!access.is_writable(), "{index:04X}h sub {sub}");
    }
    assert!((3..=6).all(|sub| entry::<D>(index, sub).is_none()), "{index:04X}h: inhibit time or event time");
}

/// CAN-ID, `None` where the PDO is not in use, and transmission type.
fn of(pdos: [FixedPdo; 4]) -> [(Option<u32>, u8); 4] {
    pdos.map(|pdo| ((pdo.cob_id & NOT_IN_USE == 0).then_some(pdo.cob_id & 0x7FF), pdo.transmission))
}

/// The objects of Tables 9-1 and 9-2, without 1006h, which producers of SYNC have, and 1007h, which Table 9-12 forbids.
fn assert_minimal_set<D: Objects>() {
    for pdo in 0..4 {
        assert_fixed::<D>(0x1400 + pdo);
        assert_fixed::<D>(0x1800 + pdo);
    }
    for (index, sub) in [(0x1016, 1), (0x1017, 0), (0x1005, 0)] {
        assert!(entry::<D>(index, sub).is_some(), "{index:04X}h");
    }
    // The time stamp object, and the synchronous window.
    for index in [0x1012, 0x1013, 0x1007] {
        assert!(entry::<D>(index, 0).is_none(), "{index:04X}h");
    }
}

/// Given the devices of the shipped images, then they have the objects of the minimal set with the parameters of the tables. Two
/// exceptions: telemetry that SYNC brings has its number of SYNCs as type, and the prototype of LibreCube takes the time by RPDO 1.
///
/// Verifies: ECSS 9.3a, 9.4.2d, 9.4.2e, 9.4.4c, 9.4.4d
#[test]
fn objects_of_shipped_images_are_those_of_the_tables() {
    assert_minimal_set::<MinimalObjects>();
    assert_minimal_set::<PrototypeObjects>();
    let standard = MinimalObjects::new(MINIMAL, &Numbers::of(&SPACECRAFT, MINIMAL));
    assert_eq!(of(standard.rpdos), [0x205, 0x305, 0x405, 0x505].map(|id| (Some(id), 254)));
    let sent = [(None, 254), (Some(0x285), 1), (Some(0x385), 254), (Some(0x485), 254)];
    assert_eq!(of(standard.tpdos), sent);
    assert_eq!(standard.consumer_heartbeat, [1 << 16 | 250], "the master, 250 ms");
    assert_eq!(standard.producer_heartbeat, 100);
    let six = NodeId::of::<6>();
    let prototype = PrototypeObjects::new(six, &Numbers::of(&LIBRECUBE, six));
    assert_eq!(of(prototype.rpdos), [0x181, 0x306, 0x406, 0x506].map(|id| (Some(id), 254)));
    let sent = [(Some(0x186), 1), (None, 254), (Some(0x386), 254), (Some(0x486), 254)];
    assert_eq!(of(prototype.tpdos), sent);
    assert_eq!((prototype.consumer_heartbeat, prototype.producer_heartbeat), ([1 << 16 | 2_500], 250));
}

/// Given the images of a mission with minimal slaves, then 1005h of these is 80h and read-only, and they have neither 1006h nor 1007h.
/// The master serves full slaves too: there 1005h and 1006h are `rw`, as CiA 301 has them, and hold what it sends.
///
/// Verifies: ECSS 9.4.7.3a, 9.4.7.3b.1, 9.4.7.3b.2, 9.4.7.3d
#[test]
fn sync_objects_of_shipped_images_have_their_access() {
    fn assert_consumer<D: Objects>(cob_id: u32) {
        assert_eq!(entry::<D>(0x1005, 0).map(|entry| entry.access), Some(Access::Ro));
        assert_eq!(cob_id, 0x80);
        assert!(entry::<D>(0x1006, 0).is_none() && entry::<D>(0x1007, 0).is_none());
    }
    assert_consumer::<MinimalObjects>(MinimalObjects::default().cob_id_sync);
    assert_consumer::<PrototypeObjects>(PrototypeObjects::default().cob_id_sync);

    fn access<D: Objects>(_: &D, index: u16) -> Option<Access> {
        entry::<D>(index, 0).map(|entry| entry.access)
    }
    for (profile, period_ms) in [(SPACECRAFT, 100), (LIBRECUBE, 5_000)] {
        let mut world = MissionWorld::mixed(profile, 2, |world| world);
        world.run_until(ms(1_000));
        let (cob_id, period, window) = world.master(|master| {
            let objects = master.objects();
            assert_eq!([0x1005, 0x1006].map(|index| access(objects, index)), [Some(Access::Rw); 2]);
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

/// What the minimal slave sends: with SYNC 285h, telemetry on a request by 405h that it knows (uptime, value, commands executed), on
/// one by 505h the bytes that it keeps.
fn reply_to(id: u16, data: &[u8]) -> Option<u16> {
    match (id, data) {
        (0x080, _) => Some(0x285),
        (0x405, [1..=3, 1, ..]) => Some(0x385),
        (0x505, _) => Some(0x485),
        _ => None,
    }
}

/// Given a network with commands, telemetry, heartbeats and SDO transfers of others, commands to the minimal slave by RPDO 1 and 2 and
/// requests by RPDO 3 and 4, then each frame of the minimal slave but its heartbeat answers one SYNC or request, once and at once.
///
/// Verifies: ECSS 9.4.3b, 9.4.3c
#[test]
fn a_minimal_slave_in_a_busy_network_sends_what_is_asked() {
    let mut world = MissionWorld::mixed(SPACECRAFT, 2, |world| world.seed(11));
    world.run_until(ms(1_000));
    let from = world.now();
    let transfer = world.on_master(|master| async move {
        let client = master.sdo();
        for round in 0..20_u8 {
            client.write(TWO, Address::new(0x6300, 0), &[round; 900]).await?;
            let mut name = [0; 64];
            client.read(THREE, Address::new(0x1008, 0), &mut name).await?;
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

/// Frames of `sender` with this identifier that ended after `from`, on both buses.
fn on_both(world: &MissionWorld, sender: NodeId, id: u16, from: Time) -> Vec<(Bus, Sent)> {
    let of = |bus| since(world, bus, id, from).into_iter().map(move |sent| (bus, sent));
    Bus::ALL.into_iter().flat_map(of).filter(|(_, sent)| sent.node == Some(sender)).collect()
}

/// A PDO to the minimal slave: its number from zero, its identifier and data, and the reply: its identifier and first bytes.
type Case<'a> = (usize, u16, &'a [u8], Option<(u16, &'a [u8])>);

/// Given the shipped master on either bus of a busy network, then each of the four PDOs takes a command or a request to the minimal
/// slave, on the active bus alone, and brings what it asks for.
///
/// Verifies: ECSS 9.4.1a, 9.4.2c
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
