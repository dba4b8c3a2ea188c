//! Which controller of a board hangs on which bus.

use std::fmt;

use crate::bxcan::Side;

/// A bus. Most spacecraft have two; the others are for boards that are wired in another way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Bus {
    /// CAN1 of every board, unless its wiring says otherwise.
    Nominal,
    /// CAN2 of every board, unless its wiring says otherwise.
    Redundant,
    /// No board is on it, unless its wiring says so.
    Third,
    /// No board is on it, unless its wiring says so.
    Fourth,
}

impl Bus {
    /// The two of a spacecraft, nominal first.
    pub const ALL: [Bus; 2] = [Bus::Nominal, Bus::Redundant];
    /// Every bus that a wiring may name.
    pub const NETWORKS: [Bus; Bus::COUNT] = [Bus::Nominal, Bus::Redundant, Bus::Third, Bus::Fourth];
    /// Number of buses.
    pub const COUNT: usize = 4;

    /// Its name in logs, pictures and on the screen; a valid interface name.
    pub const fn name(self) -> &'static str {
        match self {
            Bus::Nominal => "nominal",
            Bus::Redundant => "redundant",
            Bus::Third => "third",
            Bus::Fourth => "fourth",
        }
    }

    /// The other one of its pair.
    pub const fn other(self) -> Bus {
        match self {
            Bus::Nominal => Bus::Redundant,
            Bus::Redundant => Bus::Nominal,
            Bus::Third => Bus::Fourth,
            Bus::Fourth => Bus::Third,
        }
    }
}

impl fmt::Display for Bus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The buses behind the transceivers of a board; `None`: the transceiver's cable hangs loose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Wiring {
    /// Bus of CAN1.
    pub can1: Option<Bus>,
    /// Bus of CAN2. It may be that of CAN1.
    pub can2: Option<Bus>,
}

impl Default for Wiring {
    /// The two buses of a spacecraft.
    fn default() -> Self {
        Wiring { can1: Some(Bus::Nominal), can2: Some(Bus::Redundant) }
    }
}

impl Wiring {
    /// Each controller that is on a bus, CAN1 first.
    pub(crate) fn ports(self) -> impl Iterator<Item = (Side, Bus)> {
        let of = |side, bus: Option<Bus>| bus.map(|bus| (side, bus));
        [of(Side::Can1, self.can1), of(Side::Can2, self.can2)].into_iter().flatten()
    }
}
