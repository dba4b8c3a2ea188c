//! A foreign controller on one wire: sends what a test hands it, acknowledges what it hears.
//!
//! It has no program: it repeats a frame until it is out, and comes back from bus-off by itself.

use std::collections::VecDeque;

use can_wire::controller::{Attachment, Controller, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use can_wire::timing::BitTiming;

/// The controller. On its wire it comes after all boards.
#[derive(Debug, Default)]
pub(crate) struct Guest {
    /// What waits and from when on, in the order of sending.
    waiting: VecDeque<(Time, WireFrame)>,
}

impl Guest {
    /// Sends `frame` at `at`, or as soon as the bus is free and everything handed over before is out.
    pub(crate) fn send(&mut self, at: Time, frame: WireFrame) {
        self.waiting.push_back((at, frame));
    }
}

impl Controller for Guest {
    fn attachment(&self) -> Option<Attachment> {
        Some(Attachment::new(BitTiming::MEGABIT))
    }

    fn request_at(&self) -> Option<Time> {
        self.waiting.front().map(|&(at, _)| at)
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.waiting.front().filter(|(from, _)| *from <= at).map(|&(_, frame)| frame)
    }

    fn on_wire(&mut self, _at: Time, event: &WireEvent) {
        if let WireEvent::Transmitted = event {
            self.waiting.pop_front();
        }
    }
}
