//! A foreign controller on one wire: sends what a test hands it, acknowledges what it hears.
//!
//! It has no program and never tires: always error active, it repeats a frame until somebody acknowledges it.

use std::collections::VecDeque;

use can_wire::controller::{Controller, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;

/// 1 Mbit/s, exact.
const BIT_TIME: Time = Time::from_us(1);

/// The controller. On its wire it comes after all boards.
#[derive(Debug, Default)]
pub(crate) struct Guest {
    /// What waits and from when on, in the order of sending.
    waiting: VecDeque<(Time, WireFrame)>,
    started: Option<Time>,
}

impl Guest {
    /// Sends `frame` at `at`, or as soon as the bus is free and everything handed over before is out.
    pub(crate) fn send(&mut self, at: Time, frame: WireFrame) {
        self.waiting.push_back((at, frame));
    }

    /// The start of the last frame that it began since the last call.
    pub(crate) fn take_started(&mut self) -> Option<Time> {
        self.started.take()
    }
}

impl Controller for Guest {
    fn bit_time(&self) -> Option<Time> {
        Some(BIT_TIME)
    }

    fn error_passive(&self) -> bool {
        false
    }

    fn request_at(&self) -> Option<Time> {
        self.waiting.front().map(|&(at, _)| at)
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.waiting.front().filter(|(from, _)| *from <= at).map(|&(_, frame)| frame)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        match event {
            WireEvent::Started => self.started = Some(at),
            WireEvent::Transmitted(_) => drop(self.waiting.pop_front()),
            WireEvent::ArbitrationLost
            | WireEvent::Received(_)
            | WireEvent::TransmitError(_)
            | WireEvent::ReceiveError(_) => {}
        }
    }
}
