//! What an observer of a wire gets to know.

use crate::controller::{ErrorKind, NodeIndex, Trace};
use crate::fault::Fault;
use crate::frame::WireFrame;
use crate::time::Time;

/// One thing that happened, in the order of time.
#[derive(Clone, Debug, PartialEq)]
pub enum Observation {
    /// A frame was acknowledged and completed.
    Completed {
        /// The frame.
        trace: Trace,
        /// Who received it, and when it was valid there (last but one bit of EOF), in the order of time.
        receivers: Vec<(NodeIndex, Time)>,
        /// Piece of the cable, counted from the left; 0 on an uncut one.
        segment: usize,
    },
    /// A transmission ended without success.
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
        /// Who received it before that, because the error came after it was valid there: they will receive it twice.
        /// [`Observation::ReceivedLate`] has those that received it later.
        receivers: Vec<(NodeIndex, Time)>,
        /// Piece of the cable, counted from the left; 0 on an uncut one.
        segment: usize,
    },
    /// A node received a frame after its transmission had ended without success: the error had not yet reached the node when
    /// the frame was valid there.
    ReceivedLate {
        /// When it was valid.
        at: Time,
        /// By whom.
        node: NodeIndex,
        /// The frame.
        frame: WireFrame,
        /// Who sent it.
        transmitter: NodeIndex,
        /// Falling edge of SOF at the transmitter.
        start: Time,
    },
    /// A node received a frame that nobody sent: an error that no check caught.
    Misread {
        /// When it was valid.
        at: Time,
        /// By whom.
        node: NodeIndex,
        /// What it received.
        frame: WireFrame,
    },
    /// A node saw an error.
    Error {
        /// End of the bit that showed it.
        at: Time,
        /// Who saw it.
        node: NodeIndex,
        /// What.
        kind: ErrorKind,
        /// It was transmitting a frame.
        transmitting: bool,
    },
    /// Something was done to the wire.
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
    /// The transmitter saw an error; [`ErrorKind::Ack`] when nobody acknowledged.
    Error(ErrorKind),
    /// The transmitter left the bus.
    TransmitterLeft,
}

/// Totals since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Frames acknowledged and completed.
    pub completed: u64,
    /// Transmissions that ended early for any reason but a missing acknowledgement.
    pub destroyed: u64,
    /// Transmissions that nobody acknowledged.
    pub ack_errors: u64,
    /// Time spent on frames and error frames, each with its intermission; over the time elapsed it is the bus load.
    /// The pieces of a cut cable add up.
    pub busy: Time,
}

impl Observation {
    /// When it was over.
    pub fn at(&self) -> Time {
        match self {
            Observation::Completed { trace, .. } => trace.end,
            Observation::Destroyed { at, .. }
            | Observation::ReceivedLate { at, .. }
            | Observation::Misread { at, .. }
            | Observation::Error { at, .. }
            | Observation::Fault { at, .. } => *at,
        }
    }
}
