//! Values of an enumeration that it does not have, and an enum that is none.

use ecss_can::od::{Enumeration, Field, Objects};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum Mode {
    #[default]
    Off,
    On,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
enum Underived {
    #[default]
    Off,
    On,
}

#[derive(Objects)]
struct Heater {
    /// Default of another type
    #[object(0x6000, rw, default = 1)]
    number: Mode,
    /// Default that is no variant
    #[object(0x6001, rw, default = Mode::Auto)]
    unknown: Mode,
    /// Limit that is no value of the type
    #[object(0x6002, rw, high = 256)]
    limit: Mode,
}

#[derive(Objects)]
struct Valve {
    /// No enumeration
    #[object(0x6000, rw)]
    mode: Underived,
}

const NUMBER: Field<u8> = Heater::NUMBER;

fn main() {}
