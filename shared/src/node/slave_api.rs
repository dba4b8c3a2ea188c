//! Events between a slave and its application.

use async_canopen::node::extend::SlaveEvents;
use thiserror::Error;

use super::events::role_events;
use crate::link::Stamp;
use crate::link::port::Health;
use crate::nmt::Command;
use crate::redundancy::BusCause;
use crate::types::{Bus, CobId, NmtState, NodeId};

role_events! {
    /// Event that a slave reports to its application.
    SlaveEvent {
        /// The bus considered active was confirmed or changed. Nothing to do.
        ActiveBus {
            /// Bus that the slave considers active now.
            bus: Bus,
            /// Reason for the choice of the bus.
            cause: BusCause,
        },
        /// The master is missed on the active bus. The slave searches it.
        ///
        /// To do: go into a state that needs no commands, if there is one.
        MasterMissed {
            /// The active bus.
            bus: Bus,
        },
        /// The search ended without the master after Ntoggle switches. The node stays on this bus and listens.
        ///
        /// To do: go into a state that needs no commands, if there is one.
        GaveUp {
            /// Bus on which the node stays.
            bus: Bus,
        },
        /// A monitored peer (1016h) reported its first NMT state, or a new one.
        ///
        /// To do: use or ignore its values by its state.
        PeerState {
            /// Node-ID of the peer.
            node: NodeId,
            /// NMT state of the peer.
            state: NmtState,
        },
        /// A heartbeat of another slave that 1016h names is overdue.
        ///
        /// To do: do without its values.
        PeerMissed {
            /// Node-ID of the peer.
            node: NodeId,
        },
        /// A heartbeat of the master arrived. Nothing to do.
        Heartbeat {
            /// Bus on which it arrived.
            bus: Bus,
        },
        /// A SYNC arrived on the active bus.
        ///
        /// To do: sample, if the application samples at SYNC.
        Sync {
            /// The active bus.
            bus: Bus,
            /// End of the SYNC.
            stamp: Stamp,
        },
        /// Another node sends heartbeats with this Node-ID (EMCY 8150h). The node that booted last yields: it is in
        /// Stopped and silent until the other one is silent.
        ///
        /// To do: log it. One of the two boards has wrong straps or a wrong stored Node-ID.
        Clash {
            /// Bus on which it was heard.
            bus: Bus,
            /// `true`: this node yields.
            yields: bool,
        },
        /// The other node with this Node-ID is silent. Nothing to do.
        ClashOver,
        /// A reset was ignored: it is the fourth in a row since the last heartbeat of the master. Those that follow
        /// are ignored, too. Reported once, with EMCY 8100h and the command. Resets are obeyed again after a
        /// heartbeat of the master, or after two consumer times without a reset.
        ///
        /// To do: log it. A node other than the master may be sending resets.
        ResetIgnored {
            /// Bus on which it arrived.
            bus: Bus,
            /// Command that was ignored: "reset node" or "reset communication".
            command: Command,
        },
        /// The slave tried to keep a new Bdefault beyond power-off.
        ///
        /// To do: log it if it was not kept. After power-off the slave begins on its old Bdefault.
        BdefaultNoted {
            /// Bus on which the master was found.
            bus: Bus,
            /// `true`: the parameter store holds it. `false`: eight were kept since power-on, the rest of the room is
            /// reserved for "save", or the store failed.
            is_kept: bool,
        },
    }
}

impl SlaveEvents for SlaveEvent {
    fn state(state: NmtState) -> Self {
        SlaveEvent::State(state)
    }

    fn peer_state(node: NodeId, state: NmtState) -> Self {
        SlaveEvent::PeerState { node, state }
    }

    fn peer_missed(node: NodeId) -> Self {
        SlaveEvent::PeerMissed { node }
    }

    fn sync(bus: Bus, stamp: Stamp) -> Self {
        SlaveEvent::Sync { bus, stamp }
    }

    fn not_sent(bus: Bus, id: CobId, data: [u8; 8]) -> Self {
        SlaveEvent::NotSent { bus, id, data }
    }

    fn health(bus: Bus, health: Health) -> Self {
        SlaveEvent::Health { bus, health }
    }

    fn bus_stalled(bus: Bus) -> Self {
        SlaveEvent::BusStalled { bus }
    }

    fn bus_failed(bus: Bus) -> Self {
        SlaveEvent::BusFailed { bus }
    }

    fn reset_node() -> Self {
        SlaveEvent::ResetNode
    }
}

/// Error: a node with parallel access cannot choose its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the master chooses the bus of a node with parallel access")]
pub struct ParallelAccess;
