//! Flips every bit of every parameter, in the objects and in the services.

extern crate std;

use std::format;
use std::string::String;

use super::super::tests::{NOW, compare, services, write};
use crate::node::index::{
    CONSUMER_HEARTBEAT, CYCLE_PERIOD, EMCY_INHIBIT, ERROR_BEHAVIOUR, PRODUCER_HEARTBEAT, RPDO, RPDO_MAPPING,
    SYNC_OVERFLOW, SYNC_WINDOW, TPDO,
};
use crate::node::probe::{Guard, Probe};
use crate::node::services::Services;
use crate::node::services::objects::NodeObjects;
use crate::node::turn::Turn;
use crate::node::{Event, Outbox};
use crate::pdo::{Direction, Layout, PdoParameters};
use crate::types::{Address, CobId, Duration, NmtState, NodeId};

type Objects = NodeObjects<Probe, Guard>;

/// Inverts a bit of a parameter of the objects.
type Flip = fn(&mut Objects, u32);

/// Name of a parameter, its bits, and how one of them flips.
const PARAMETERS: [(&str, u32, Flip); 17] = [
    ("1006h", 32, |objects, bit| objects.communication.sync.cycle_period ^= 1 << bit),
    ("1007h", 32, |objects, bit| objects.communication.sync.window ^= 1 << bit),
    ("1019h", 8, |objects, bit| objects.communication.sync.overflow ^= 1 << bit),
    ("1015h", 16, |objects, bit| objects.communication.emcy.inhibit ^= 1 << bit),
    ("1017h", 16, |objects, bit| objects.communication.heartbeat.time ^= 1 << bit),
    ("1029h", 8, |objects, bit| objects.communication.nmt.error_behaviour[0] ^= 1 << bit),
    ("1F80h", 32, |objects, bit| objects.communication.nmt.startup ^= 1 << bit),
    ("1016h", 8 * 32, |objects, bit| {
        objects.consumers.consumer_heartbeat[bit as usize / 32] ^= 1 << (bit % 32);
    }),
    ("1401h sub 2", 8, |objects, bit| objects.pdos.rpdos[1].transmission ^= 1 << bit),
    ("1400h sub 5", 16, |objects, bit| objects.pdos.rpdos[0].event_timer ^= 1 << bit),
    ("1600h sub 0", 8, |objects, bit| objects.pdos.rpdo_mappings[0].count ^= 1 << bit),
    ("1600h", 8 * 32, |objects, bit| {
        objects.pdos.rpdo_mappings[0].objects[bit as usize / 32] ^= 1 << (bit % 32);
    }),
    ("1800h sub 2", 8, |objects, bit| objects.pdos.tpdos[0].transmission ^= 1 << bit),
    ("1800h sub 3", 16, |objects, bit| objects.pdos.tpdos[0].inhibit ^= 1 << bit),
    ("1801h sub 5", 16, |objects, bit| objects.pdos.tpdos[1].event_timer ^= 1 << bit),
    ("1800h sub 6", 8, |objects, bit| objects.pdos.tpdos[0].sync_start ^= 1 << bit),
    ("1A00h", 8 * 32, |objects, bit| {
        objects.pdos.tpdo_mappings[0].objects[bit as usize / 32] ^= 1 << (bit % 32);
    }),
];

/// Given a node, when any bit of a parameter in its objects flips, then it is right again after each COB-ID was compared once, and
/// it is counted once.
#[test]
fn every_flipped_bit_of_a_parameter_is_corrected() {
    for (name, bits, flip) in PARAMETERS {
        for bit in 0..bits {
            let mut services = services();
            let before = services.objects().parameters();
            flip(services.objects_mut(), bit);
            assert_ne!(services.objects().parameters(), before, "{name}, bit {bit}");
            assert_eq!(compare(&mut services), 1, "{name}, bit {bit}");
            assert_eq!(services.objects().parameters(), before, "{name}, bit {bit}");
        }
    }
}

impl Objects {
    /// All that clients write.
    fn parameters(&self) -> impl PartialEq + core::fmt::Debug + use<> {
        let all = &self.communication;
        let communication = (all.sync.clone(), all.nmt.clone(), all.emcy.inhibit, all.heartbeat.time);
        (communication, self.consumers.clone(), self.pdos.clone())
    }
}

/// Given a client that writes a parameter, then it is kept: no bit of it counts as flipped.
#[test]
fn a_written_parameter_is_no_flipped_bit() {
    let mut services = services();
    let written: [(u16, u8, usize, u32); 12] = [
        (SYNC_OVERFLOW, 0, 1, 16),
        (CYCLE_PERIOD, 0, 4, 1 << 17),
        (SYNC_WINDOW, 0, 4, 1 << 12),
        (EMCY_INHIBIT, 0, 2, 1 << 5),
        (PRODUCER_HEARTBEAT, 0, 2, 1 << 8),
        (ERROR_BEHAVIOUR, 1, 1, 1),
        (CONSUMER_HEARTBEAT, 8, 4, 0x0007_0100),
        (RPDO, 2, 1, 1),
        (RPDO, 5, 2, 1 << 9),
        (RPDO + 1, 2, 1, 255),
        (RPDO_MAPPING + 1, 1, 4, 0x6000_0008),
        (TPDO + 1, 3, 2, 1 << 4),
    ];
    for (index, sub, len, value) in written {
        let (at, mut out) = (Address::new(index, sub), Outbox::<Event>::new());
        services.write(at, &value.to_le_bytes()[..len], NOW).unwrap();
        services.on_own_written(at, &mut Turn::new(NOW, &mut out));
        let before = services.objects().parameters();
        assert_eq!(compare(&mut services), 0, "{at:?}");
        assert_eq!(services.objects().parameters(), before, "{at:?}");
    }
    let objects = services.objects();
    assert_eq!((objects.communication.sync.window, objects.pdos.tpdos[1].inhibit), (1 << 12, 1 << 4));
}

/// What services have in use, as text: each field counts.
fn in_use(services: &Services<Probe, Guard>) -> String {
    let dictionary = &services.dictionary;
    format!("{:?} {:?} {:?}", services.sync, dictionary.rpdos(), dictionary.tpdos())
}

/// Given a node, when any bit of the parameters that the consumer of SYNC has in use flips, then it has those of the objects
/// again.
#[test]
fn a_flipped_bit_of_the_window_in_use_is_corrected() {
    for bit in 0..32 {
        let mut services = services();
        let before = in_use(&services);
        services.sync.configure(0, 1 << bit);
        assert_eq!((compare(&mut services), in_use(&services)), (0, before), "bit {bit}");
    }
}

/// Given a node that monitors node 3, when any bit of the entry in use flips, then it monitors node 3 again with the consumer time
/// of 1016h.
#[test]
fn a_flipped_bit_of_a_consumer_time_in_use_is_corrected() {
    const ENTRY: u32 = 3 << 16 | 250;
    for bit in 0..23 {
        let mut services = services();
        write(&mut services, Address::new(CONSUMER_HEARTBEAT, 1), ENTRY);
        services.monitor.no_sooner().set(1, ENTRY ^ 1 << bit);
        assert_eq!(compare(&mut services), 0, "bit {bit}");
        let (node, at) = (NodeId::of::<3>(), NOW);
        assert!(services.on_peer_heartbeat(node, NmtState::Operational, at).is_some(), "bit {bit}");
        let (early, late) = (Duration::from_micros(249_999), Duration::from_millis(250));
        assert_eq!((services.poll_monitor(at + early), services.poll_monitor(at + late)), (None, Some(node)));
    }
}

/// Given a node with valid PDOs, when any bit of the parameters that they have in use flips, then they have those of the objects
/// again.
#[test]
fn a_flipped_bit_of_a_pdo_in_use_is_corrected() {
    let layout = |objects: &[u32]| Layout::new::<Objects>(Direction::Receive, objects).unwrap();
    let (right, empty) = (layout(&[0x6000_0008]), layout(&[]));
    // Bits of the event timer, the transmission type, the inhibit time and the SYNC start value, and another mapping.
    for bit in 0..49 {
        let flip = |pdo: &mut PdoParameters| match bit {
            0..16 => pdo.event_timer ^= 1 << bit,
            16..24 => pdo.transmission ^= 1 << (bit - 16),
            24..40 => pdo.inhibit ^= 1 << (bit - 24),
            40..48 => pdo.sync_start ^= 1 << (bit - 40),
            _ => {}
        };
        let layout = if bit == 48 { empty } else { right };
        let (mut services, pdos) = (services(), services().objects().pdos.clone());
        let before = in_use(&services);
        let mut parameters = pdos.tpdos[0];
        flip(&mut parameters);
        let resolved = Some((CobId::new(0x185).unwrap(), layout));
        services.dictionary.tpdos_mut().configure(0, &parameters, resolved, NOW).unwrap();
        assert_eq!((compare(&mut services), in_use(&services)), (0, before.clone()), "TPDO, bit {bit}");

        let mut parameters = *pdos.rpdos[0];
        flip(&mut parameters);
        let resolved = Some((CobId::new(0x205).unwrap(), layout));
        services.dictionary.rpdos_mut().configure(0, &parameters, resolved, false).unwrap();
        assert_eq!((compare(&mut services), in_use(&services)), (0, before), "RPDO, bit {bit}");
    }
}

/// Given two flipped bits of one parameter, then they are reported, and nothing is corrected to a third value.
#[test]
fn two_flipped_bits_of_a_parameter_are_reported() {
    let mut services = services();
    services.objects_mut().communication.sync.window ^= 0b11;
    assert_eq!(compare(&mut services), 1);
    assert_eq!(services.objects().communication.sync.window, 0b11);
    assert_eq!(compare(&mut services), 0);
}
