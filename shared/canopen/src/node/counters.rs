//! Counters of the frames of each bus.

use crate::heartbeat::is_toggled;
use crate::node::{FailCause, LinkEvent};
use crate::types::{Bus, Frame, PerBus};

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
}

/// Counters of a node.
#[derive(Clone, Debug, Default)]
pub struct BusCounters(PerBus<Counters>);

impl BusCounters {
    /// Returns the counters of each bus.
    pub const fn all(&self) -> &PerBus<Counters> {
        &self.0
    }

    /// Returns the number of frames received on each bus; wraps.
    pub fn received_frames(&self) -> PerBus<u32> {
        PerBus::from_fn(|bus| self.0[bus].received)
    }

    /// Counts an event of a bus.
    pub fn on_link(&mut self, bus: Bus, event: &LinkEvent) {
        let counters = &mut self.0[bus];
        match event {
            LinkEvent::Received { .. } => self.count_received(bus),
            LinkEvent::Transmitted { .. } => counters.sent = counters.sent.wrapping_add(1),
            LinkEvent::Failed { cause, .. } => count(match cause {
                FailCause::BusLeft => &mut counters.bus_left,
                FailCause::Expired => &mut counters.expired,
                FailCause::QueueFull => &mut counters.queue_full,
                FailCause::Aborted => &mut counters.aborted,
                FailCause::OverBudget => &mut counters.refused,
            }),
            LinkEvent::Unsent { frames } => {
                counters.queue_full = counters.queue_full.saturating_add(*frames);
            }
            LinkEvent::Overrun { lost } => counters.lost = counters.lost.saturating_add(*lost),
            LinkEvent::Counters(_) | LinkEvent::Stalled | LinkEvent::Health(_) => {}
        }
    }

    /// Counts a received frame.
    pub fn count_received(&mut self, bus: Bus) {
        let counters = &mut self.0[bus];
        counters.received = counters.received.wrapping_add(1);
    }

    /// Counts a received frame with an error in the protocol.
    pub fn count_malformed(&mut self, bus: Bus) {
        count(&mut self.0[bus].malformed);
    }

    /// Counts a heartbeat that was taken as malformed if its bit 7 is set.
    pub fn count_heartbeat(&mut self, bus: Bus, heartbeat: &Frame) {
        if is_toggled(heartbeat) {
            self.count_malformed(bus);
        }
    }

    /// Counts a received frame that is not for this node in this state.
    pub fn count_ignored(&mut self, bus: Bus) {
        count(&mut self.0[bus].ignored);
    }

    /// Counts a frame that this node refuses to send.
    pub fn count_refused(&mut self, bus: Bus) {
        count(&mut self.0[bus].refused);
    }
}

#[cfg_attr(target_os = "none", inline(never))] // of many callers: on a chip of 32 bits a call is shorter
fn count(counter: &mut u16) {
    *counter = counter.saturating_add(1);
}
