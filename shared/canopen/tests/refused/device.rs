//! A device is of `ecss-can`. The rest of the declaration is usable: there is one error.

use async_canopen::od::Objects;
use async_canopen::pdo::{CobIdOf, Tpdo};

/// A heater.
#[derive(Objects)]
#[objects(device)]
struct Heater {
    /// Power
    #[object(0x6000, ro, pdo)]
    power: u8,
}

const POWER: Tpdo = Tpdo::new(2, CobIdOf::node(0x280)).map(Heater::POWER);

fn main() {
    _ = (POWER, Heater::default().power);
}
