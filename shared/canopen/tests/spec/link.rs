//! Frames, COB-IDs, filters, buses.

use async_canopen::link::Stamp;
use async_canopen::link::port::{Filter, is_urgent};
use async_canopen::types::{Bus, CobId, FineInstant, Frame, FrameError};

use crate::bench::{frame, node};

#[test]
fn a_cob_id_has_eleven_bits() {
    assert_eq!(CobId::new(0x7FF).map(CobId::raw), Some(0x7FF));
    assert_eq!(CobId::new(0x800), None);
}

/// Verifies: ECSS 6.10a
#[test]
fn predefined_cob_ids_of_a_node() {
    let id = node(0x7F);
    assert_eq!([CobId::emcy(id), CobId::heartbeat(id)].map(CobId::raw), [0x0FF, 0x77F]);
    let raw = |pdo: Option<CobId>| pdo.map(CobId::raw);
    let transmit = [0, 1, 2, 3, 4, 5].map(|number| raw(CobId::tpdo(number, id)));
    assert_eq!(transmit, [None, Some(0x1FF), Some(0x2FF), Some(0x3FF), Some(0x4FF), None]);
    assert_eq!(CobId::new(0x77F).unwrap().node(), Some(id));
    assert_eq!(CobId::new(0x77F).unwrap().function(), 0x700);
    assert_eq!(CobId::SYNC.node(), None);
}

#[test]
fn a_frame_has_at_most_eight_bytes() {
    let id = CobId::SYNC;
    assert_eq!(Frame::new(id, &[0; 9]), Err(FrameError::TooLong));
    assert_eq!(Frame::new(id, &[7; 8]).unwrap().data(), [7; 8]);
}

#[test]
fn a_dlc_above_eight_means_eight_bytes() {
    let frame = Frame::from_dlc(CobId::SYNC, 15, [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!((frame.dlc(), frame.data()), (8, [1, 2, 3, 4, 5, 6, 7, 8].as_slice()));
}

#[test]
fn bytes_beyond_the_length_do_not_count() {
    let dirty = Frame::from_dlc(CobId::SYNC, 1, [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(dirty, frame(0x080, &[1]));
    assert_eq!(dirty.padded(), [1, 0, 0, 0, 0, 0, 0, 0]);
}

#[test]
fn frames_print_like_candump() {
    assert_eq!(format!("{:?}", frame(0x181, &[0xDE, 0xAD])), "181#DEAD");
}

#[test]
fn filters_admit_by_mask() {
    let (sync, heartbeat) = (CobId::SYNC, CobId::heartbeat(node(1)));
    assert!(Filter::exact(heartbeat).admits(heartbeat));
    assert!(!Filter::exact(heartbeat).admits(CobId::heartbeat(node(2))));
    assert!(Filter::function(heartbeat).admits(CobId::heartbeat(node(127))));
    assert!(!Filter::function(heartbeat).admits(sync));
}

#[test]
fn network_management_sync_and_time_are_urgent() {
    let urgent = |raw| is_urgent(CobId::new(raw).unwrap());
    assert!(urgent(0x000) && urgent(0x080) && urgent(0x0FF) && urgent(0x181));
    assert!(!urgent(0x182) && !urgent(0x701));
}

#[test]
fn the_alternate_bus_is_always_the_other_one() {
    for bus in Bus::ALL {
        assert_ne!(bus.other(), bus);
        assert_eq!(Bus::from_bdefault(bus.bdefault()), Some(bus));
    }
    assert_eq!(Bus::from_bdefault(2), None);
}

/// 84 counts in a microsecond, which has 256 parts: a part is a third of a count. The low word wraps after 51 s.
#[test]
fn a_stamp_has_the_low_word_of_its_timer() {
    for (micros, part, low) in [
        (0, 0, 0),
        (0, 1, 0),
        (0, 2, 1),
        (0, 128, 42),
        (0, 255, 84),
        (1_000, 64, 84_021),
        (51_130_563, 0, 4_294_967_292),
        (51_130_563, 128, 38),
    ] {
        let stamp = Stamp::captured(FineInstant::from_units(micros * 256 + part));
        assert_eq!(stamp.low::<84>(), low, "{micros} us and {part}/256");
    }
}
