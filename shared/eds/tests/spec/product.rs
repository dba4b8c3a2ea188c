//! The committed files against the slave that they accompany.
//!
//! Verifies: ECSS 6.6a

use std::path::Path;

use ecss_can::node::{MasterObjects, NodeObjects};
use ecss_can::types::NodeId;
use mission::LIBRECUBE;
use mission::minimal::MinimalObjects;
use mission::minimal::prototype::PrototypeObjects;
use mission::{CommanderObjects, MissionObjects, slave};

use crate::content::compare_declared;
use crate::ini::Ini;
use crate::values::compare_fresh;

type Objects = NodeObjects<MissionObjects<Vec<u8>>>;

fn fresh(node: NodeId) -> Objects {
    let mut objects = slave(node, &LIBRECUBE, Vec::new()).objects().clone();
    // Boards have a parameter store.
    (objects.spacecraft.storage.store, objects.spacecraft.storage.restore) = ([1; 4], [1; 4]);
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

#[test]
fn configuration_of_node_3_equals_the_defaults() {
    let dcf = committed("slave-3.dcf");
    let node = dcf.section("DeviceComissioning");
    assert_eq!((node.get("NodeID"), node.get("Baudrate")), ("3", "1000"));
    assert!(dcf.names().all(|name| dcf.section(name).find("ParameterValue").is_none()));
}
