//! Profiles with slaves that have the Node-ID of the master or of boards in maintenance mode.

use ecss_can::boot::{AssignedSlave, Expected, Setting};
use ecss_can::profile::{MinimalNode, Profile};
use ecss_can::types::{Address, NodeId};

const MASTER: NodeId = NodeId::MASTER;
const MAINTENANCE: NodeId = NodeId::of::<127>();

const fn assigned(node: NodeId) -> AssignedSlave {
    let expected = Expected { device_type: 0, identity: [0; 4], stamp: [0; 2] };
    AssignedSlave { node, mandatory: false, expected }
}

const fn setting(node: NodeId) -> Setting {
    Setting { node, at: Address::new(0x1017, 0), value: &[100, 0] }
}

const fn minimal(node: NodeId) -> MinimalNode {
    MinimalNode { node, has_heartbeat: true }
}

const SLAVES: Profile =
    Profile { slaves: &[assigned(NodeId::of::<126>()), assigned(MAINTENANCE)], ..Profile::DEFAULT };
const SETTINGS: Profile = Profile { settings: &[setting(MAINTENANCE)], ..Profile::DEFAULT };
const MINIMAL: Profile = Profile { minimal: &[minimal(MAINTENANCE)], ..Profile::DEFAULT };
const SELECTIVE: Profile = Profile { selective: &[MASTER, MAINTENANCE], ..Profile::DEFAULT };
const SLAVE_OF_ITSELF: Profile = Profile { slaves: &[assigned(MASTER)], ..Profile::DEFAULT };

const _: Profile = SLAVES.checked();
const _: Profile = SETTINGS.checked();
const _: Profile = MINIMAL.checked();
const _: Profile = SELECTIVE.checked();
const _: Profile = SLAVE_OF_ITSELF.checked();

fn main() {}
