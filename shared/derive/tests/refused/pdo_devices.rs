//! PDOs of objects that the device does not have: seen where the declaration of the application names its set.

use ecss_can::od::Objects;
use ecss_can::pdo::{CobIdOf, PdoSet, Tpdo};

#[derive(Objects)]
struct Power {
    /// Voltage
    #[object(0x6000, ro, pdo)]
    voltage: u16,
}

const PDOS: PdoSet = PdoSet::new(&[], &[Tpdo::new(2, CobIdOf::node(0x280)).map(Power::VOLTAGE)]);

#[derive(Objects)]
#[objects(pdos = PDOS)]
struct WithoutPower {
    /// Mode
    #[object(0x6001, rw)]
    mode: u8,
}

#[derive(Objects)]
#[objects(pdos = PDOS)]
struct WithAnother {
    /// Voltage, in a finer unit
    #[object(0x6000, ro, pdo)]
    voltage: u32,
}

#[derive(Objects)]
#[objects(pdos = PDOS)]
struct WithParameter<G: Objects + Default = WithoutPower> {
    #[objects]
    group: G,
}

/// With power, and with an index of the node.
#[derive(Objects)]
#[objects(pdos = PDOS)]
struct OnForeignGround {
    #[objects]
    power: Power,
    /// Local time
    #[object(0x2010, ro)]
    time: u32,
}

fn main() {}
