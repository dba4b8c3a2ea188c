//! What a wire asks of a CAN controller, and what it tells it.

use std::sync::Arc;

use crate::frame::WireFrame;
use crate::time::Time;

/// Index of a controller on one wire, in the order of attachment.
pub type NodeIndex = usize;

/// A CAN controller as the wire sees it. The wire calls it only inside [`Wire::advance`](crate::wire::Wire::advance).
pub trait Controller {
    /// Length of one bit by this controller's own clock and settings; `None` while it is off the bus (initialisation,
    /// sleep, reset, bus-off, no power): it then neither sends, receives nor acknowledges.
    fn bit_time(&self) -> Option<Time>;

    /// Silent (bus-monitoring) controllers receive but do not acknowledge.
    fn acknowledges(&self) -> bool {
        true
    }

    /// Error passive: waits 8 more bits after its own transmission (suspend), sends passive error flags.
    fn error_passive(&self) -> bool;

    /// Earliest instant from which a frame waits for transmission (its request, or the end of a refusal such as
    /// joining the bus); `None` when nothing waits.
    fn request_at(&self) -> Option<Time>;

    /// The frame this controller would send if an arbitration began at `at`; only what was requested by then.
    fn contend(&self, at: Time) -> Option<WireFrame>;

    /// Something happened on the wire at `at`.
    fn on_wire(&mut self, at: Time, event: &WireEvent);
}

/// What a wire tells a controller.
#[derive(Clone, Debug)]
pub enum WireEvent {
    /// This controller entered arbitration with the frame `contend` gave.
    Started,
    /// It lost arbitration and is a receiver now.
    ArbitrationLost,
    /// Its frame was acknowledged and completed (last bit of EOF).
    Transmitted(Arc<Trace>),
    /// A frame from another node is valid (last but one bit of EOF).
    Received(Arc<Trace>),
    /// It transmitted and saw an error.
    TransmitError(ErrorKind),
    /// It received and saw an error.
    ReceiveError(ErrorKind),
}

/// Cause of an error, as in the LEC field of bxCAN.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// More than five equal bits in a row.
    Stuff,
    /// A fixed-form bit had the wrong level.
    Form,
    /// Nobody acknowledged.
    Ack,
    /// Sent recessive, saw dominant, outside arbitration and ACK slot.
    BitRecessive,
    /// Sent dominant, saw recessive.
    BitDominant,
    /// Checksum mismatch.
    Crc,
}

/// One frame on the wire with its timing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trace {
    /// The frame.
    pub frame: WireFrame,
    /// Who sent it.
    pub transmitter: NodeIndex,
    /// Falling edge of SOF at the transmitter.
    pub start: Time,
    /// End of the last bit of EOF at the transmitter.
    pub end: Time,
    /// Bit time of the transmitter.
    pub bit_time: Time,
    /// Level changes at the transmitter, SOF first: the instant, and the level from then on (`true` = recessive).
    pub edges: Vec<(Time, bool)>,
}
