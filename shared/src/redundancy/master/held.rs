//! Frames that wait until the active bus is announced.

use heapless::Vec;

use super::{MasterAction, MasterBoards, MasterRedundancy};
use crate::link::machine::Outgoing;
use crate::types::{Bus, Canonical, Instant, PerBus};

/// Place where a frame of the master goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sending {
    /// Send the frame now on this bus, which is active.
    Now(Bus),
    /// The frame waits for the announcement of the active bus.
    Held,
    /// Too many frames wait for the announcement of this bus: it is not sent.
    Refused(Bus),
}

/// Frames in the order in which they are sent after the announcement.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
pub(super) struct Held<const H: usize> {
    frames: Vec<Outgoing, H>,
    /// How many of the first ones waited for a bus that was left.
    left: PerBus<u8>,
    /// The spacecraft time became due.
    pub is_time_due: bool,
}

impl<const H: usize> Held<H> {
    pub const fn new() -> Held<H> {
        Held { frames: Vec::new(), left: PerBus { nominal: 0, redundant: 0 }, is_time_due: false }
    }

    /// The bus is left for which all frames wait.
    pub fn leave(&mut self, bus: Bus) {
        self.left[bus] = self.frames.len() as u8 - self.left[bus.other()];
    }

    /// Returns whether frames, or the time, can be sent or are not sent at all.
    pub fn is_due(&self, is_announced: bool) -> bool {
        let waits = self.is_time_due || !self.frames.is_empty();
        waits && is_announced || Bus::ALL.into_iter().any(|bus| self.left[bus] > 0)
    }

    /// Returns what is not sent because its bus was left, one after the other.
    pub fn take_left(&mut self) -> Option<MasterAction> {
        let bus = Bus::ALL.into_iter().find(|bus| self.left[*bus] > 0)?;
        self.left[bus] -= 1;
        let Outgoing { frame, .. } = self.frames.remove(0);
        Some(MasterAction::Left { bus, frame })
    }
}

impl<B: MasterBoards, const N: usize, const H: usize> MasterRedundancy<B, N, H> {
    /// Sends a frame on the active bus, when it is announced.
    pub fn send(&mut self, outgoing: Outgoing) -> Sending {
        let bus = self.active();
        if self.is_announced() {
            Sending::Now(bus)
        } else if self.queue(outgoing) {
            Sending::Held
        } else {
            Sending::Refused(bus)
        }
    }

    /// Sends a frame at the next [poll](MasterRedundancy::poll) with the active bus announced. Returns `false` if
    /// there is no room.
    pub fn queue(&mut self, outgoing: Outgoing) -> bool {
        self.held.frames.push(outgoing).is_ok()
    }

    /// Returns whether [`MasterRedundancy::send`] would take a frame.
    pub fn has_room(&self) -> bool {
        self.is_announced() || !self.held.frames.is_full()
    }

    /// Sends the spacecraft time on the active bus. Before the announcement it is not held: it would be late. It is
    /// sampled again then ([`MasterAction::SendTime`]).
    pub fn send_time(&mut self) -> Sending {
        if self.is_announced() {
            return Sending::Now(self.active());
        }
        self.held.is_time_due = true;
        Sending::Held
    }

    /// Returns what waited for the announcement, one after the other.
    pub(super) fn release(&mut self, now: Instant) -> Option<MasterAction> {
        if !self.is_announced() {
            return None;
        }
        if core::mem::take(&mut self.held.is_time_due) {
            return Some(MasterAction::SendTime);
        }
        if self.held.frames.is_empty() {
            return None;
        }
        let (bus, outgoing) = (self.active(), self.held.frames.remove(0));
        let is_expired = outgoing.is_expired(now);
        let Outgoing { frame, .. } = outgoing;
        Some(if is_expired {
            MasterAction::Expired { bus, frame }
        } else {
            MasterAction::Send { bus, outgoing }
        })
    }
}
