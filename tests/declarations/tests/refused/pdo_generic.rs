//! A set that the declaration checks where its constructor is used, for a parameter without default.

use ecss_can::heartbeat::HeartbeatConsumers;
use ecss_can::node::Device;
use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet};

#[derive(Objects)]
struct Power {
    /// Voltage
    #[object(0x6000, ro, pdo)]
    voltage: u16,
}

const PDOS: PdoSet =
    PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x280)).map(Power::VOLTAGE).transmit(2)]);

#[derive(Objects)]
#[objects(device)]
struct Box<G: Objects + Default + 'static> {
    #[objects]
    group: G,
}

#[derive(Objects)]
struct Mode {
    /// Mode
    #[object(0x6001, rw)]
    mode: u8,
}

impl<G: Objects + Default + 'static> Device for Box<G> {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PDOS;
}

fn main() {
    Box::<Power>::default();
    Box::<Mode>::default();
}
