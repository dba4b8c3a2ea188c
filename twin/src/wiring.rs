//! Assignment of a board's controllers to buses.

use std::fmt;

use crate::bxcan::Side;

/// A bus. Most spacecraft have two; the others are for boards with other wiring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Bus {
    /// Bus of CAN1 by default.
    Nominal,
    /// Bus of CAN2 by default.
    Redundant,
    /// Used only by boards whose wiring names it.
    Third,
    /// Used only by boards whose wiring names it.
    Fourth,
}

impl Bus {
    /// The two buses of a spacecraft, nominal first.
    pub const ALL: [Bus; 2] = [Bus::Nominal, Bus::Redundant];
    /// Every bus that a wiring may name.
    pub const NETWORKS: [Bus; Bus::COUNT] = [Bus::Nominal, Bus::Redundant, Bus::Third, Bus::Fourth];
    /// Number of buses.
    pub const COUNT: usize = 4;

    /// Returns its name in logs, pictures and on the screen; a valid interface name.
    pub const fn name(self) -> &'static str {
        match self {
            Bus::Nominal => "nominal",
            Bus::Redundant => "redundant",
            Bus::Third => "third",
            Bus::Fourth => "fourth",
        }
    }

    /// Returns the other bus of its pair.
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

/// The buses behind the transceivers of a board; `None`: the transceiver is not connected.
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
