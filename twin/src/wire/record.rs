//! Records for observers of a wire.

use crate::wire::controller::{ErrorKind, NodeIndex, Trace};
use crate::wire::fault::Fault;
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;

/// One event on a wire.
#[derive(Clone, Debug, PartialEq)]
pub enum Observation {
    /// A frame was acknowledged and completed.
    Completed {
        /// The frame.
        trace: Trace,
        /// Nodes that received it, and when it was valid there (last but one bit of EOF), in chronological order.
        receivers: Vec<(NodeIndex, Time)>,
        /// Piece of the cable, counted from the left; 0 on an uncut one.
        segment: usize,
    },
    /// A transmission ended without success.
    Destroyed {
        /// Frame that was being sent.
        frame: WireFrame,
        /// Node that sent it.
        transmitter: NodeIndex,
        /// Falling edge of SOF at the transmitter.
        start: Time,
        /// End of the transmission.
        at: Time,
        /// Cause.
        cause: Destruction,
        /// Nodes that received it before that, because the error reached them after it was valid: they will receive it
        /// twice. [`Observation::ReceivedLate`] reports nodes that received it later.
        receivers: Vec<(NodeIndex, Time)>,
        /// Piece of the cable, counted from the left; 0 on an uncut one.
        segment: usize,
    },
    /// A node received a frame after its transmission had ended without success: the error had not yet reached the node when
    /// the frame was valid there.
    ReceivedLate {
        /// Instant at which it was valid.
        at: Time,
        /// Node that received it.
        node: NodeIndex,
        /// The frame.
        frame: WireFrame,
        /// Node that sent it.
        transmitter: NodeIndex,
        /// Falling edge of SOF at the transmitter.
        start: Time,
    },
    /// A node received a frame that was not sent: no check detected the error.
    Misread {
        /// Instant at which it was valid.
        at: Time,
        /// Node that received it.
        node: NodeIndex,
        /// Frame that was received.
        frame: WireFrame,
    },
    /// A node saw an error.
    Error {
        /// End of the bit in which it was detected.
        at: Time,
        /// Node that detected it.
        node: NodeIndex,
        /// Kind of the error.
        kind: ErrorKind,
        /// Whether the node was transmitting a frame.
        transmitting: bool,
    },
    /// A fault began or ended.
    Fault {
        /// Instant of the fault.
        at: Time,
        /// The fault.
        fault: Fault,
    },
}

/// Reason why a transmission ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Destruction {
    /// The transmitter detected an error; [`ErrorKind::Ack`] if no node acknowledged.
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
    /// Transmissions without acknowledgement.
    pub ack_errors: u64,
    /// Time spent on frames and error frames, each with its intermission; over the time elapsed it is the bus load.
    /// The pieces of a cut cable add up.
    pub busy: Time,
}

impl Observation {
    /// Returns the end of the event.
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
