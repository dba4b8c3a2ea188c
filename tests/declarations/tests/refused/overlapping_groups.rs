//! One index in two groups, and in a group and beside it.

use ecss_can::od::Objects;

#[derive(Objects)]
struct Device {
    #[objects]
    power: Power,
    #[objects]
    nested: Nested,
}

#[derive(Objects)]
struct Power {
    /// Voltage
    #[object(0x6000, ro)]
    voltage: u16,
}

#[derive(Objects)]
struct Nested {
    /// Mode
    #[object(0x6100, rw)]
    mode: u8,
    #[objects]
    thermal: Thermal,
}

#[derive(Objects)]
struct Thermal {
    /// Temperature
    #[object(0x6000, ro)]
    temperature: i16,
}

#[derive(Objects)]
struct Beside {
    #[objects]
    thermal: Thermal,
    /// Temperature once more
    #[object(0x6000, ro)]
    temperature: i16,
}

/// A parameter has its default where the declaration is checked.
#[derive(Objects)]
struct Generic<G: Objects + Default = Power> {
    #[objects]
    group: G,
    #[objects]
    thermal: Thermal,
}

fn main() {}
