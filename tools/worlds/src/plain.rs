//! A master for tests of slaves.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Master};
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;

/// Device of a master with the objects of every master and no other.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct Plain {}

impl Device for Plain {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &[]);

    fn communication(id: NodeId) -> Communication {
        Communication { device_name: "Plain master", ..Communication::new(id) }
    }
}

/// Makes a master that boots, starts and monitors its slaves, and manages buses and time, for a world in which slaves
/// are tested.
pub fn plain_master(profile: &Profile) -> Master<Plain> {
    Master::builder(profile, Plain::default()).build()
}
