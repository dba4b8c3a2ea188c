//! State of a node at one instant.

use crate::link::port::Health;
use crate::node::Counters;
use crate::redundancy::Parameters;
use crate::types::{Bus, Duration, NmtState, PerBus, Scet};

/// State of a node at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// Time since power-on.
    pub uptime: Duration,
    /// Local spacecraft time (object 2011h).
    pub scet: Scet,
    /// NMT state of the node.
    pub state: NmtState,
    /// Bus that the node considers active.
    pub active: Bus,
    /// Redundancy parameters (objects 1016h, 1017h, 2000h), with the present Bdefault and Ctoggle.
    pub redundancy: Parameters,
    /// Counters of the frames of each bus.
    pub counters: PerBus<Counters>,
    /// Error state and counters of each bus (objects 2020h, 2021h).
    pub health: PerBus<Health>,
}
