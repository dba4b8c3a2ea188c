//! A board's CAN connector: what a wire talks to.

use std::sync::Arc;

use can_wire::controller::{Attachment, Controller, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;

use crate::bxcan::Side;
use crate::link::Link;

/// One controller of one board behind its pins. Without power, clock or pins nobody is there.
#[derive(Debug)]
pub(crate) struct BoardPort {
    link: Arc<Link>,
    /// Number of the board.
    pub(crate) board: usize,
    pub(crate) side: Side,
    /// Level changes at the receive pin since they were taken.
    changes: Vec<(Time, bool)>,
}

impl BoardPort {
    pub(crate) fn new(link: Arc<Link>, board: usize, side: Side) -> Self {
        BoardPort { link, board, side, changes: Vec::new() }
    }

    /// Hands the level changes since the last call to `edge`.
    pub(crate) fn drain_changes(&mut self, edge: impl FnMut((Time, bool))) {
        self.changes.drain(..).for_each(edge);
    }
}

impl Controller for BoardPort {
    fn attachment(&self) -> Option<Attachment> {
        self.link.peripherals().can_line(self.side)?.attachment()
    }

    fn request_at(&self) -> Option<Time> {
        self.link.peripherals().can_line(self.side)?.request_at()
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.link.peripherals().can_line(self.side)?.contend(at)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        // A frame that ends after the controller left its pins is not its business any more.
        if let Some(mut line) = self.link.peripherals().can_line(self.side) {
            line.on_wire(at, event);
        }
    }

    fn watches_line(&self) -> bool {
        true
    }

    fn on_line(&mut self, changes: &[(Time, bool)]) {
        if let Some(mut line) = self.link.peripherals().can_line(self.side) {
            line.on_line(changes);
        }
        self.changes.extend(changes);
    }
}
