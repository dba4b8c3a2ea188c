//! A controller that sends whatever a test wants, whenever it wants.

use std::collections::VecDeque;

use can_wire::controller::{Attachment, Controller, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;
use can_wire::timing::BitTiming;

/// Acknowledges everything, obeys nothing, and sends what it is given, in order.
#[derive(Debug)]
pub(crate) struct FrameInjector {
    timing: BitTiming,
    queue: VecDeque<(Time, WireFrame)>,
    plugged_in: bool,
}

impl FrameInjector {
    /// One that is not on the bus yet.
    pub fn new(timing: BitTiming) -> FrameInjector {
        FrameInjector { timing, queue: VecDeque::new(), plugged_in: false }
    }

    /// Send a frame from `now` on; from the first one on it takes part in the bus.
    pub fn send(&mut self, now: Time, frame: WireFrame) {
        self.plugged_in = true;
        self.queue.push_back((now, frame));
    }
}

impl Controller for FrameInjector {
    fn attachment(&self) -> Option<Attachment> {
        self.plugged_in.then(|| Attachment::new(self.timing))
    }

    fn request_at(&self) -> Option<Time> {
        self.queue.front().map(|(since, _)| *since)
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.queue.front().filter(|(since, _)| *since <= at).map(|(_, frame)| *frame)
    }

    fn on_wire(&mut self, _: Time, event: &WireEvent) {
        if matches!(event, WireEvent::Transmitted) {
            self.queue.pop_front();
        }
    }
}
