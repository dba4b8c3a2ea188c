//! Phases of a node, as far as the wires show them.

use can_wire::time::Time;

use super::meaning::NmtState;
use super::record::Bus;

/// State of a node, as far as the wires show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Phase {
    /// No power.
    Off,
    /// Powered, nothing heard of it yet.
    Starting,
    /// Powered and silent, while another master board is active.
    Standby,
    /// Operational when it was last heard, and without a heartbeat for several of its own periods since.
    Silent,
    /// In this NMT state.
    Nmt(NmtState),
}

impl Phase {
    /// Returns whether the node has power.
    pub fn is_powered(self) -> bool {
        self != Phase::Off
    }

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Off => "off",
            Phase::Starting => "starting",
            Phase::Standby => "standby",
            Phase::Silent => "silent",
            Phase::Nmt(state) => state.name(),
        }
    }
}

/// A node's phase and bus from an instant on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// Begin of the span.
    pub from: Time,
    /// Phase of the node.
    pub phase: Phase,
    /// Bus on which it works.
    pub bus: Bus,
}
