//! COB-IDs: pre-defined connection set, restricted identifiers, COB-ID entries.
//!
//! Verifies: ECSS 6.10a, 6.10b

use async_canopen::od::CobIdEntry;
use async_canopen::od::machine::EntryUse;
use async_canopen::types::{AbortCode, CobId, NodeId};

use crate::bench::node;

const REFUSED: Result<u32, AbortCode> = Err(AbortCode::ValueRange);
/// The entry of an object that is not in use.
const UNUSED: u32 = 0x8000_0000;

fn write(present: u32, raw: u32, entry_use: EntryUse) -> Result<u32, AbortCode> {
    CobIdEntry::from_raw(present).written(raw, entry_use).map(CobIdEntry::raw)
}

/// Verifies: ECSS 9.5a, 9.3a
#[test]
fn the_pre_defined_connection_set() {
    let id = node(0x7F);
    assert_eq!([CobId::NMT, CobId::SYNC].map(CobId::raw), [0x000, 0x080]);
    let single = [CobId::emcy(id), CobId::sdo_response(id), CobId::sdo_request(id), CobId::heartbeat(id)];
    assert_eq!(single.map(CobId::raw), [0x0FF, 0x5FF, 0x67F, 0x77F]);
    let pdos =
        |of: fn(u16, _) -> Option<CobId>| [1, 2, 3, 4].map(|number| of(number, node(1)).unwrap().raw());
    assert_eq!(pdos(CobId::tpdo), [0x181, 0x281, 0x381, 0x481]);
    assert_eq!(pdos(CobId::rpdo), [0x201, 0x301, 0x401, 0x501]);
    for number in [0, 5, 512, u16::MAX] {
        assert_eq!((CobId::tpdo(number, id), CobId::rpdo(number, id)), (None, None));
    }
}

/// Of two identifiers the lower one wins arbitration.
///
/// Verifies: ECSS 9.1a
/// Notices: ECSS 9.1a: heartbeat COB-IDs count down from 780h.
#[test]
fn master_wins_arbitration_against_same_object_of_any_slave() {
    let objects = |id| {
        let single = [CobId::emcy(id), CobId::sdo_response(id), CobId::sdo_request(id), CobId::heartbeat(id)];
        let pdos = (1..=4).flat_map(move |number| [CobId::tpdo(number, id), CobId::rpdo(number, id)]);
        single.into_iter().chain(pdos.flatten()).map(CobId::raw).collect::<Vec<_>>()
    };
    for raw in 2..=127 {
        let pairs = objects(NodeId::MASTER).into_iter().zip(objects(node(raw)));
        assert!(pairs.clone().all(|(master, slave)| master < slave), "{raw}");
        assert_eq!(pairs.count(), 12);
    }
}

/// Verifies: ECSS 9.5a, 11.1d
/// Notices: ECSS 9.5a: COB-IDs above 77Fh are not restricted.
/// Notices: ECSS 11.1d: 780h and above, 180h or 6FFh are free (row 7.3.5).
#[test]
fn restricted_identifiers() {
    let restricted = |raw: u16| CobId::new(raw).unwrap().is_restricted();
    let ranges =
        [(0x000, 0x07F), (0x101, 0x180), (0x581, 0x5FF), (0x601, 0x67F), (0x6E0, 0x6FF), (0x701, 0x7FF)];
    for raw in 0..=0x7FF {
        let expected = ranges.iter().any(|(first, last)| (*first..=*last).contains(&raw));
        assert_eq!(restricted(raw), expected, "{raw:03X}");
    }
}

#[test]
fn an_entry_is_viewed_by_its_bits() {
    let entry = CobIdEntry::from_raw(0x4000_0181);
    assert_eq!(entry.cob_id().map(CobId::raw), Some(0x181));
    assert!(entry.flag());
    let unused = CobIdEntry::from_raw(0x8000_0181);
    assert_eq!((unused.cob_id(), unused.id().raw(), unused.flag()), (None, 0x181, false));
    assert_eq!(CobIdEntry::from_raw(0x2000_0181).cob_id(), None);
    assert_eq!(CobIdEntry::from_raw(0x0000_0981).cob_id(), None);
}

/// Verifies: ECSS 6.10c
#[test]
fn an_object_not_in_use_takes_any_free_identifier() {
    for (entry_use, raw) in [
        (EntryUse::Pdo, 0x0000_0222),
        (EntryUse::Pdo, 0x4000_06DF),
        (EntryUse::Pdo, 0x8000_0000),
        (EntryUse::Pdo, 0xC000_0181),
        (EntryUse::Emcy, 0x0000_00FF),
        (EntryUse::Emcy, 0x8000_0085),
        (EntryUse::Sdo, 0x0000_06C5),
        (EntryUse::Sdo, 0x8000_0605),
    ] {
        assert_eq!(write(UNUSED, raw, entry_use), Ok(raw), "{entry_use:?} {raw:08X}");
    }
}

/// Verifies: ECSS 6.10c
#[test]
fn the_identifier_of_an_object_in_use_stays() {
    for (entry_use, code) in [
        (EntryUse::Pdo, AbortCode::UnsupportedAccess),
        (EntryUse::Emcy, AbortCode::ValueRange),
        (EntryUse::Sdo, AbortCode::ValueRange),
    ] {
        assert_eq!(write(0x0000_0201, 0x0000_0202, entry_use), Err(code));
        assert_eq!(write(0x0000_0201, 0x0000_0201, entry_use), Ok(0x0000_0201));
        // The write that ends the use may move a PDO, as the tools of others do.
        let ended = if entry_use == EntryUse::Pdo { Ok(0x8000_0202) } else { Err(code) };
        assert_eq!(write(0x0000_0201, 0x8000_0202, entry_use), ended);
        assert_eq!(write(0x0000_0201, 0x8000_0201, entry_use), Ok(0x8000_0201));
        assert_eq!(write(0x8000_0201, 0x8000_0202, entry_use), Ok(0x8000_0202));
        assert_eq!(write(0x8000_0201, 0x0000_0202, entry_use), Ok(0x0000_0202));
    }
}

/// Given objects that use no restricted identifier, when a client writes one, then a PDO and the emergencies refuse it if they become
/// valid, and SYNC refuses it always: its bit 31 does not make it invalid.
///
/// Verifies: ECSS 11.1d
/// Notices: ECSS 11.1d: 1005h takes a restricted identifier (row 7.3.5).
#[test]
fn restricted_identifiers_are_refused_for_valid_objects() {
    for raw in [0x000, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x601, 0x67F, 0x6E0, 0x701, 0x7FF] {
        for entry_use in [EntryUse::Pdo, EntryUse::Emcy, EntryUse::Sdo] {
            assert_eq!(write(UNUSED, raw, entry_use), REFUSED, "{entry_use:?} {raw:03X}");
            assert!(write(UNUSED, 0x8000_0000 | raw, entry_use).is_ok());
        }
        for flags in [0, 0x4000_0000, 0x8000_0000] {
            assert_eq!(write(0x0000_0080, flags | raw, EntryUse::Sync), REFUSED, "SYNC {flags:X} {raw:03X}");
        }
    }
}

/// Given an object not in use and a consumer of SYNC, then none of them takes a COB-ID of 1921 to 2014 and 2032 to 2047.
///
/// Verifies: ECSS 9.5a
/// Notices: ECSS 9.5a: COB-IDs of 1005h are restricted only while SYNC is produced.
#[test]
fn free_cob_ids_are_refused_for_every_object() {
    for raw in (1921..=2014).chain(2032..=2047) {
        for entry_use in [EntryUse::Pdo, EntryUse::Emcy, EntryUse::Sdo] {
            assert_eq!(write(UNUSED, raw, entry_use), REFUSED, "{entry_use:?} {raw}");
        }
        assert_eq!(write(0x0000_0080, raw, EntryUse::Sync), REFUSED, "consumer {raw}");
        assert_eq!(write(0x0000_0080, 0x4000_0000 | raw, EntryUse::Sync), REFUSED, "producer {raw}");
    }
}

#[test]
fn extended_identifiers_and_reserved_bits_are_refused() {
    for entry_use in [EntryUse::Pdo, EntryUse::Emcy, EntryUse::Sync, EntryUse::Sdo] {
        for raw in [0x2000_0085, 0xA000_0085, 0x0000_0885, 0x1000_0085] {
            assert_eq!(write(UNUSED, raw, entry_use), REFUSED, "{entry_use:?} {raw:08X}");
        }
    }
    for entry_use in [EntryUse::Emcy, EntryUse::Sdo] {
        assert_eq!(write(UNUSED, 0x4000_0085, entry_use), REFUSED, "{entry_use:?}");
    }
}

/// Verifies: ECSS 6.3b, 6.10c
#[test]
fn the_identifier_of_sync_stays_while_it_is_produced() {
    let sync = EntryUse::Sync;
    assert_eq!(write(0x0000_0080, 0x4000_0080, sync), Ok(0x4000_0080));
    assert_eq!(write(0x0000_0080, 0x0000_0090, sync), Ok(0x0000_0090));
    assert_eq!(write(0x4000_0080, 0x4000_0090, sync), Err(AbortCode::ValueRange));
    assert_eq!(
        write(0x4000_0080, 0x0000_0090, sync),
        Err(AbortCode::ValueRange),
        "in the write that ends it"
    );
    assert_eq!(write(0x4000_0080, 0x0000_0080, sync), Ok(0x0000_0080));
    // Bit 31 does not matter, neither to validity nor to restrictions.
    assert_eq!(write(0x0000_0080, 0x8000_0080, sync), Ok(0x8000_0080));
    assert_eq!(write(0xC000_0080, 0xC000_0090, sync), Err(AbortCode::ValueRange));
    assert_eq!(write(0x0000_0080, 0x8000_0701, sync), Err(AbortCode::ValueRange));
}
