//! The committed files against the slave that they accompany.
//!
//! Verifies: ECSS 6.6a

use std::path::Path;

use ecss_can::node::{MasterObjects, NodeObjects};
use ecss_can::od::Access;
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Duration, NodeId};
use mission::LIBRECUBE;
use mission::minimal::MinimalObjects;
use mission::minimal::prototype::PrototypeObjects;
use mission::{CommanderObjects, MissionObjects, slave};

use crate::content::compare_declared;
use crate::fixture::device;
use crate::ini::Ini;
use crate::values::compare_fresh;

type Objects = NodeObjects<MissionObjects<Vec<u8>>>;

fn fresh(node: NodeId) -> Objects {
    let mut objects = slave(node, &LIBRECUBE, Vec::new()).build().objects().clone();
    // Boards have a parameter store.
    (objects.extension.storage.store, objects.extension.storage.restore) = ([1; 4], [1; 4]);
    objects
}

fn committed(name: &str) -> Ini {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the root of the workspace");
    Ini::parse(&std::fs::read_to_string(root.join("docs/eds").join(name)).expect("it is committed"))
}

/// Verifies: ECSS 9.2a
#[test]
fn both_files_tell_every_object_and_every_value_of_the_slave() {
    for name in ["slave.eds", "slave-3.dcf"] {
        let file = committed(name);
        compare_declared::<Objects>(&file);
        // Errors of the past there are none; the start of the self-test is write-only, the data store a DOMAIN.
        let expected = [&[0x1003; 8][..], &[0x2030, 0x6300]].concat();
        assert_eq!(compare_fresh(&file, fresh), expected, "{name}");
    }
}

/// Given the files of the master and of both minimal slaves. Then each lists every object of its device.
///
/// Verifies: ECSS 9.2a
/// Notices: ECSS 9.2a: a minimal slave has an object that its file does not list.
#[test]
fn files_of_master_and_minimal_slaves_list_every_object() {
    compare_declared::<NodeObjects<MasterObjects<CommanderObjects>>>(&committed("master.eds"));
    compare_declared::<MinimalObjects>(&committed("minimal.eds"));
    compare_declared::<PrototypeObjects>(&committed("minimal-librecube.eds"));
}

/// A data sheet that is made now.
fn made<D: ecss_can::od::Objects>(make: impl Fn(NodeId) -> D) -> Ini {
    let description = ecss_can_eds::Description::new(&device(), make).expect("its texts can be told");
    Ini::parse(&description.eds("made.eds"))
}

/// Every value of the dictionary has its data type and its access in the file.
fn compare_types<D: ecss_can::od::Objects>(file: &Ini) {
    let values = file.values();
    D::describe(&mut |object, _| {
        for index in (0..object.count).map(|nth| object.index + nth) {
            for entry in object.entries {
                for sub in entry.sub..entry.sub + entry.count {
                    let section = values[&(index, sub)];
                    assert_eq!(
                        section.number("DataType"),
                        entry.data_type.index().into(),
                        "{index:04X}sub{sub:X}"
                    );
                    let access = match entry.access {
                        Access::Ro => "ro",
                        Access::Wo => "wo",
                        Access::Rw => "rw",
                        Access::Rwr => "rwr",
                        Access::Rww => "rww",
                        Access::Const => "const",
                    };
                    assert_eq!(section.get("AccessType"), access, "{index:04X}sub{sub:X}");
                }
            }
        }
    });
}

/// Given data sheets of the master and of both minimal slaves. Then each has every object, also the last one of a long row, with the
/// type and the access of each value: the mapping of a minimal slave cannot be written, and 1006h of the master is UNSIGNED32.
///
/// Verifies: ECSS 9.2a, 9.4.5a, 9.4.7.3b.2
/// Notices: ECSS 9.2a: the last of more than sixteen objects in a row is missing.
/// Notices: ECSS 9.4.5a: the data sheet has mappings that can be written.
/// Notices: ECSS 9.4.7.3b.2: the data sheet has 1006h with two bytes.
#[test]
fn data_sheets_tell_type_and_access_of_every_value() {
    let master = made(|_| mission::master(&LIBRECUBE).build().into_objects());
    compare_declared::<NodeObjects<MasterObjects<CommanderObjects>>>(&master);
    compare_types::<NodeObjects<MasterObjects<CommanderObjects>>>(&master);
    let minimal = made(|id| MinimalObjects::new(id, &LIBRECUBE));
    compare_declared::<MinimalObjects>(&minimal);
    compare_types::<MinimalObjects>(&minimal);
    let prototype = made(|id| PrototypeObjects::new(id, &LIBRECUBE));
    compare_declared::<PrototypeObjects>(&prototype);
    compare_types::<PrototypeObjects>(&prototype);
}

/// Given a minimal slave that sends no heartbeat, or consumes none, then 1017h and 1016h of its data sheet have a time of zero.
///
/// Verifies: ECSS 9.2a
/// Notices: ECSS 9.2a: the data sheet of a minimal slave without heartbeat has a period in 1017h.
#[test]
fn data_sheet_of_a_minimal_slave_without_heartbeat_says_so() {
    let of = |file: &Ini| ["1016sub1", "1017"].map(|name| file.section(name).number("DefaultValue"));
    const SIX: NodeId = NodeId::of::<6>();
    const SILENT: Profile =
        Profile { minimal: &[MinimalNode { node: SIX, has_heartbeat: false }], ..LIBRECUBE };
    const ALONE: Profile = Profile { consumer: Duration::ZERO, ..SILENT };
    assert_eq!(of(&made(|_| MinimalObjects::new(SIX, &LIBRECUBE))), [1 << 16 | 2_500, 250]);
    assert_eq!(of(&made(|_| MinimalObjects::new(SIX, &SILENT))), [1 << 16 | 2_500, 0]);
    assert_eq!(of(&made(|_| PrototypeObjects::new(SIX, &SILENT))), [1 << 16 | 2_500, 0]);
    assert_eq!(of(&made(|_| MinimalObjects::new(SIX, &ALONE))), [1 << 16, 0]);
    assert_eq!(of(&made(|_| PrototypeObjects::new(SIX, &ALONE))), [1 << 16, 0]);
}

#[test]
fn configuration_of_node_3_equals_the_defaults() {
    let dcf = committed("slave-3.dcf");
    let node = dcf.section("DeviceComissioning");
    assert_eq!((node.get("NodeID"), node.get("Baudrate")), ("3", "1000"));
    assert!(dcf.names().all(|name| dcf.section(name).find("ParameterValue").is_none()));
}
