//! A number of SDO servers that a device cannot have, and one of what is no device.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::Device;
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};

#[derive(Objects)]
#[objects(device, sdo_servers = 3)]
struct Pump {
    /// Speed
    #[object(0x6000, rw)]
    speed: u16,
}

impl Device for Pump {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::NONE;
}

#[derive(Objects)]
#[objects(sdo_servers = 2)]
struct Group {
    /// Level
    #[object(0x6001, rw)]
    level: u16,
}

#[derive(Objects)]
#[objects(device, sdo_server = 2)]
struct Valve {
    /// Level
    #[object(0x6001, rw)]
    level: u16,
}

impl Device for Valve {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::NONE;
}

fn main() {}
