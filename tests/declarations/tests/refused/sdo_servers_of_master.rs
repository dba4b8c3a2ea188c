//! A master whose device has two SDO servers.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, Master};
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};
use ecss_can::profile::Profile;

#[derive(Objects)]
#[objects(device, sdo_servers = 2)]
struct Computer {
    /// Mode
    #[object(0x6000, rw)]
    mode: u16,
}

impl Device for Computer {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::NONE;
}

fn main() {
    Master::builder(&Profile::DEFAULT, Computer::default()).build();
}
