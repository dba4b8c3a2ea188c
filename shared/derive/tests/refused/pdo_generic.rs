//! A set that the declaration checks where its constructor is used, for a parameter without default.

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
struct Device<G: Objects + Default> {
    #[objects]
    group: G,
}

#[derive(Objects)]
struct Mode {
    /// Mode
    #[object(0x6001, rw)]
    mode: u8,
}

fn main() {
    Device::<Power>::default();
    Device::<Mode>::default();
}
