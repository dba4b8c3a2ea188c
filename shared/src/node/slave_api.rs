//! Events between a slave and its application.

use thiserror::Error;

use crate::link::Stamp;
use crate::link::port::Health;
use crate::nmt::Command;
use crate::pdo::{ReceivedPdo, SetRpdo};
use crate::redundancy::BusCause;
use crate::time::Step;
use crate::types::{Address, Bus, CobId, NmtState, NodeId, Scet};

/// Event that a slave reports to its application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum SlaveEvent {
    /// The NMT state changed.
    State(NmtState),
    /// The bus considered active was confirmed or changed.
    ActiveBus {
        /// Bus that the slave considers active now.
        bus: Bus,
        /// Reason for the choice of the bus.
        cause: BusCause,
    },
    /// The master is missed on the active bus.
    MasterMissed {
        /// The active bus.
        bus: Bus,
    },
    /// The search ended without the master after Ntoggle switches. The node stays on this bus and listens.
    GaveUp {
        /// Bus on which the node stays.
        bus: Bus,
    },
    /// A receive PDO took effect. [`ReceivedPdo::get`] returns its values, if it is the PDO that you name.
    Pdo(ReceivedPdo),
    /// A synchronous receive PDO took effect, at a SYNC. [`SetRpdo::is`] compares it with the PDO that you name.
    Synchronised(SetRpdo),
    /// A frame was not sent, and none replaces it: that of a transmit PDO which is sent on events alone, without
    /// an event timer, and is no [state](crate::pdo::Tpdo::state).
    NotSent {
        /// Bus for which it was meant.
        bus: Bus,
        /// COB-ID of the frame.
        id: CobId,
        /// Payload of the frame, zero above its length.
        data: [u8; 8],
    },
    /// A client wrote an object of the application by SDO.
    Written(Address),
    /// Start the self-test (ECSS 6.7b), and write its result to object 2031h.
    SelfTest,
    /// A monitored peer (1016h) reported its first NMT state, or a new one.
    PeerState {
        /// Node-ID of the peer.
        node: NodeId,
        /// NMT state of the peer.
        state: NmtState,
    },
    /// A heartbeat of another slave that 1016h names is overdue.
    PeerMissed {
        /// Node-ID of the peer.
        node: NodeId,
    },
    /// A heartbeat of the master arrived.
    Heartbeat {
        /// Bus on which it arrived.
        bus: Bus,
    },
    /// A SYNC arrived on the active bus.
    Sync {
        /// The active bus.
        bus: Bus,
        /// End of the SYNC.
        stamp: Stamp,
    },
    /// A spacecraft time arrived, and the clock follows it.
    Time(Scet),
    /// The clock was set instead of steered: by command, for the first time, or because it was too far off.
    Step(Step),
    /// The error state of a controller changed.
    Health {
        /// Bus of the controller.
        bus: Bus,
        /// Present error state and error counters.
        health: Health,
    },
    /// A controller does not join or leave its bus: it is defective, or the bus is dominant all the time. It goes
    /// on trying.
    BusStalled {
        /// Bus of the controller.
        bus: Bus,
    },
    /// A controller went bus-off too often. It tries again when its window ends.
    BusFailed {
        /// Bus of the controller.
        bus: Bus,
    },
    /// Another node sends heartbeats with this Node-ID (EMCY 8150h). The node that booted last yields: it is in
    /// Stopped and silent until the other one is silent.
    Clash {
        /// Bus on which it was heard.
        bus: Bus,
        /// `true`: this node yields.
        yields: bool,
    },
    /// The other node with this Node-ID is silent.
    ClashOver,
    /// A reset was ignored: it is the fourth in a row since the last heartbeat of the master. Those that follow
    /// are ignored, too. Reported once, with EMCY 8100h and the command. Resets are obeyed again after a
    /// heartbeat of the master, or after two consumer times without a reset.
    ResetIgnored {
        /// Bus on which it arrived.
        bus: Bus,
        /// Command that was ignored: "reset node" or "reset communication".
        command: Command,
    },
    /// The slave tried to keep a new Bdefault beyond power-off.
    BdefaultNoted {
        /// Bus on which the master was found.
        bus: Bus,
        /// `true`: the parameter store holds it. `false`: eight were kept since power-on, the rest of the room is
        /// reserved for "save", or the store failed.
        is_kept: bool,
    },
    /// This node sends too many frames: a frame with this COB-ID was refused, with EMCY 8100h and object 2047h.
    /// Reported once until no frame was refused for a second. Above the budget of the node, it enters
    /// Pre-operational, sends no PDO for the time in its [profile](crate::profile::Profile::budget), and then
    /// boots up.
    OverBudget {
        /// COB-ID of the refused frame.
        id: CobId,
    },
    /// Reset the chip. The node is silent until then, and reports this event again for each frame that it
    /// receives.
    ResetNode,
}

/// Error: a node with parallel access cannot choose its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the master chooses the bus of a node with parallel access")]
pub struct ParallelAccess;
