//! A board's CAN connector: what a wire talks to.

use std::sync::{Arc, MutexGuard};

use can_wire::controller::{Attachment, Controller, ErrorCounters, WireEvent};
use can_wire::frame::WireFrame;
use can_wire::time::Time;

use crate::board::Plug;
use crate::bxcan::Side;
use crate::link::Link;
use crate::peripherals::Peripherals;

/// One controller of one board behind its pins and a transceiver. Without power, clock or pins nobody is there, nor behind a
/// transceiver that is not selected.
#[derive(Debug)]
pub(crate) struct BoardPort {
    link: Arc<Link>,
    /// Number of the board.
    pub(crate) board: usize,
    plug: Plug,
    /// Level changes at the receive pin since they were taken.
    changes: Vec<(Time, bool)>,
}

impl BoardPort {
    pub(crate) fn new(link: Arc<Link>, board: usize, plug: Plug) -> Self {
        BoardPort { link, board, plug, changes: Vec::new() }
    }

    /// The controller behind the transceiver, if it is selected.
    pub(crate) fn controller(&self) -> Side {
        self.plug.controller
    }

    /// Hands the level changes since the last call to `edge`.
    pub(crate) fn drain_changes(&mut self, edge: impl FnMut((Time, bool))) {
        self.changes.drain(..).for_each(edge);
    }

    /// The peripherals of a board whose controller is connected here.
    fn connected(&self) -> Option<MutexGuard<'_, Peripherals>> {
        let peripherals = self.link.peripherals();
        let is_selected =
            self.plug.selected_by.is_none_or(|(pin, level)| peripherals.pin_level(pin) == level);
        is_selected.then_some(peripherals)
    }
}

impl Controller for BoardPort {
    fn attachment(&self) -> Option<Attachment> {
        self.connected()?.can_line(self.plug.controller)?.attachment()
    }

    /// One that has another wire, too.
    fn brings(&self) -> Option<ErrorCounters> {
        self.plug.selected_by?;
        Some(self.connected()?.can_line(self.plug.controller)?.error_counters())
    }

    fn request_at(&self) -> Option<Time> {
        self.connected()?.can_line(self.plug.controller)?.request_at()
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.connected()?.can_line(self.plug.controller)?.contend(at)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        // A frame that ends after the controller left its pins is not its business any more.
        if let Some(mut peripherals) = self.connected()
            && let Some(mut line) = peripherals.can_line(self.plug.controller)
        {
            line.on_wire(at, event);
        }
    }

    fn watches_line(&self) -> bool {
        true
    }

    fn on_line(&mut self, changes: &[(Time, bool)]) {
        let Some(mut peripherals) = self.connected() else { return };
        if let Some(mut line) = peripherals.can_line(self.plug.controller) {
            line.on_line(changes);
        }
        drop(peripherals);
        self.changes.extend(changes);
    }
}
