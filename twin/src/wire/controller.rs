//! Interface between a wire and a CAN controller.

pub use crate::wire::confinement::ErrorCounters;
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;
use crate::wire::timing::BitTiming;

/// Index of a controller on one wire, in the order of attachment.
pub type NodeIndex = usize;

/// A CAN controller on a wire: registers, mailboxes and modes. The wire implements bit timing, the protocol engine and
/// the error counters. It calls the controller only inside [`Wire::advance`](crate::wire::bus::Wire::advance).
pub trait Controller {
    /// Returns how this controller takes part; `None` while it does not (initialisation, sleep, reset, no power) and
    /// neither sends, receives nor acknowledges. Its error counters are kept until [`Attachment::power_cycle`] changes.
    fn attachment(&self) -> Option<Attachment>;

    /// Returns the error counters with which the controller begins to take part. `None`: it has none of its own, and those of this wire
    /// apply.
    fn brings(&self) -> Option<ErrorCounters> {
        None
    }

    /// Returns the earliest instant from which a frame waits for transmission: its request, or the end of a delay such
    /// as joining the bus. `None` if no frame waits.
    fn request_at(&self) -> Option<Time>;

    /// Returns the frame that this controller would send in an arbitration at `at`, of those requested by then.
    fn contend(&self, at: Time) -> Option<WireFrame>;

    /// Handles an event of the wire at `at`.
    fn on_wire(&mut self, at: Time, event: &WireEvent);

    /// Returns whether the wire has to call [`Controller::on_line`].
    fn watches_line(&self) -> bool {
        false
    }

    /// Handles level changes at the RX pin at these instants, in order; `true` is recessive.
    fn on_line(&mut self, _changes: &[(Time, bool)]) {}
}

/// How a controller takes part in its bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Attachment {
    /// Bit timing by its own clock.
    pub timing: BitTiming,
    /// Bus monitoring: receives, but drives nothing: no frame, no acknowledgement, no flag.
    pub silent: bool,
    /// When bus-off, recovers after 128 sequences of 11 recessive bits.
    pub recovers: bool,
    /// Number of the power cycle. After a change the error counters start from zero.
    pub power_cycle: u32,
    /// Instant since which it takes part. A past instant counts as now, a future one as the end of the advance.
    pub since: Time,
}

impl Attachment {
    /// Makes the attachment of a node that takes part fully and recovers from bus-off automatically.
    pub fn new(timing: BitTiming) -> Self {
        Attachment { timing, silent: false, recovers: true, power_cycle: 0, since: Time::ZERO }
    }
}

/// Event that a wire reports to a controller. Its instant is the end of the bit that caused it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WireEvent {
    /// It has seen 11 recessive bits and takes part from now on.
    Joined,
    /// It entered arbitration with the frame that [`Controller::contend`] gave.
    Started,
    /// It lost arbitration and is a receiver now.
    ArbitrationLost,
    /// Its frame was acknowledged and completed (last bit of EOF).
    Transmitted,
    /// A frame from another node is valid (last but one bit of EOF).
    Received(WireFrame),
    /// Its transmission ended with an error.
    TransmitError(ErrorKind),
    /// It saw an error while it was not transmitting a frame: as a receiver, or within an error or overload frame.
    ReceiveError(ErrorKind),
    /// Its error counters changed; reported after the event that changed them. Leaving bus-off sets both to zero.
    Counters(ErrorCounters),
}

/// Cause of an error, as in the LEC field of bxCAN.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ErrorKind {
    /// More than five equal bits in a row.
    Stuff,
    /// A fixed-form bit had the wrong level.
    Form,
    /// No node acknowledged.
    Ack,
    /// Sent recessive, saw dominant, outside arbitration and ACK slot.
    BitRecessive,
    /// Sent dominant, saw recessive.
    BitDominant,
    /// Checksum mismatch.
    Crc,
}

/// One frame on the wire with its timing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Trace {
    /// The frame.
    pub frame: WireFrame,
    /// Node that sent it.
    pub transmitter: NodeIndex,
    /// Falling edge of SOF at the transmitter.
    pub start: Time,
    /// End of the last bit of EOF: `start` and the frame's bits by the transmitter's clock. A resynchronisation of the
    /// transmitter to the acknowledgement is not included: the instant results from counting bits from an edge of the
    /// frame.
    pub end: Time,
    /// Bit time of the transmitter.
    pub bit_time: Time,
}

/// The controllers of one wire, by index of attachment.
pub trait Controllers {
    /// Calls `visit` once with the controller that was attached as `node`.
    fn visit(&mut self, node: NodeIndex, visit: &mut dyn FnMut(&mut dyn Controller));

    /// Returns whether since the last call any controller changed how it takes part, whether it watches its line, or
    /// its waiting frame, for other reasons than frame events of the wire. With `false` the wire does not query all
    /// controllers.
    fn have_changed(&mut self) -> bool {
        true
    }
}

impl dyn Controllers + '_ {
    /// Returns the result of `work` on the controller that was attached as `node`.
    ///
    /// # Panics
    /// When [`Controllers::visit`] lends no controller.
    pub(in crate::wire) fn with<R>(
        &mut self,
        node: NodeIndex,
        work: impl FnOnce(&mut dyn Controller) -> R,
    ) -> R {
        let (mut work, mut result) = (Some(work), None);
        self.visit(node, &mut |controller| result = work.take().map(|work| work(controller)));
        result.expect("a controller for every node")
    }
}
