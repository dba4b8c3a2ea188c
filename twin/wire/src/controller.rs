//! What a wire asks of a CAN controller, and what it tells it.

pub use crate::confinement::ErrorCounters;
use crate::frame::WireFrame;
use crate::time::Time;
use crate::timing::BitTiming;

/// Index of a controller on one wire, in the order of attachment.
pub type NodeIndex = usize;

/// A CAN controller as the wire sees it: registers, mailboxes and modes. Bit timing, the protocol engine and the error
/// counters behind it are the wire's. The wire calls it only inside [`Wire::advance`](crate::wire::Wire::advance).
pub trait Controller {
    /// How this controller takes part; `None` while it does not (initialisation, sleep, reset, no power): it then
    /// neither sends, receives nor acknowledges. Its error counters stay until [`Attachment::power_cycle`] changes.
    fn attachment(&self) -> Option<Attachment>;

    /// Error counters that it brings along from another wire when it begins to take part; `None`: it has no other, and those
    /// that the wire knows go on.
    fn brings(&self) -> Option<ErrorCounters> {
        None
    }

    /// Earliest instant from which a frame waits for transmission (its request, or the end of a refusal such as
    /// joining the bus); `None` when nothing waits.
    fn request_at(&self) -> Option<Time>;

    /// The frame this controller would send if an arbitration began at `at`; only what was requested by then.
    fn contend(&self, at: Time) -> Option<WireFrame>;

    /// Something happened on the wire at `at`.
    fn on_wire(&mut self, at: Time, event: &WireEvent);

    /// Wants [`Controller::on_line`].
    fn watches_line(&self) -> bool {
        false
    }

    /// The level at the RX pin changed at these instants, in order; `true` is recessive.
    fn on_line(&mut self, _changes: &[(Time, bool)]) {}
}

/// How a controller takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Attachment {
    /// Its bits, by its own clock.
    pub timing: BitTiming,
    /// Bus monitoring: receives, but drives nothing: no frame, no acknowledgement, no flag.
    pub silent: bool,
    /// When bus-off, counts 128 sequences of 11 recessive bits and comes back.
    pub recovers: bool,
    /// Another number than before: the error counters start from zero.
    pub power_cycle: u32,
    /// Since when it takes part; the past counts as now, and what lies ahead as the end of the advance.
    pub since: Time,
}

impl Attachment {
    /// A node that takes part in everything and leaves bus-off by itself.
    pub fn new(timing: BitTiming) -> Self {
        Attachment { timing, silent: false, recovers: true, power_cycle: 0, since: Time::ZERO }
    }
}

/// What a wire tells a controller. Instants are the end of the bit that decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WireEvent {
    /// 11 recessive bits were seen: it takes part from now on.
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
    /// Its error counters changed; told after what changed them. Leaving bus-off sets both to zero.
    Counters(ErrorCounters),
}

/// Cause of an error, as in the LEC field of bxCAN.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Trace {
    /// The frame.
    pub frame: WireFrame,
    /// Who sent it.
    pub transmitter: NodeIndex,
    /// Falling edge of SOF at the transmitter.
    pub start: Time,
    /// End of the last bit of EOF: `start` and the frame's bits by the transmitter's clock. A resynchronisation of the
    /// transmitter to the acknowledgement does not count: whoever counts bits from an edge of the frame gets here.
    pub end: Time,
    /// Bit time of the transmitter.
    pub bit_time: Time,
}

/// The controllers of one wire, by index of attachment.
pub trait Controllers {
    /// Lends the controller that was attached as `node` to `visit`, once.
    fn visit(&mut self, node: NodeIndex, visit: &mut dyn FnMut(&mut dyn Controller));

    /// Whether a controller takes part in another way, watches its line or not, or has another frame waiting than when this was asked
    /// last, for another reason than what the wire told it about a frame. `false` saves the wire from asking all of them.
    fn have_changed(&mut self) -> bool {
        true
    }
}

impl dyn Controllers + '_ {
    /// Returns the result of `work` on the controller that was attached as `node`.
    ///
    /// # Panics
    /// When [`Controllers::visit`] lends no controller.
    pub(crate) fn with<R>(&mut self, node: NodeIndex, work: impl FnOnce(&mut dyn Controller) -> R) -> R {
        let (mut work, mut result) = (Some(work), None);
        self.visit(node, &mut |controller| result = work.take().map(|work| work(controller)));
        result.expect("a controller for every node")
    }
}
