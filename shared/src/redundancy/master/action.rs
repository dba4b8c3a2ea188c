//! Actions of the redundancy of a master.

use crate::link::machine::Outgoing;
use crate::redundancy::{RoleChange, SwitchCause};
use crate::types::{Bus, Frame, Instant, NodeId};

/// Action that a master has to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MasterAction {
    /// Send this heartbeat.
    Heartbeat {
        /// The active bus.
        bus: Bus,
        /// Heartbeat of the master, 701h.
        frame: Frame,
        /// End of its lifetime.
        expires: Instant,
    },
    /// Send a claim, or a frame that waited for the announcement of the bus.
    Send {
        /// Bus to send it on.
        bus: Bus,
        /// Frame, with the end of its lifetime.
        outgoing: Outgoing,
    },
    /// Sample the spacecraft time and send it: it became due before the active bus was announced.
    SendTime,
    /// The lifetime of a frame ended before its bus was announced.
    Expired {
        /// Bus that the frame waited for.
        bus: Bus,
        /// The frame. It is never sent.
        frame: Frame,
    },
    /// The bus was left before it was announced, or the master became the standby.
    Left {
        /// Bus that the frame waited for.
        bus: Bus,
        /// The frame. It is never sent.
        frame: Frame,
    },
    /// A frame for this bus is not sent: too many wait for its announcement.
    Refused(Bus),
    /// The active bus changed. Abort what is pending on the bus that was left, then report the health of both
    /// buses ([`MasterRedundancy::on_health`](super::MasterRedundancy::on_health)).
    Switched {
        /// Bus that was left.
        from: Bus,
        /// Bus that is active now.
        to: Bus,
        /// Reason for the change.
        cause: SwitchCause,
    },
    /// This node sent no heartbeat on either bus for its consumer time.
    Lost(NodeId),
    /// This node does not count as a slave and was silent for ten consumer times.
    Forgotten(NodeId),
    /// This slave is assigned and was not heard on either bus in the first two dwells after power-on.
    Unheard(NodeId),
    /// No slave was heard on either bus in Ntoggle changes of the bus. The master stays on this bus until it
    /// hears one.
    GaveUp(Bus),
    /// Another node began to send the heartbeat of the master on this bus.
    RivalHeard(Bus),
    /// No other node sends the heartbeat of the master on this bus any more.
    RivalSilent(Bus),
    /// This board becomes active on this bus. Join the buses and
    /// [boot up](super::MasterRedundancy::boot_up).
    TookOver {
        /// Bus that is active now.
        bus: Bus,
        /// New role of this board, and the reason for it.
        change: RoleChange,
    },
    /// This board was active and is the standby now. Listen on both buses, and abort what is pending.
    StoodBy {
        /// Bus that was active.
        bus: Bus,
        /// New role of this board, and the reason for it.
        change: RoleChange,
    },
    /// This board listened and is the standby now.
    HeardMaster(RoleChange),
}
