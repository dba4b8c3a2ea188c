//! Counters of the frames of each bus.

use crate::node::{FailCause, LinkEvent};

/// Counters of the frames of one bus. `received` and `sent` wrap; all others stay at their maximum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Frames received, whatever the node did with them.
    pub received: u32,
    /// Frames sent and acknowledged.
    pub sent: u32,
    /// Received frames with an error in the protocol: wrong length, unknown command or state. Heartbeats with bit 7 set,
    /// whose state is used all the same.
    pub malformed: u16,
    /// Received frames without an error that were not for this node in this state on this bus.
    pub ignored: u16,
    /// Least number of frames lost in the receiver. An overrun of its FIFO counts as one, however many frames it
    /// lost.
    pub lost: u16,
    /// Frames not sent: refused by this node, in the wrong state, on the inactive bus, or above its budget.
    pub refused: u16,
    /// Frames not sent: the bus was left.
    pub bus_left: u16,
    /// Frames not sent: the lifetime ended.
    pub expired: u16,
    /// Frames not sent: a queue of the node or of the bus was full.
    pub queue_full: u16,
    /// Frames not sent: the controller aborted them.
    pub aborted: u16,
}

impl Counters {
    /// Returns the number of frames that were not sent, for any cause.
    pub const fn failed(&self) -> u16 {
        self.refused
            .saturating_add(self.bus_left)
            .saturating_add(self.expired)
            .saturating_add(self.queue_full)
            .saturating_add(self.aborted)
    }

    /// Counts a frame that was not sent.
    pub(super) fn on_failed(&mut self, cause: FailCause) {
        count(match cause {
            FailCause::BusLeft => &mut self.bus_left,
            FailCause::Expired => &mut self.expired,
            FailCause::QueueFull => &mut self.queue_full,
            FailCause::Aborted => &mut self.aborted,
            FailCause::OverBudget => &mut self.refused,
        });
    }

    /// Counts an event of the bus.
    pub(super) fn on_link(&mut self, event: &LinkEvent) {
        match event {
            LinkEvent::Transmitted { .. } => self.sent = self.sent.wrapping_add(1),
            LinkEvent::Failed { cause, .. } => self.on_failed(*cause),
            LinkEvent::Unsent { frames } => self.queue_full = self.queue_full.saturating_add(*frames),
            LinkEvent::Overrun { lost } => self.lost = self.lost.saturating_add(*lost),
            LinkEvent::Received { .. } => self.received = self.received.wrapping_add(1),
            LinkEvent::Counters(_) | LinkEvent::Stalled | LinkEvent::Health(_) => {}
        }
    }
}

/// Counts one frame.
#[cfg_attr(target_os = "none", inline(never))] // of many callers: on a chip of 32 bits a call is shorter
pub(super) fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}
