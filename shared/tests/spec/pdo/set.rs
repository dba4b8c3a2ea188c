//! Sets of PDOs: the compiler refuses what the rules of run time refuse. Which texts it shows, `shared/derive/tests` holds.
//!
//! A constant that is refused stops the build; the same functions called at run time panic.

use std::panic::{UnwindSafe, catch_unwind};

use ecss_can::node::NodeObjects;
use ecss_can::od::{Field, Fields, NO_REMOTE, Object, Objects};
use ecss_can::pdo::{CobIdOf, Direction, Layout, PdoParameters, Rpdo, Tpdo, rules};
use ecss_can::types::{Address, CobId, NodeId};

use super::device::{Device, entry};

const ID: CobIdOf = CobIdOf::node(0x280);

fn compiles<T>(constant: impl FnOnce() -> T + UnwindSafe) -> bool {
    catch_unwind(constant).is_ok()
}

/// Constants of every value of the device.
fn fields() -> Vec<Field> {
    let mut fields = vec![];
    Device::each_object(&mut |object| {
        for instance in 0..object.count {
            for entry in object.entries {
                let subs = entry.sub..entry.sub + entry.count;
                fields.extend(subs.map(|sub| Fields::<()>::of(object).nth(instance).sub(sub)));
            }
        }
    });
    fields
}

/// Verifies: ECSS 6.2a
#[test]
fn a_constant_maps_what_a_client_may_map() {
    let fields = fields();
    assert_eq!(fields.len(), 53);
    for field in fields {
        let at = field.address();
        let word = entry(at.index, at.sub, field.data_type().bits().unwrap_or(0));
        let both = [
            (Direction::Receive, compiles(|| Rpdo::new(1, ID).map(field))),
            (Direction::Transmit, compiles(|| Tpdo::new(1, ID).map(field))),
        ];
        for (direction, compiles) in both {
            assert_eq!(
                compiles,
                Layout::new::<Device>(direction, &[word]).is_ok(),
                "{at:04X?} {direction:?}"
            );
        }
    }
}

#[test]
fn a_transmission_type_compiles_when_a_client_may_write_it() {
    for value in 0..=u8::MAX {
        let written = |direction, sub| {
            rules::parameters(direction, &PdoParameters::default(), sub, value.into()).is_ok()
        };
        let receive = written(Direction::Receive, 2);
        let transmit = written(Direction::Transmit, 2);
        assert_eq!(compiles(|| Rpdo::new(1, ID).transmission(value)), receive, "{value}");
        assert_eq!(compiles(|| Tpdo::new(1, ID).transmission(value)), transmit, "{value}");
        let start = written(Direction::Transmit, 6);
        assert_eq!(compiles(|| Tpdo::new(1, ID).sync_start(value)), start, "{value}");
    }
}

/// Verifies: ECSS 6.10b
#[test]
fn a_cob_id_compiles_when_a_client_may_write_it() {
    let is_written =
        |cob_id| rules::parameters(Direction::Transmit, &PdoParameters::default(), 1, cob_id).is_ok();
    for raw in 0..=0x7FF_u16 {
        // SYNC is refused where a PDO becomes valid.
        let allowed = is_written(NO_REMOTE | u32::from(raw)) && raw != 0x080;
        assert_eq!(compiles(|| CobIdOf::fixed(raw)), allowed, "{raw:03X}");
    }
    assert!(!compiles(|| CobIdOf::fixed(0x800)));
    let bases = (0..0x800).filter(|base| compiles(|| CobIdOf::node(*base))).collect::<Vec<_>>();
    // 127 nodes above each.
    let expected = (0x080..=0x081).chain(0x180..=0x501).collect::<Vec<_>>();
    assert_eq!(bases, expected);
}

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
    type Node = NodeObjects<Device>;
    for index in 0..=u16::MAX {
        for sub in [0, 1, 2, 3, 8, 9, 254, 255] {
            let at = Address::new(index, sub);
            let found = Node::find(at).ok().map(|(place, entry)| (place.object, place.instance, entry));
            assert_eq!(Node::DECLARED.find(at), found, "{at:04X?}");
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
