//! Devices whose declaration lacks `#[objects(device)]`, or that have no communication profile.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::{Device, Slave};
use ecss_can::od::Objects;
use ecss_can::pdo::{PdoObjects, PdoSet};

#[derive(Objects)]
struct Heater {
    /// Power
    #[object(0x6000, rw)]
    power: u8,
}

impl Device for Heater {
    type Pdos = PdoObjects<1, 1>;
    type Consumers = HeartbeatConsumers<1>;

    const PDOS: PdoSet = PdoSet::new(&[], &[]);
}

#[derive(Objects)]
#[objects(device)]
struct Valve {
    /// Opening
    #[object(0x6000, rw)]
    opening: u8,
}

#[derive(Objects)]
struct Pump {
    /// Speed
    #[object(0x6000, rw)]
    speed: u8,
}

struct Board {
    node: Slave<Pump>,
}

fn main() {}
