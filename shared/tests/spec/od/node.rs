//! The objects that every node has.

use ecss_can::node::{Communication, NodeObjects, Spacecraft};
use ecss_can::od::{INVALID, NO_REMOTE, Objects, U24};
use ecss_can::pdo::{Direction, Layout, Mapping, PdoObjects, PdoSet, StaticMapping};
use ecss_can::time::{ScetGet, ScetSet};
use ecss_can::types::AbortCode::{ReadOnly, ValueTooHigh, ValueTooLow, WriteOnly};
use ecss_can::types::{Address, NodeId, Scet};

use super::{read, write};
use crate::instrument::Instrument;

/// Verifies: ECSS 6.10a
#[test]
fn node_has_pre_defined_connection_set_until_configured() {
    let objects = PdoSet::NONE.at_power_on::<PdoObjects<6, 5>>(NodeId::of::<5>());
    assert_eq!(Communication::new(NodeId::of::<5>()).emcy.cob_id, 0x85);
    let ids = |cob_ids: &[u32]| cob_ids.iter().map(|raw| raw & !(INVALID | NO_REMOTE)).collect::<Vec<_>>();
    let received = objects.rpdos.map(|pdo| pdo.cob_id);
    let sent = objects.tpdos.map(|pdo| pdo.cob_id);
    assert_eq!(ids(&received), [0x205, 0x305, 0x405, 0x505, 0, 0]);
    assert_eq!(ids(&sent), [0x185, 0x285, 0x385, 0x485, 0]);
    // None of them is in use: nothing is mapped.
    assert!(received.iter().chain(&sent).all(|raw| raw & INVALID != 0));
    assert!(
        objects
            .rpdo_mappings
            .iter()
            .chain(&objects.tpdo_mappings)
            .all(|mapping| mapping.objects().is_empty())
    );
}

/// Verifies: ECSS 6.8a
#[test]
fn a_static_mapping_cannot_be_written() {
    let mut objects = PdoSet::NONE.at_power_on::<PdoObjects<1, 1, StaticMapping>>(NodeId::of::<5>());
    objects.tpdo_mappings[0].map(&[0x1001_0008]);
    assert_eq!(read(&mut objects, 0x1A00, 0), Ok(vec![1]));
    assert_eq!(read(&mut objects, 0x1A00, 1), Ok(vec![0x08, 0x00, 0x01, 0x10]));
    for sub in 0..=8 {
        let value = if sub == 0 { &[0][..] } else { &[0; 4] };
        assert_eq!(write(&mut objects, 0x1A00, sub, value), Err(ReadOnly), "{sub}");
    }
}

/// Verifies: ECSS 8.3.1a, 8.3.1c, 6.8a
/// Notices: ECSS 8.3.1a: Ntoggle cannot be written.
#[test]
fn the_redundancy_object_has_four_programmable_values() {
    let mut objects = Spacecraft::default();
    assert_eq!(read(&mut objects, 0x2000, 0), Ok(vec![4]));
    for sub in 1..=4 {
        assert_eq!(write(&mut objects, 0x2000, sub, &[sub + 10]), Ok(()), "{sub}");
        assert_eq!(read(&mut objects, 0x2000, sub), Ok(vec![sub + 10]));
    }
    let redundancy = objects.redundancy.parameters;
    assert_eq!(
        [redundancy.bdefault, redundancy.ttoggle, redundancy.ntoggle, redundancy.ctoggle],
        [11, 12, 13, 14]
    );
}

/// Verifies: ECSS 7.1.2b, 7.1.2e, 7.1.2f
/// Notices: ECSS 7.1.2b: a client can write the coarse time of Local SCET Get.
/// Notices: ECSS 7.1.2e: only 16 bits of fine time are taken.
/// Notices: ECSS 7.1.2e: the highest bit of the fine time that is set is lost.
#[test]
fn spacecraft_time_is_set_and_got_in_the_format_of_the_figure() {
    let mut objects = Spacecraft::default();
    // Fine time first, both little-endian.
    let frame = [0x56, 0x34, 0x92, 0xEF, 0xCD, 0xAB, 0x89, 0];
    let set = Layout::new::<Spacecraft>(Direction::Receive, &[0x2010_0218, 0x2010_0120]).unwrap();
    assert!(set.unpack(&mut objects, u64::from_le_bytes(frame)));
    assert_eq!(objects.time.scet_set, ScetSet { coarse: 0x89AB_CDEF, fine: U24::new(0x92_3456) });
    let scet = Scet::from(objects.time.scet_set);
    assert_eq!((scet.coarse(), scet.fine()), (0x89AB_CDEF, 0x92_3456));
    objects.time.scet_get = ScetGet::from(scet);
    let get = Layout::new::<Spacecraft>(Direction::Transmit, &[0x2011_0218, 0x2011_0120]).unwrap();
    assert_eq!((get.bytes(), get.pack(&objects).to_le_bytes()), (7, frame));
    assert_eq!(read(&mut objects, 0x2011, 1), Ok(frame[3..7].to_vec()));
    assert_eq!(read(&mut objects, 0x2011, 2), Ok(frame[..3].to_vec()));
    assert_eq!(write(&mut objects, 0x2011, 1, &[0; 4]), Err(ReadOnly));
}

/// Verifies: ECSS 6.7b, 6.7c
#[test]
fn the_self_test_is_started_by_one_object_and_told_by_another() {
    let mut objects = Spacecraft::default();
    assert_eq!(write(&mut objects, 0x2030, 0, &[0]), Err(ValueTooLow));
    assert_eq!(write(&mut objects, 0x2030, 0, &[2]), Err(ValueTooHigh));
    assert_eq!(write(&mut objects, 0x2030, 0, &[1]), Ok(()));
    assert_eq!(read(&mut objects, 0x2030, 0), Err(WriteOnly));
    objects.self_test.progress = 3;
    objects.self_test.failures = 0x8000_0001;
    assert_eq!(read(&mut objects, 0x2031, 1), Ok(vec![3]));
    assert_eq!(read(&mut objects, 0x2031, 2), Ok(vec![1, 0, 0, 0x80]));
    assert_eq!(write(&mut objects, 0x2031, 1, &[0]), Err(ReadOnly));
}

/// Constants find in the dictionary of a node what its accesses find.
#[test]
fn the_declarations_of_a_node_have_what_an_access_finds() {
    type Node = NodeObjects<Instrument>;
    for index in 0..=u16::MAX {
        for sub in [0, 1, 2, 3, 8, 9, 254, 255] {
            let at = Address::new(index, sub);
            let found = Node::find(at).ok().map(|(place, entry)| (place.object, place.instance, entry));
            assert_eq!(Node::DECLARED.find(at), found, "{at:04X?}");
        }
    }
}
