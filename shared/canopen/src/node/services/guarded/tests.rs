//! Flips every bit of every copy.

extern crate std;

use std::vec;
use std::vec::Vec;

use crate::emcy::Config;
use crate::node::index::{EMCY_COB_ID, RPDO, SYNC_COB_ID, TPDO};
use crate::node::probe::{Guard, Probe};
use crate::node::services::Services;
use crate::node::services::objects::NodeObjects;
use crate::node::turn::Turn;
use crate::node::{Event, Outbox, Settings};
use crate::od::copies::Copied;
use crate::od::{INVALID, NO_REMOTE};
use crate::pdo::{Direction, Layout};
use crate::store::machine::NoStore;
use crate::types::{Address, CobId, Duration, Instant, NodeId, Sealed, correct};

const ID: NodeId = NodeId::of::<5>();
/// SYNC, emergencies, two PDOs of each direction.
const OBJECTS: usize = 6;
pub(super) const NOW: Instant = Instant::from_micros(1_000);

pub(super) fn services() -> Services<Probe, Guard> {
    let settings = Settings::DEFAULT;
    let objects = || NodeObjects::at_power_on(ID, settings.heartbeats, Probe::default());
    let mut services = Services::new(ID, objects, NoStore, &settings, || ());
    services.configure(NOW);
    services
}

/// A client writes a COB-ID.
pub(super) fn write(services: &mut Services<Probe, Guard>, at: Address, value: u32) {
    let mut out = Outbox::<Event>::new();
    services.write(at, &value.to_le_bytes(), NOW).unwrap();
    services.on_own_written(at, &mut Turn::new(NOW, &mut out));
}

/// All objects, what the services use, and whether the copies are right.
fn state(services: &Services<Probe, Guard>) -> (Vec<u32>, Vec<Option<CobId>>, bool) {
    let (dictionary, guarded) = (&services.dictionary, &services.guarded);
    let NodeObjects { communication, pdos, .. } = dictionary.objects();
    let mut written = vec![communication.sync.cob_id, communication.emcy.cob_id];
    written.extend(pdos.rpdos.iter().map(|pdo| pdo.cob_id));
    written.extend(pdos.tpdos.iter().map(|pdo| pdo.cob_id));
    let copies = [guarded.sync, guarded.emcy].into_iter().chain(guarded.rpdos).chain(guarded.tpdos);
    let are_whole = copies.zip(&written).all(|(copy, written)| copy.whole() == Some(*written));
    let mut used = vec![services.sync_id.id(), dictionary.emcy().id().id()];
    used.extend([0, 1].map(|number| dictionary.rpdos().id(number)));
    used.extend([0, 1].map(|number| dictionary.tpdos().id(number)));
    (written, used, are_whole)
}

/// Heartbeats until each COB-ID was compared, at least one with each: the errors that were mended.
pub(super) fn compare(services: &mut Services<Probe, Guard>) -> u16 {
    let mended = |services: &Services<Probe, Guard>| services.objects().extension.mended;
    let before = mended(services);
    for _ in 0..OBJECTS {
        services.compare_cob_ids(NOW);
    }
    mended(services) - before
}

fn object(services: &mut Services<Probe, Guard>, number: usize) -> &mut u32 {
    let objects = services.objects_mut();
    match number {
        0 => &mut objects.communication.sync.cob_id,
        1 => &mut objects.communication.emcy.cob_id,
        2 | 3 => &mut objects.pdos.rpdos[number - 2].cob_id,
        _ => &mut objects.pdos.tpdos[number - 4].cob_id,
    }
}

fn copy(services: &mut Services<Probe, Guard>, number: usize) -> &mut Copied {
    let guarded = &mut services.guarded;
    match number {
        0 => &mut guarded.sync,
        1 => &mut guarded.emcy,
        2 | 3 => &mut guarded.rpdos[number - 2],
        _ => &mut guarded.tpdos[number - 4],
    }
}

/// Another COB-ID in the service, as after a flip of its bit.
fn set_used(services: &mut Services<Probe, Guard>, number: usize, id: CobId) {
    let dictionary = &mut services.dictionary;
    let pdos = dictionary.objects().pdos.clone();
    let resolved =
        Some((id, Layout::new::<NodeObjects<Probe, Guard>>(Direction::Receive, &[0x6000_0008]).unwrap()));
    match number {
        0 => services.sync_id = Sealed::of(id),
        1 => dictionary.emcy_mut().configure(Config { id: Some(id), inhibit: Duration::ZERO }),
        2 => dictionary.rpdos_mut().configure(0, &pdos.rpdos[0], resolved, false).unwrap(),
        _ => dictionary.tpdos_mut().configure(0, &pdos.tpdos[0], resolved, NOW).unwrap(),
    }
}

fn last_error(services: &Services<Probe, Guard>) -> u16 {
    services.objects().communication.emcy.errors.errors[0] as u16
}

/// Verifies: ECSS 6.10d
#[test]
fn nothing_is_reported_where_no_bit_has_flipped() {
    let mut services = services();
    let before = state(&services);
    assert!(before.2);
    assert_eq!((compare(&mut services), state(&services), last_error(&services)), (0, before, 0));
}

/// Verifies: ECSS 6.10d, 6.4a.2
/// Notices: ECSS 6.4a.2: a flipped bit is reported with a code other than 5000h.
#[test]
fn every_flipped_bit_of_an_object_is_mended_and_reported() {
    for number in 0..OBJECTS {
        for bit in 0..32 {
            let mut services = services();
            let before = state(&services);
            *object(&mut services, number) ^= 1 << bit;
            assert_eq!(compare(&mut services), 1, "object {number}, bit {bit}");
            assert_eq!(
                (state(&services), last_error(&services)),
                (before, 0x5000),
                "object {number}, bit {bit}"
            );
        }
    }
}

/// Verifies: ECSS 6.10d
#[test]
fn every_flipped_bit_of_a_copy_changes_no_cob_id() {
    for number in 0..OBJECTS {
        for bit in 0..64 {
            let mut services = services();
            let before = state(&services);
            copy(&mut services, number).flip(bit);
            assert_eq!(compare(&mut services), 1, "object {number}, bit {bit}");
            assert_eq!(
                (state(&services), last_error(&services)),
                (before, 0x5000),
                "object {number}, bit {bit}"
            );
        }
    }
}

/// Verifies: ECSS 6.10d
#[test]
fn every_flipped_bit_of_a_service_is_mended_and_reported() {
    for number in [0, 1, 2, 4] {
        for bit in 0..11 {
            let mut services = services();
            let before = state(&services);
            let used = before.1[number].unwrap().raw();
            set_used(&mut services, number, CobId::new(used ^ 1 << bit).unwrap());
            assert_ne!(state(&services), before);
            assert_eq!(compare(&mut services), 1, "object {number}, bit {bit}");
            assert_eq!(
                (state(&services), last_error(&services)),
                (before, 0x5000),
                "object {number}, bit {bit}"
            );
        }
    }
}

/// Given a client that writes the COB-ID of SYNC, of the emergencies or of a PDO, then it is kept and used: no bit of it
/// counts as flipped.
///
/// Verifies: ECSS 6.10c, 6.10d, 6.10a
/// Notices: ECSS 6.10c: COB-IDs written to 1005h and 1014h are taken back as flipped bits.
#[test]
fn what_a_client_writes_is_no_flipped_bit() {
    let mut services = services();
    let (sync, emcy) = (Address::new(SYNC_COB_ID, 0), Address::new(EMCY_COB_ID, 0));
    for (at, value) in [
        (sync, 0x6C3),
        (emcy, INVALID | 0x085),
        (emcy, 0x6C4),
        (Address::new(TPDO, 1), INVALID | NO_REMOTE | 0x185),
        (Address::new(TPDO, 1), NO_REMOTE | 0x6C5),
    ] {
        write(&mut services, at, value);
        assert_eq!(compare(&mut services), 0, "{at:?}");
    }
    let (written, used, _) = state(&services);
    assert_eq!([written[0], written[1], written[4]], [0x6C3, 0x6C4, NO_REMOTE | 0x6C5]);
    assert_eq!([used[0], used[1], used[4]], [0x6C3, 0x6C4, 0x6C5].map(CobId::new));
}

/// Given a flipped bit in an object, when a client writes another one, then the bit is mended: what is written to
/// one is no reason to take the others for right.
///
/// Verifies: ECSS 6.10d
#[test]
fn flipped_bit_is_mended_after_a_write_elsewhere() {
    for number in [0, 1, 3, 4, 5] {
        let mut services = services();
        let before = state(&services);
        *object(&mut services, number) ^= 1 << 4;
        // RPDO 1 stays as it is.
        let at = Address::new(RPDO, 1);
        write(&mut services, at, 0x205);
        assert_eq!(compare(&mut services), 1, "object {number}");
        assert_eq!(state(&services), before, "object {number}");
    }
}

/// Verifies: ECSS 6.10k
#[test]
fn every_flipped_bit_of_a_node_id_is_mended() {
    for id in (2..=127).filter_map(NodeId::new) {
        for (copy, bit) in (0..3).flat_map(|copy| (0..7).map(move |bit| (copy, bit))) {
            // A Node-ID of zero is none: no bits of one can be so.
            let Some(flipped) = NodeId::new(id.get() ^ 1 << bit) else { continue };
            let mut copies = [id; 3];
            copies[copy] = flipped;
            let [first, second, third] = &mut copies;
            assert!(correct([first, second, third]), "{id:?}, bit {bit}");
            assert_eq!(copies, [id; 3], "bit {bit}");
        }
        assert!(!correct([&mut id.clone(), &mut id.clone(), &mut id.clone()]));
    }
}
