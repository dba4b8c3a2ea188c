//! What a slave and its application tell each other.

use crate::link::Bus;
use crate::link::port::Health;
use crate::nmt::NmtState;
use crate::pdo::Message;
#[cfg(doc)]
use crate::runner::AppLink;
use crate::time::{Scet, Stamp};

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
    /// Execute a telecommand.
    Command {
        /// Where it came.
        bus: Bus,
        /// The command.
        message: Message,
    },
    /// Answer with [`SlaveRequest::Telemetry`]; [`AppLink::status`] is this node when it was asked, or later.
    TelemetryRequested {
        /// Where to answer.
        bus: Bus,
        /// The request.
        request: Message,
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
    /// The clock was set to the spacecraft time.
    Time(Scet),
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
}

/// What the application may ask of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum SlaveRequest {
    /// Send telemetry; refused and counted when no longer operational, or when `bus` is no longer the active one.
    Telemetry {
        /// Where it was asked for.
        bus: Bus,
        /// The telemetry.
        message: Message,
    },
    /// Zero the counters of both buses.
    ResetCounters,
}
