//! Actions of the manager, and its reasons to change the bus.

use crate::types::{Bus, Frame, NodeId};

/// Reason why the master left a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SwitchCause {
    /// Its controller went bus-off too often on this bus.
    BusOff,
    /// No node acknowledges on this bus any more.
    Isolated,
    /// Too many slaves became silent on this bus.
    SlavesSilent,
    /// No slave was heard on either bus for a dwell.
    Unheard,
    /// Some slaves are silent on this bus and heard on the other one, which is tried.
    Tried,
    /// The bus was tried, and fewer slaves are heard on it than on the one before.
    TriedInVain,
    /// The application requested it, or a slave babbled on this bus after it was reset.
    Commanded,
}

/// Action that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Action {
    /// Send this heartbeat on this bus.
    Heartbeat {
        /// The active bus.
        bus: Bus,
        /// Heartbeat of the master, 701h.
        frame: Frame,
    },
    /// The active bus changed. The next action is the heartbeat on it. Nothing else may be sent on it before.
    Switched {
        /// Bus that was left. Everything that waits for it is aborted.
        from: Bus,
        /// Bus that is active now.
        to: Bus,
        /// Reason for the change.
        cause: SwitchCause,
    },
    /// This node sent no heartbeat on either bus for the consumer time.
    Lost(NodeId),
    /// This node does not count as a slave and was silent for ten consumer times. The manager has forgotten it.
    Forgotten(NodeId),
    /// This slave is assigned and was not heard on either bus in the first two dwells after power-on.
    Unheard(NodeId),
    /// No slave was heard on either bus in Ntoggle changes of the bus. The manager stays until it hears one.
    GaveUp {
        /// Bus on which it stays.
        bus: Bus,
    },
}
