//! A foreign controller on one wire: sends frames on request, acknowledges and stores received frames.
//!
//! It has no program: it repeats a frame until it is sent, and recovers from bus-off automatically. It can leave and
//! rejoin the bus, as an adapter that is closed and opened.

use std::collections::VecDeque;

use crate::wire::controller::{Attachment, Controller, WireEvent};
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;
use crate::wire::timing::BitTiming;

/// How a guest takes part in its bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Presence {
    /// As if not connected.
    Away,
    /// Receives, and drives nothing: no frame, no acknowledgement.
    Listening,
    /// Sends, acknowledges and flags errors like any node.
    #[default]
    Present,
}

/// Event of a guest's controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuestEvent {
    /// A frame of another node was received.
    Received(WireFrame),
    /// The oldest waiting frame was sent and acknowledged.
    Sent(WireFrame),
}

/// The controller. On its wire it comes after all boards.
#[derive(Clone, Debug)]
pub(crate) struct Guest {
    timing: BitTiming,
    presence: Presence,
    /// Waiting frames with the instants from which on they may be sent, in the order of sending.
    pub(crate) waiting: VecDeque<(Time, WireFrame)>,
    pub(crate) heard: Vec<(Time, GuestEvent)>,
}

impl Guest {
    pub(crate) fn new(timing: BitTiming) -> Self {
        Guest { timing, presence: Presence::default(), waiting: VecDeque::new(), heard: Vec::new() }
    }

    /// Changes how the guest takes part from now on. Waiting frames are dropped if they can no longer be sent.
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
