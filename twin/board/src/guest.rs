//! A foreign controller on one wire: sends what it is handed, acknowledges and keeps what it hears.
//!
//! It has no program: it repeats a frame until it is out, and comes back from bus-off by itself. It can leave the bus and
//! come back, as an adapter does whose user opens and closes it.

use std::collections::VecDeque;

use can_wire::controller::{Attachment, Controller, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use can_wire::timing::BitTiming;

/// How a guest takes part in its bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Presence {
    /// Not at all: as if it were not connected.
    Away,
    /// It hears, and drives nothing: no frame, no acknowledgement.
    Listening,
    /// It sends, acknowledges and flags errors like any node.
    #[default]
    Present,
}

/// What a guest's controller reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuestEvent {
    /// A frame of another node is valid.
    Received(WireFrame),
    /// The frame that waited longest was acknowledged and completed.
    Sent(WireFrame),
}

/// The controller. On its wire it comes after all boards.
#[derive(Clone, Debug)]
pub(crate) struct Guest {
    timing: BitTiming,
    presence: Presence,
    /// What waits and from when on, in the order of sending.
    pub(crate) waiting: VecDeque<(Time, WireFrame)>,
    pub(crate) heard: Vec<(Time, GuestEvent)>,
}

impl Guest {
    pub(crate) fn new(timing: BitTiming) -> Self {
        Guest { timing, presence: Presence::default(), waiting: VecDeque::new(), heard: Vec::new() }
    }

    /// Takes part like that from now on. What waits is dropped when it can no longer be sent.
    pub(crate) fn become_present(&mut self, presence: Presence) {
        if presence != Presence::Present {
            self.waiting.clear();
        }
        self.presence = presence;
    }
}

impl Controller for Guest {
    fn attachment(&self) -> Option<Attachment> {
        let silent = match self.presence {
            Presence::Away => return None,
            Presence::Listening => true,
            Presence::Present => false,
        };
        Some(Attachment { silent, ..Attachment::new(self.timing) })
    }

    fn request_at(&self) -> Option<Time> {
        self.waiting.front().map(|&(at, _)| at)
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.waiting.front().filter(|(from, _)| *from <= at).map(|&(_, frame)| frame)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        let heard = match event {
            WireEvent::Transmitted => self.waiting.pop_front().map(|(_, frame)| GuestEvent::Sent(frame)),
            WireEvent::Received(frame) => Some(GuestEvent::Received(*frame)),
            _ => None,
        };
        self.heard.extend(heard.map(|heard| (at, heard)));
    }
}
