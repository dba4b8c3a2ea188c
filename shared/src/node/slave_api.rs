//! What a slave and its application tell each other.

use crate::link::Stamp;
use crate::link::port::Health;
use crate::nmt::Command;
use crate::time::Step;
use crate::types::{Address, Bus, CobId, NmtState, NodeId, Scet};

/// What a slave tells its application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum SlaveEvent {
    /// Another NMT state.
    State(NmtState),
    /// The bus considered active was confirmed or changed.
    ActiveBus {
        /// Which it is now.
        bus: Bus,
        /// Why.
        cause: BusCause,
    },
    /// The master is missed on the active bus.
    MasterMissed {
        /// The active bus.
        bus: Bus,
    },
    /// Ntoggle switches in vain: the node stays on this bus and listens.
    GaveUp {
        /// Where it stays.
        bus: Bus,
    },
    /// A receive PDO took effect: its values are in the dictionary.
    Pdo {
        /// Where it came.
        bus: Bus,
        /// Which, 0 is the first.
        number: u16,
        /// Its payload, zero behind its end: the dictionary may hold a newer one already.
        data: [u8; 8],
    },
    /// A synchronous receive PDO took effect, at a SYNC.
    Synchronised {
        /// Which, 0 is the first.
        number: u16,
    },
    /// An object of the application was written by SDO.
    Written(Address),
    /// Start the self-test (ECSS 6.7b); its result goes to object 2031h.
    SelfTest,
    /// Another slave that 1016h names told a state for the first time, or another one.
    PeerState {
        /// Who.
        node: NodeId,
        /// Its state.
        state: NmtState,
    },
    /// A heartbeat of another slave that 1016h names is overdue.
    PeerMissed {
        /// Who.
        node: NodeId,
    },
    /// A heartbeat of the master.
    Heartbeat {
        /// Where.
        bus: Bus,
    },
    /// A SYNC on the active bus.
    Sync {
        /// The active bus.
        bus: Bus,
        /// Its end.
        stamp: Stamp,
    },
    /// A spacecraft time arrived, and the clock follows it.
    Time(Scet),
    /// The clock was set, instead of steered: by command, for the first time, or because it was too far off.
    Step(Step),
    /// The error state of a controller changed.
    Health {
        /// Which bus.
        bus: Bus,
        /// What it is now.
        health: Health,
    },
    /// A controller does not get on or off its bus: it is defective, or the bus is dominant all the time. It tries on.
    BusStalled {
        /// Which bus.
        bus: Bus,
    },
    /// A controller went bus-off too often; it is tried again when its window ends.
    BusFailed {
        /// Which bus.
        bus: Bus,
    },
    /// Another node sends heartbeats with this Node-ID (EMCY 8150h). The node that booted last yields: it is silent, in
    /// Stopped, until the other one is.
    Clash {
        /// Bus on which it was heard.
        bus: Bus,
        /// Whether this node yields.
        yields: bool,
    },
    /// The other node with this Node-ID is silent.
    ClashOver,
    /// A reset was ignored, and those that follow are too: the fourth in a row since the master was heard last. Sent once,
    /// with EMCY 8100h and the command; resets are obeyed again after a heartbeat of the master, or two consumer times
    /// without a reset.
    ResetIgnored {
        /// Bus on which it came.
        bus: Bus,
        /// Reset node or reset communication.
        command: Command,
    },
    /// A new Bdefault was to be kept beyond power-off.
    BdefaultNoted {
        /// Bus on which the master was found.
        bus: Bus,
        /// Whether the parameter store holds it now. If not: eight were kept since power-on, the rest of the room is for
        /// "save", or the store fails.
        is_kept: bool,
    },
    /// This node sends too much: a frame with this COB-ID was refused, with EMCY 8100h and object 2047h. Sent once until nothing
    /// was refused for a second. Above the budget of the node it enters Pre-operational, sends no PDO for the time in its
    /// [profile](crate::profile::Profile::budget), and boots up then.
    OverBudget {
        /// Of the frame.
        id: CobId,
    },
    /// Reset the chip. The node is silent until then and tells this again with every frame it receives.
    ResetNode,
}

/// Why a slave considers a bus the active one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BusCause {
    /// Power-on: it is the default (ECSS 8.3.2a).
    PowerOn,
    /// Searching: nothing was heard on the other one (ECSS 8.3.3e, h).
    Toggled,
    /// The master was heard there: the search ended (ECSS 8.3.3g, k).
    Found,
    /// The master changed to it (ECSS 8.3.3g).
    Followed,
    /// No heartbeat followed the command that was heard on the other one, or here: the search goes on.
    Unconfirmed,
    /// The master was still heard there after the node had followed a heartbeat on the other one (EMCY 8150h).
    TakenBack,
    /// The application chose it (ECSS 8.2.3a).
    Selected,
}

/// A node with parallel access cannot choose its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParallelAccess;
