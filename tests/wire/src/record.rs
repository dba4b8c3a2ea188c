//! What an observer of a wire gets to know.

use std::sync::Arc;

use crate::controller::{NodeIndex, Trace};
use crate::fault::Fault;
use crate::frame::WireFrame;
use crate::time::Time;

/// One thing that happened, in the order of time.
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// A frame was acknowledged and completed.
    Completed {
        /// The frame.
        trace: Arc<Trace>,
        /// Who received it, and when it was valid there (last but one bit of EOF), in the order of time.
        receivers: Vec<(NodeIndex, Time)>,
        /// Piece of the cable, counted from the left; 0 on an uncut one.
        segment: usize,
    },
    /// A transmission ended without a valid frame.
    Destroyed {
        /// What was being sent.
        frame: WireFrame,
        /// Who sent it.
        transmitter: NodeIndex,
        /// Falling edge of SOF at the transmitter.
        start: Time,
        /// When it ended.
        at: Time,
        /// Why.
        cause: Destruction,
        /// Piece of the cable, counted from the left; 0 on an uncut one.
        segment: usize,
    },
    /// The cable broke or healed.
    Fault {
        /// When.
        at: Time,
        /// What.
        fault: Fault,
    },
}

/// Why a transmission ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Destruction {
    /// Nobody acknowledged.
    Unacknowledged,
    /// Two transmitters with equal arbitration fields, or with different bit times.
    Collision,
    /// The transmitter left the bus.
    TransmitterLeft,
    /// A cut healed while both sides were busy.
    Merged,
}

/// Totals since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Frames acknowledged and completed.
    pub completed: u64,
    /// Frames that ended early for any reason but a missing acknowledgement.
    pub destroyed: u64,
    /// Frames that nobody acknowledged.
    pub ack_errors: u64,
    /// Time spent on frames and error frames, each with its intermission; over the time elapsed it is the bus load.
    /// The pieces of a cut cable add up.
    pub busy: Time,
}
