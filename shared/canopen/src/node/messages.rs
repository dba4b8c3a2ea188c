//! What passes between a node and its buses: reports of a bus, and commands to it.

use crate::link::Stamp;
use crate::link::depth::Places;
use crate::link::port::{Filter, Health};
use crate::link::queue::Outgoing;
use crate::types::Frame;

/// Depth of the queues of a node with the whole protocol: commands in its outbox, frames in the transmit queue of
/// a bus, events that wait for the application.
pub const QUEUE_DEPTH: usize = 32;
/// [Depth](crate::link::depth::Depth) of a node with the whole protocol.
pub type FullDepth = Places<QUEUE_DEPTH>;
/// Greatest number of acceptance filters that a node asks a port for. A node keeps one bit of a word for each.
pub const MAX_FILTERS: usize = u32::BITS as usize;

/// Acceptance filters of a node. A full list may lack some. Then its port admits every frame.
pub type Filters = heapless::Vec<Filter, MAX_FILTERS>;

/// Report of a bus to its node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum LinkEvent {
    /// A frame passed the filters.
    Received {
        /// Received frame, with its data.
        frame: Frame,
        /// End of the frame on the clock of the node.
        stamp: Stamp,
    },
    /// A frame of this node was acknowledged.
    Transmitted {
        /// Frame that was sent.
        frame: Frame,
        /// End of the frame on the clock of the node.
        stamp: Stamp,
    },
    /// A frame of this node was not sent.
    Failed {
        /// Frame that was not sent.
        frame: Frame,
        /// Reason why it was not sent.
        cause: FailCause,
    },
    /// Frames of this node were dropped before they reached the bus: the outbox was full.
    Unsent {
        /// Number of frames since the last report.
        frames: u16,
    },
    /// Received frames were lost before the node could see them.
    Overrun {
        /// Least number of frames since the last report.
        lost: u16,
    },
    /// The error state of the controller changed.
    Health(Health),
    /// The error counters of the controller moved since the last report. Reported before the next event of the
    /// controller.
    Counters(Health),
    /// The controller does not join or leave the bus: it is defective, or the bus is dominant all the time.
    Stalled,
}

/// Reason why a frame was not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FailCause {
    /// The node left the bus while the frame was pending.
    BusLeft,
    /// The lifetime of the frame ended.
    Expired,
    /// The transmit queue was full, or a frame that the network depends on displaced this one.
    QueueFull,
    /// The controller aborted the frame by itself (bus-off, reset).
    Aborted,
    /// The node sends too many frames: its [budget](crate::link::budget) is spent.
    OverBudget,
}

/// Command of a node to a bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum BusCommand {
    /// Send a frame.
    Send(Outgoing),
    /// Abort everything pending, in queue and mailboxes, and stay on the bus (parallel access).
    Abandon,
    /// Take part in the bus.
    Join,
    /// Abort everything pending and listen: receive, but drive no dominant bit, not even an acknowledgement.
    Listen,
    /// Abort everything pending and leave the bus, silent (selective access).
    Leave,
    /// Begin recovery from bus-off.
    Recover,
    /// Admit other frames by one of the filters set at the start.
    Filter {
        /// Number of the filter.
        number: u8,
        /// Frames that the filter admits from now on.
        filter: Filter,
    },
}
