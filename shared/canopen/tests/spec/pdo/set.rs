//! Sets of PDOs: the compiler refuses what the rules of run time refuse. Which texts it shows, `tests/declarations/tests/refused` holds.
//!
//! A constant that is refused stops the build; the same functions called at run time panic.
//!
//! Verifies: ECSS 6.2a

use std::panic::{UnwindSafe, catch_unwind};

use async_canopen::od::{Field, Fields, NO_REMOTE, Object, Objects, SubIndex};
use async_canopen::pdo::machine::rules;
use async_canopen::pdo::{CobIdOf, Direction, Layout, Pdo, PdoObjects, PdoParameters, PdoSet};
use async_canopen::types::{Address, CobId, NodeId};

use super::device::{Device, entry};

const ID: CobIdOf = CobIdOf::node(0x280);

fn compiles<T>(constant: impl FnOnce() -> T + UnwindSafe) -> bool {
    catch_unwind(constant).is_ok()
}

/// Constants of every value of the device. What matters here is their declaration, whatever type they have as constants.
fn fields() -> Vec<Field<u8>> {
    let mut fields = vec![];
    Device::each_object(&mut |object| {
        for instance in 0..object.count {
            for entry in object.entries {
                let subs = entry.sub..entry.sub + entry.count;
                fields.extend(subs.map(|sub| constant(object, instance, sub)));
            }
        }
    });
    fields
}

fn constant(object: &Object, instance: u16, sub: u8) -> Field<u8> {
    Fields::<()>::of(object).nth(instance).field(SubIndex::new(sub, 1))
}

/// In which directions the declarations of the device permit to map a value: RPDO, TPDO. Numbers of entries, texts and those without `pdo`
/// in neither, those that are only read in TPDOs, those that are only written in RPDOs.
fn directions(at: Address) -> [bool; 2] {
    let is_count = at.sub == 0 && matches!(at.index, 0x6000 | 0x6001 | 0x6010..=0x6012 | 0x6028);
    match at.index {
        _ if is_count => [false, false],
        0x6025 | 0x6026 => [false, false],
        0x6020 | 0x6022 | 0x6024 | 0x610C | 0x610D => [false, true],
        0x6021 | 0x6023 | 0x6028 => [true, false],
        _ => [true, true],
    }
}

#[test]
fn a_constant_maps_what_a_client_may_map() {
    let fields = fields();
    assert_eq!(fields.len(), 53);
    for field in fields {
        let at = field.address();
        let word = entry(at.index, at.sub, field.data_type().bits().unwrap_or(0));
        let written =
            [Direction::Receive, Direction::Transmit].map(|way| Layout::new::<Device>(way, &[word]).is_ok());
        let compiles = [
            compiles(|| Pdo::<()>::new(ID).map(field).receive(1)),
            compiles(|| Pdo::<()>::new(ID).map(field).transmit(1)),
        ];
        assert_eq!(written, directions(at), "{at:04X?}, written by a client");
        assert_eq!(compiles, directions(at), "{at:04X?}, a constant");
    }
}

/// Types 0 to 240, 254 and 255, SYNC start values 0 to 240 (CiA 301 7.5.2.35 and 7.5.2.37).
///
/// Verifies: ECSS 11.1c
/// Notices: ECSS 6.2a: transmission types 252 and 253 are accepted.
#[test]
fn a_transmission_type_compiles_when_a_client_may_write_it() {
    for value in 0..=u8::MAX {
        let written = |direction, sub| {
            rules::parameters(direction, &PdoParameters::default(), sub, value.into()).is_ok()
        };
        let is_type = !(241..=253).contains(&value);
        assert_eq!(written(Direction::Receive, 2), is_type, "{value}");
        assert_eq!(written(Direction::Transmit, 2), is_type, "{value}");
        assert_eq!(compiles(|| Pdo::<()>::new(ID).receive(1).transmission(value)), is_type, "{value}");
        assert_eq!(compiles(|| Pdo::<()>::new(ID).transmit(1).transmission(value)), is_type, "{value}");
        let is_start = value <= 240;
        assert_eq!(written(Direction::Transmit, 6), is_start, "{value}");
        assert_eq!(compiles(|| Pdo::<()>::new(ID).transmit(1).sync_start(value)), is_start, "{value}");
    }
}

/// Verifies: ECSS 6.10b, 9.5a
/// Notices: ECSS 6.10b: 6E0h to 6FFh are free for PDOs.
#[test]
fn a_cob_id_compiles_when_a_client_may_write_it() {
    let is_written =
        |cob_id| rules::parameters(Direction::Transmit, &PdoParameters::default(), 1, cob_id).is_ok();
    for raw in 0..=0x7FF_u16 {
        // CiA 301, table of restricted CAN-IDs; SYNC is refused where a PDO becomes valid.
        let is_free = matches!(raw, 0x080..=0x100 | 0x181..=0x580 | 0x600 | 0x680..=0x6DF | 0x700);
        assert_eq!(is_written(NO_REMOTE | u32::from(raw)), is_free, "{raw:03X}");
        assert_eq!(compiles(|| CobIdOf::fixed(raw)), is_free && raw != 0x080, "{raw:03X}");
    }
    assert!(!compiles(|| CobIdOf::fixed(0x800)));
    let bases = (0..0x800).filter(|base| compiles(|| CobIdOf::node(*base))).collect::<Vec<_>>();
    // 127 nodes above each.
    let expected = (0x080..=0x081).chain(0x180..=0x501).collect::<Vec<_>>();
    assert_eq!(bases, expected);
}

/// Verifies: ECSS 6.10a
#[test]
fn a_cob_id_of_each_node_is_its_base_plus_the_node() {
    for (node, with_node) in [(1, 0x281), (5, 0x285), (127, 0x2FF)] {
        let node = NodeId::new(node).unwrap();
        assert_eq!(CobIdOf::node(0x280).of(node), CobId::new(with_node).unwrap());
        assert_eq!(CobIdOf::fixed(0x181).of(node), CobId::new(0x181).unwrap());
    }
}

/// Constants find in a dictionary what its accesses find.
#[test]
fn the_tree_of_declarations_has_what_an_access_finds() {
    for index in 0..=u16::MAX {
        for sub in [0, 1, 2, 3, 8, 9, 254, 255] {
            let at = Address::new(index, sub);
            let found = Device::find(at).ok().map(|(place, entry)| (place.object, place.instance, entry));
            assert_eq!(Device::DECLARED.find(at), found, "{at:04X?}");
        }
    }
}

/// Objects in a row at the very end of the indices.
#[test]
fn the_last_object_in_a_row_has_index_ffff() {
    let entries = Fields::<()>::of(&Object { index: 0xFFFE, count: 2, ..*object_6000() });
    assert_eq!(entries.nth(1).sub(5).address(), Address::new(0xFFFF, 5));
    assert!(!compiles(move || entries.nth(2)));
}

fn object_6000() -> &'static Object {
    Device::object(0x6000).unwrap().0
}

/// Given a set with PDOs at bases of the pre-defined connection set, then in each node from 1 to 127 the COB-ID of a PDO, in use or not, is
/// its base and the Node-ID. So no two nodes have one in common.
///
/// Verifies: ECSS 6.10l, 6.10m, 6.10a
/// Notices: ECSS 6.10m: nodes from 65 on have the COB-IDs of those 64 below.
/// Notices: ECSS 6.10a: PDO 4 that is not in use has no pre-defined COB-ID.
#[test]
fn every_node_has_cob_ids_of_its_own() {
    let value = fields().into_iter().find(|field| directions(field.address()) == [true, true]).unwrap();
    let rpdos = Vec::leak(vec![Pdo::<()>::new(CobIdOf::node(0x200)).map(value).receive(1)]);
    let tpdos = Vec::leak(vec![Pdo::<()>::new(ID).map(value).transmit(2)]);
    let set = PdoSet::new(rpdos, tpdos);
    for id in 1..=127 {
        let objects: PdoObjects<4, 4> = set.at_power_on(NodeId::new(id).unwrap());
        let of_node = |bases: [u32; 4]| bases.map(|base| base + u32::from(id));
        let sent = objects.tpdos.map(|pdo| pdo.cob_id & 0x7FF);
        assert_eq!(sent, of_node([0x180, 0x280, 0x380, 0x480]), "node {id}");
        let received = objects.rpdos.map(|pdo| pdo.cob_id & 0x7FF);
        assert_eq!(received, of_node([0x200, 0x300, 0x400, 0x500]), "node {id}");
    }
}

/// CiA 301 7.5.2.35 and 7.5.2.37: sub 3 of 1800h counts 100 us, sub 5 of both milliseconds.
#[test]
fn timers_of_a_set_are_in_the_objects_at_power_on() {
    let received = vec![Pdo::<()>::new(ID).skip::<u8>().receive(1).event_timer(250)];
    let sent = vec![Pdo::<()>::new(ID).map(value()).transmit(2).inhibit(100).event_timer(20)];
    let set = PdoSet::new(received.leak(), sent.leak());
    let objects: PdoObjects = set.at_power_on(NodeId::of::<5>());
    assert_eq!(objects.rpdos[0].event_timer, 250);
    assert_eq!((objects.tpdos[1].inhibit, objects.tpdos[1].event_timer), (100, 20));
}

/// ECSS Table 6-1 and CiA 301 7.5.2.36: 512 PDOs each way, of 64 bits in 8 values at most. A transmit PDO is not the EMCY of a node.
#[test]
fn a_pdo_beyond_its_limits_does_not_compile() {
    for number in [0, 1, 512, 513] {
        assert_eq!(compiles(|| Pdo::<()>::new(ID).receive(number)), matches!(number, 1 | 512), "{number}");
    }
    assert!(compiles(|| Pdo::<()>::new(CobIdOf::node(0x080)).receive(1)));
    assert!(!compiles(|| Pdo::<()>::new(CobIdOf::node(0x080)).transmit(1)));
    let two = || Pdo::<()>::new(ID).skip::<u32>().skip::<u32>();
    assert!(compiles(two) && !compiles(|| two().skip::<bool>()));
    let four = || Pdo::<()>::new(ID).skip::<u8>().skip::<u8>().skip::<u8>().skip::<u8>();
    assert!(compiles(|| four().skip::<u8>().skip::<u8>().skip::<u8>().skip::<u8>().receive(1)));
    assert!(!compiles(|| Pdo::<()>::new(ID).skip::<f32>()), "CiA 301 7.4.8.2 has no dummy of that type");
}

/// The slots of a device, and the objects of its dictionary, bound its set.
#[test]
fn a_set_beyond_its_device_does_not_compile() {
    let sends = |number, field| {
        let set = PdoSet::new(&[], vec![Pdo::<()>::new(ID).map(field).transmit(number)].leak());
        compiles(move || set.assert_within::<PdoObjects<1, 2>>(Device::DECLARED))
    };
    assert!(sends(2, value()) && !sends(3, value()));
    let elsewhere = constant(&Object { index: 0x5FFF, ..*object_6000() }, 0, 1);
    assert!(!sends(1, elsewhere), "5FFFh is not there");
    let receives = |number| {
        let set = PdoSet::new(vec![Pdo::<()>::new(ID).skip::<bool>().receive(number)].leak(), &[]);
        compiles(move || set.assert_within::<PdoObjects<1, 2>>(Device::DECLARED))
    };
    assert!(receives(1) && !receives(2));
}

/// One that a transmit PDO carries.
fn value() -> Field<u8> {
    let mut fields = fields().into_iter();
    fields.find(|field| compiles(|| Pdo::<()>::new(ID).map(*field).transmit(1))).expect("there is one")
}
