//! Phases of a node that can be observed on the wires.

use can_twin::wire::time::Time;

use super::meaning::NmtState;
use super::record::Bus;

/// State of a node as observed on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Phase {
    /// No power.
    Off,
    /// Powered, no frame received from it yet.
    Starting,
    /// Powered and silent, while another master board is active.
    Standby,
    /// Operational in its last heartbeat, and without a heartbeat for several of its own periods since.
    Silent,
    /// In this NMT state.
    Nmt(NmtState),
}

impl Phase {
    /// Returns whether the node has power.
    pub fn is_powered(self) -> bool {
        self != Phase::Off
    }

    /// Returns the name in texts.
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
