//! Devices with PDOs of objects that they do not have, or beyond their slots.

use ecss_can::emcy::EmcyObjects;
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
struct WithoutPower {
    /// Mode
    #[object(0x6001, rw)]
    mode: u8,
}

#[derive(Objects)]
#[objects(device)]
struct WithAnother {
    /// Voltage, in a finer unit
    #[object(0x6000, ro, pdo)]
    voltage: u32,
}

#[derive(Objects)]
#[objects(device)]
struct WithParameter<G: Objects + Default + 'static = WithoutPower> {
    #[objects]
    group: G,
}

/// With power, and with an index of the node.
#[derive(Objects)]
#[objects(device)]
struct OnForeignGround {
    #[objects]
    power: Power,
    /// Local time
    #[object(0x2010, ro)]
    time: u32,
}

impl Device for WithoutPower {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PDOS;
}

impl Device for WithAnother {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PDOS;
}

impl<G: Objects + Default + 'static> Device for WithParameter<G> {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PDOS;
}

impl Device for OnForeignGround {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PDOS;
}

/// Eight receive PDOs, and four that it transmits.
#[derive(Objects)]
#[objects(device)]
struct WithoutRoom {}

impl Device for WithoutRoom {
    type Pdos = PdoObjects<8, 4>;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet =
        PdoSet::new(&[], &[Pdo::<()>::new(CobIdOf::node(0x180)).map(EmcyObjects::REGISTER).transmit(5)]);
}

#[derive(Objects)]
#[objects(device)]
struct WithNinth {}

impl Device for WithNinth {
    type Pdos = PdoObjects;
    type Consumers = HeartbeatConsumers;

    const PDOS: PdoSet = PdoSet::new(&[Pdo::<()>::new(CobIdOf::node(0x200)).skip::<u8>().receive(9)], &[]);
}

#[derive(Objects)]
#[objects(device)]
struct NoDevice {}

fn main() {}
