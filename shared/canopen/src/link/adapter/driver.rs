//! Driver: the part of an adapter that another project wrote, and that knows the controller.

use core::task::{Context, Poll};
use thiserror::Error;

use crate::link::Stamp;
use crate::link::port::{Filter, Health, LastError};
use crate::types::{Frame, Instant};

/// A driver of a CAN controller that was not written for this crate.
///
/// Three methods are required. Each other method is for a function that many drivers lack: its default does nothing,
/// and the table of [`adapter`](super) says how a node behaves then.
pub trait Driver {
    /// Number of acceptance filters of the controller, at most 32. The adapter filters again in software.
    const FILTERS: usize = 32;

    /// Hands a frame to the driver. Frames of one COB-ID leave in the order in which the driver accepted them.
    ///
    /// # Errors
    /// [`Refused`]: the frame is not in the driver. The adapter tries again when the task of `context` is woken.
    fn transmit(&mut self, frame: &Frame, context: &mut Context<'_>) -> Result<Accepted, Refused>;

    /// Takes what the driver received. While there is nothing, the driver wakes the task of `context` at the next
    /// frame. It skips remote frames and frames with an identifier of 29 bits.
    fn poll_receive(&mut self, context: &mut Context<'_>) -> Poll<Received>;

    /// Returns the present instant on the clock of the node.
    fn now(&self) -> Instant;

    /// Returns whether the frame in this place has left. While it has not, the driver wakes the task of `context`
    /// at the end of a transmission. Called for places of [`Accepted::Followed`] only.
    fn poll_sent(&mut self, _place: u8, _context: &mut Context<'_>) -> Poll<()> {
        Poll::Ready(())
    }

    /// Aborts the frame in this place. Returns whether it was aborted: `false` means that it has left or is leaving.
    /// Called for places of [`Accepted::Followed`] only.
    fn abort(&mut self, _place: u8) -> bool {
        false
    }

    /// Returns error state and counters, or `None` if the driver does not know them. A [`LastError::None`] in it is
    /// replaced by the last error that [`Driver::transmit`] or [`Driver::poll_receive`] returned.
    fn health(&self) -> Option<Health> {
        None
    }

    /// Joins the bus, leaves it, or only listens.
    fn set_mode(&mut self, _mode: Mode) {}

    /// Begins the recovery from bus-off.
    fn recover(&mut self) {}

    /// Sets the acceptance filters of the controller, of which some have changed.
    fn set_filters(&mut self, _filters: &[Filter]) {}
}

/// Part that a controller takes on its bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// It neither sends, receives nor acknowledges.
    #[default]
    Off,
    /// It receives, and drives no dominant bit.
    Listening,
    /// It sends, receives and acknowledges.
    On,
}

/// A driver accepted a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Accepted {
    /// The driver does not report whether the frame leaves.
    Unfollowed {
        /// Frame that the driver gave up to make room.
        replaced: Option<Frame>,
    },
    /// [`Driver::poll_sent`] reports when the frame has left.
    Followed {
        /// Place of the frame, such as the number of a mailbox. No other frame in the driver has it.
        place: u8,
        /// The earlier frame in this place was given up. If `false`, that one has left.
        replaced: bool,
    },
}

/// A driver did not accept a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refused {
    /// It has no room for a frame with this COB-ID.
    #[error("the driver has no room for a frame with this COB-ID")]
    Full,
    /// It failed for this cause. [`LastError::None`] stands for a cause that has no name here.
    #[error("the driver failed: {0:?}")]
    Error(LastError),
}

/// A driver received something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Received {
    /// A data frame with an identifier of 11 bits.
    Frame {
        /// Received frame, with its data.
        frame: Frame,
        /// End of the frame on this node's clock, or the instant at which it was read.
        stamp: Stamp,
    },
    /// The controller or the driver lost at least this number of frames.
    Overrun(u16),
    /// The controller found an error on the bus. [`LastError::None`] stands for a cause that has no name here.
    Error(LastError),
}
