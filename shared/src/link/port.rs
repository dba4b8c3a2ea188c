//! What the protocol needs of a CAN controller.
//!
//! Implemented by `boards` on bxCAN and by the mocks of the host tests. One port serves one bus.

use core::future::poll_fn;
use core::task::{Context, Poll};

use crate::link::Stamp;
use crate::types::{CobId, Frame};

/// A transmit mailbox of a port: its number, from zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mailbox(pub u8);

/// All mailboxes that may take this frame now are in use; try again after the next transmit event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Busy;

/// A CAN controller on one bus.
///
/// A port starts *off the bus*: it neither sends, receives nor acknowledges until [`CanPort::join`].
#[allow(async_fn_in_trait)] // spawned on single-threaded executors only
pub trait CanPort {
    /// A value for each transmit mailbox: an array.
    type PerMailbox<T: Default>: AsRef<[T]> + AsMut<[T]> + Default;

    /// Acceptance filters that it has, 32 at most.
    const FILTERS: usize;

    /// Admit only these frames from now on, [`CanPort::FILTERS`] filters at most. Called once, off the bus.
    fn set_filters(&mut self, filters: &[Filter]);

    /// Admit other frames by one of these filters, on the bus or off it. Nothing happens for a number that was not set.
    fn set_filter(&mut self, number: u8, filter: Filter);

    /// Go on the bus; takes part after 11 recessive bits.
    fn join(&mut self);

    /// Go on the bus, or stay there, silent: receives, and drives no dominant bit, neither a frame nor an acknowledgement.
    /// Nothing is sent until [`CanPort::join`].
    fn listen(&mut self);

    /// Go off the bus: abort every mailbox (each is reported [`PortEvent::Failed`], or [`PortEvent::Transmitted`] when it
    /// was too late) and stay silent once a frame that is on the wire has ended.
    fn leave(&mut self);

    /// Put a frame into a mailbox.
    ///
    /// Frames of one COB-ID leave in the order of the calls. A frame that is not [`urgent`](is_urgent) leaves at least
    /// one mailbox free for those that are. A mailbox is in use until [`CanPort::poll_event`] has handed out its end.
    ///
    /// # Errors
    /// [`Busy`] when no mailbox may take the frame now, or the port is off the bus.
    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy>;

    /// Abort a mailbox; its end is reported as [`PortEvent::Failed`], or as [`PortEvent::Transmitted`] when it was too
    /// late.
    fn abort(&mut self, mailbox: Mailbox);

    /// Error state and counters, read without side effect (ECSS 5.6.2b, c).
    fn health(&self) -> Health;

    /// Begin recovery from bus-off (128 x 11 recessive bits). Nothing happens when it is not bus-off, or off the bus.
    fn recover(&mut self);

    /// The stamp of a frame that [`CanPort::poll_event`] handed out last, received or transmitted: measured in hardware where
    /// that is possible, else `reported`, the one that it was handed out with.
    fn stamp(&mut self, _frame: &Frame, reported: Stamp) -> Stamp {
        reported
    }

    /// Hands out the next event, in the order of time: at most [`LATE_RESULTS`] ends of transmissions come after a frame that
    /// was received later. While there is none, the task is woken at the next one.
    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent>;

    /// Waits for the next event. Cancel-safe: a dropped future loses no event.
    async fn event(&mut self) -> PortEvent {
        poll_fn(|context| self.poll_event(context)).await
    }
}

/// Ends of transmissions that a port may hand out after a frame that was received later. An acknowledgement of a sub-block
/// (CiA 301 7.2.4.3.11) that names more segments than have left, these apart, is an earlier one, received twice. A port with no
/// more mailboxes keeps that by itself.
pub const LATE_RESULTS: u8 = 3;

/// Frames that must never wait behind others: NMT, SYNC, EMCY, TIME and the Spacecraft Time PDO (181h).
pub fn is_urgent(id: CobId) -> bool {
    id.raw() <= 0x181
}

/// Admits frames whose identifier agrees with `id` in the bits set in `mask`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Filter {
    /// Pattern.
    pub id: CobId,
    /// Bits that count, `0..=0x7FF`.
    pub mask: u16,
}

impl Filter {
    /// Every frame.
    pub const ALL: Filter = Filter { id: CobId::NMT, mask: 0 };

    /// Exactly this COB-ID.
    pub const fn exact(id: CobId) -> Filter {
        Filter { id, mask: 0x7FF }
    }

    /// Every node of this function code (the low seven bits do not count).
    pub const fn function(id: CobId) -> Filter {
        let mask = 0x780;
        Filter { id: CobId::low_bits((id.raw() & mask) as u32), mask }
    }

    /// Whether it admits `id`.
    pub const fn admits(&self, id: CobId) -> bool {
        (self.id.raw() ^ id.raw()) & self.mask & 0x7FF == 0
    }
}

/// What a port reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum PortEvent {
    /// A frame that passed the filters.
    Received {
        /// The frame.
        frame: Frame,
        /// End of the frame on this node's clock.
        stamp: Stamp,
    },
    /// The frame in this mailbox was acknowledged.
    Transmitted {
        /// Where it was.
        mailbox: Mailbox,
        /// End of the frame on this node's clock.
        stamp: Stamp,
    },
    /// The frame in this mailbox was aborted and did not go out.
    Failed {
        /// Where it was.
        mailbox: Mailbox,
    },
    /// Received frames were lost: a FIFO overran or the queue behind it was full.
    Overrun {
        /// Frames lost since the last such report, at least: an overrun counts as one, however many frames it cost.
        lost: u16,
    },
    /// The error state changed. Each bus-off is told, and the state between two of them.
    Health(Health),
    /// The controller does not get on or off the bus as it was told to: it is defective, or the bus is dominant all the
    /// time. It is told once for each attempt to get there, and tried on.
    Stalled,
}

/// Fault confinement state (ISO 11898-1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ErrorState {
    /// Both counters below 128.
    #[default]
    Active,
    /// A counter at 128 or above.
    Passive,
    /// Transmit error counter above 255: off the bus until recovered.
    BusOff,
}

/// Last error code of a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LastError {
    /// None since the last successful transfer.
    #[default]
    None,
    /// More than five equal bits.
    Stuff,
    /// A fixed-form bit was wrong.
    Form,
    /// Nobody acknowledged.
    Ack,
    /// A recessive bit was read dominant.
    BitRecessive,
    /// A dominant bit was read recessive.
    BitDominant,
    /// Checksum.
    Crc,
}

/// Error state and counters of a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Health {
    /// Fault confinement state.
    pub state: ErrorState,
    /// Transmit error counter, `0..=255`.
    pub tec: u8,
    /// Receive error counter, `0..=255`.
    pub rec: u8,
    /// Cause of the last error.
    pub last_error: LastError,
}
