//! Enums that are no enumeration, and values of one that do not exist. Other uses of the enums are no further errors.

use ecss_can::od::{Enumeration, Objects};
use ecss_can::pdo::{CobIdOf, Pdo, Rpdo};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
enum WithoutRepr {
    #[default]
    Off,
    On,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u64)]
enum TooLarge {
    #[default]
    Off,
    On,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum WithFields {
    #[default]
    Off,
    Level(u8),
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum Generic<const N: u8> {
    #[default]
    Off,
    On,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
struct NoEnum;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum Twice {
    #[default]
    Off = 1,
    On = 1,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum WithoutDefault {
    Off,
    On,
}

#[derive(Debug, Default, PartialEq, Eq, Enumeration)]
#[repr(u8)]
enum NotCopied {
    #[default]
    Off,
    On,
}

#[derive(Objects)]
struct Heater {
    /// Without repr
    #[object(0x6000, rw, pdo)]
    without_repr: WithoutRepr,
    /// Too large
    #[object(0x6001, rw, pdo)]
    too_large: TooLarge,
    /// With fields
    #[object(0x6002, rw, pdo, default = WithFields::Level(1))]
    with_fields: WithFields,
    /// Generic
    #[object(0x6003, rw, pdo)]
    generic: Generic<2>,
    /// No enum
    #[object(0x6004, rw, pdo)]
    no_enum: NoEnum,
    /// Without default
    #[object(0x6005, rw, pdo, default = WithoutDefault::On)]
    without_default: WithoutDefault,
}

const COMMAND: Rpdo = Pdo::<()>::new(CobIdOf::node(0x200))
    .map(Heater::WITHOUT_REPR)
    .map(Heater::TOO_LARGE)
    .map(Heater::WITH_FIELDS)
    .map(Heater::GENERIC)
    .map(Heater::NO_ENUM)
    .receive(1);

fn main() {}
