//! The master of the demonstration mission.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Communication, Device, Identity, Master};
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::profile::Profile;
use ecss_can::types::NodeId;

/// What the master of the mission has beside the objects of every master: nothing.
#[derive(Clone, Debug, PartialEq, Objects)]
#[objects(device)]
pub struct CommanderObjects {}

impl Device for CommanderObjects {
    type Pdos = PdoObjects<0, 0>;
    type Consumers = HeartbeatConsumers<8>;

    const PDOS: PdoSet = PdoSet::NONE;

    fn communication(id: NodeId) -> Communication {
        Communication {
            device_name: "ECSS-E-ST-50-15C master",
            software_version: env!("CARGO_PKG_VERSION"),
            identity: Identity { vendor: 0, product: 0x5015, revision: 1 << 16, serial: 1 },
            ..Communication::new(id)
        }
    }
}

/// The master of the mission.
pub fn master(profile: &Profile) -> Master<CommanderObjects> {
    Master::new(profile, CommanderObjects::default())
}
