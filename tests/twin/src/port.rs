//! A board's CAN connector: what a wire talks to.

use std::sync::Arc;

use can_wire::controller::{Controller, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;

use crate::bxcan::Side;
use crate::link::Link;

/// One controller of one board behind its pins. Without power, clock or pins nobody is there.
#[derive(Debug)]
pub(crate) struct Port {
    link: Arc<Link>,
    side: Side,
    started: Option<Time>,
}

impl Port {
    pub(crate) fn new(link: Arc<Link>, side: Side) -> Self {
        Port { link, side, started: None }
    }

    /// The start of the last frame that this board began since the last call.
    pub(crate) fn take_started(&mut self) -> Option<Time> {
        self.started.take()
    }
}

impl Controller for Port {
    fn bit_time(&self) -> Option<Time> {
        self.link.peripherals().can_line(self.side)?.bit_time()
    }

    fn acknowledges(&self) -> bool {
        self.link.peripherals().can_line(self.side).is_some_and(|line| line.acknowledges())
    }

    fn error_passive(&self) -> bool {
        self.link.peripherals().can_line(self.side).is_some_and(|line| line.error_passive())
    }

    fn request_at(&self) -> Option<Time> {
        self.link.peripherals().can_line(self.side)?.request_at()
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.link.peripherals().can_line(self.side)?.contend(at)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        if matches!(event, WireEvent::Started) {
            self.started = Some(at);
        }
        // A frame that ends after the controller left its pins is not its business any more.
        if let Some(mut line) = self.link.peripherals().can_line(self.side) {
            line.on_wire(at, event);
        }
    }
}
