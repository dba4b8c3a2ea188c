//! Port: the interface between the protocol and a CAN controller.
//!
//! One port serves one bus. The package `boards` implements it for bxCAN, the module `mock` for tests. To support
//! another controller, implement [`CanPort`]:
//!
//! - A port starts off the bus, and joins it at [`CanPort::join`].
//! - Frames of one COB-ID leave in the order of [`CanPort::send`].
//! - Every frame in a mailbox ends with one event: [`PortEvent::Transmitted`] or [`PortEvent::Failed`].
//! - Events are handed out in the order of time. A lost frame is reported as [`PortEvent::Overrun`].
//! - The port does not recover from bus-off by itself: the node calls [`CanPort::recover`].

use core::future::poll_fn;
use core::task::{Context, Poll};
use thiserror::Error;

use crate::link::Stamp;
use crate::types::{CobId, Frame};

/// Number of a transmit mailbox of a port, from zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mailbox(pub u8);

/// All mailboxes that may take this frame are in use. Try again after the next transmit event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("all mailboxes that may take the frame are in use: try again after the next transmit event")]
pub struct Busy;

/// A CAN controller on one bus.
///
/// A port starts *off the bus*: it neither sends, receives nor acknowledges until [`CanPort::join`].
#[allow(async_fn_in_trait)] // spawned on single-threaded executors only
pub trait CanPort {
    /// Array with one value for each transmit mailbox.
    type PerMailbox<T: Default>: AsRef<[T]> + AsMut<[T]> + Default;

    /// Number of acceptance filters, at most 32.
    const FILTERS: usize;

    /// Sets the filters: at most [`CanPort::FILTERS`] of them. Other frames are not admitted. Called once, off
    /// the bus.
    fn set_filters(&mut self, filters: &[Filter]);

    /// Replaces one of these filters, on the bus or off it. Does nothing for a number that was not set.
    fn set_filter(&mut self, number: u8, filter: Filter);

    /// Joins the bus. The controller takes part after 11 recessive bits.
    fn join(&mut self);

    /// Joins the bus, or stays on it, in silence: receives, but drives no dominant bit, neither for a frame nor
    /// for an acknowledgement. Sends nothing until [`CanPort::join`].
    fn listen(&mut self);

    /// Leaves the bus. Aborts every mailbox and reports each as [`PortEvent::Failed`], or as
    /// [`PortEvent::Transmitted`] if it was too late. A frame that is on the wire is finished; after it the
    /// controller is silent.
    fn leave(&mut self);

    /// Puts a frame into a mailbox.
    ///
    /// Frames of one COB-ID leave in the order of the calls. A frame that is not [`urgent`](is_urgent) leaves at least
    /// one mailbox free for those that are. A mailbox is in use until [`CanPort::poll_event`] has handed out its end.
    ///
    /// # Errors
    /// [`Busy`] when no mailbox may take the frame now, or the port is off the bus.
    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy>;

    /// Aborts a mailbox. Its end is reported as [`PortEvent::Failed`], or as [`PortEvent::Transmitted`] if it was
    /// too late.
    fn abort(&mut self, mailbox: Mailbox);

    /// Returns error state and counters. Reading has no side effect.
    fn health(&self) -> Health;

    /// Begins the recovery from bus-off (128 x 11 recessive bits). Does nothing if the controller is not bus-off,
    /// or off the bus.
    fn recover(&mut self);

    /// Returns the stamp of the frame that [`CanPort::poll_event`] handed out last, received or transmitted. A
    /// port that measures stamps in hardware returns that one. Otherwise it returns `reported`, the stamp of the
    /// event.
    fn stamp(&mut self, _frame: &Frame, reported: Stamp) -> Stamp {
        reported
    }

    /// Hands out the next event. Events are in the order of time, except that at most [`LATE_RESULTS`] ends of
    /// transmissions may follow a frame that was received later. While there is no event, the port wakes the task
    /// at the next one.
    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent>;

    /// Waits for the next event.
    ///
    /// # Cancel safety
    /// A dropped future loses no event.
    async fn event(&mut self) -> PortEvent {
        poll_fn(|context| self.poll_event(context)).await
    }
}

/// Greatest number of ends of transmissions that a port may hand out after a frame that was received later.
/// A port with at most three mailboxes fulfils it.
///
/// SDO server and client rely on it in block transfers (CiA 301 7.2.4.3.11). An acknowledgement may name more segments than
/// have left, but only by this number. If it names more, it is an earlier one that was received twice.
pub const LATE_RESULTS: u8 = 3;

/// Returns whether a frame must never wait behind others: NMT, SYNC, EMCY, TIME, and TPDO 1 of the master
/// (181h).
pub fn is_urgent(id: CobId) -> bool {
    id.raw() <= 0x181
}

/// Acceptance filter: admits frames whose identifier equals `id` in the bits that are set in `mask`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Filter {
    /// Identifier that is compared.
    pub id: CobId,
    /// Bits of the identifier that are compared, `0..=0x7FF`.
    pub mask: u16,
}

impl Filter {
    /// Filter that admits every frame.
    pub const ALL: Filter = Filter { id: CobId::NMT, mask: 0 };

    /// Makes a filter that admits exactly this COB-ID.
    pub const fn exact(id: CobId) -> Filter {
        Filter { id, mask: 0x7FF }
    }

    /// Makes a filter that admits this function code of every node (the low seven bits do not count).
    pub const fn function(id: CobId) -> Filter {
        let mask = 0x780;
        Filter { id: CobId::low_bits((id.raw() & mask) as u32), mask }
    }

    /// Returns whether the filter admits `id`.
    pub const fn admits(&self, id: CobId) -> bool {
        (self.id.raw() ^ id.raw()) & self.mask & 0x7FF == 0
    }
}

/// Event that a port reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)] // moves in words: see `runner`
pub enum PortEvent {
    /// A frame passed the filters.
    Received {
        /// Received frame, with its data.
        frame: Frame,
        /// End of the frame on this node's clock.
        stamp: Stamp,
    },
    /// The frame in this mailbox was acknowledged.
    Transmitted {
        /// Mailbox that had the frame.
        mailbox: Mailbox,
        /// End of the frame on this node's clock.
        stamp: Stamp,
    },
    /// The frame in this mailbox was aborted and was not sent.
    Failed {
        /// Mailbox that had the frame.
        mailbox: Mailbox,
    },
    /// Received frames were lost: a FIFO overran or the queue behind it was full.
    Overrun {
        /// Least number of frames that were lost since the last such report. An overrun counts as one, however
        /// many frames it lost.
        lost: u16,
    },
    /// The error state changed. Each bus-off is reported, and the state between two of them.
    Health(Health),
    /// The controller does not join or leave the bus although it was commanded to: it is defective, or the bus is
    /// dominant all the time. Reported once for each attempt. The controller goes on trying.
    Stalled,
}

/// Fault confinement state of a controller (ISO 11898-1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ErrorState {
    /// Error active: both counters are below 128.
    #[default]
    Active,
    /// Error passive: a counter is at 128 or above.
    Passive,
    /// Bus-off: the transmit error counter is above 255. The controller is off the bus until it recovers.
    BusOff,
}

/// Last error code of a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LastError {
    /// No error since the last successful transfer.
    #[default]
    None,
    /// Stuff error: more than five equal bits.
    Stuff,
    /// Form error: a bit with a fixed value was wrong.
    Form,
    /// Acknowledgement error: no node acknowledged the frame.
    Ack,
    /// Bit error: a recessive bit was read as dominant.
    BitRecessive,
    /// Bit error: a dominant bit was read as recessive.
    BitDominant,
    /// CRC error: the checksum was wrong.
    Crc,
}

/// Error state and error counters of a controller.
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
