//! A board's CAN connector for its wire.

use crate::board::Plug;
use crate::bxcan::Registers;
use crate::peripherals::Peripherals;
use crate::wire::controller::{Attachment, Controller, ErrorCounters, WireEvent};
use crate::wire::frame::WireFrame;
use crate::wire::time::Time;

/// One transceiver of one board on its bus.
#[derive(Clone, Debug)]
pub(crate) struct BoardPort {
    /// Number of the board.
    pub(crate) board: usize,
    pub(crate) plug: Plug,
    /// Level changes at the receive pin since they were last taken.
    pub(crate) changes: Vec<(Time, bool)>,
}

impl BoardPort {
    pub(crate) fn new(board: usize, plug: Plug) -> Self {
        BoardPort { board, plug, changes: Vec::new() }
    }
}

/// A port with the peripherals of its board. There is no controller without power, clock or pins, nor behind a
/// transceiver that is not selected.
#[derive(Debug)]
pub(crate) struct LivePort<'a> {
    pub port: &'a mut BoardPort,
    pub peripherals: &'a mut Peripherals,
}

impl LivePort<'_> {
    fn is_selected(&self) -> bool {
        let selects = |(pin, level)| self.peripherals.pin_level(pin) == level;
        self.port.plug.selected_by.is_none_or(selects)
    }

    /// The controller that is connected here.
    fn connected(&self) -> Option<&Registers> {
        self.is_selected().then(|| self.peripherals.can_registers(self.port.plug.controller)).flatten()
    }
}

impl Controller for LivePort<'_> {
    fn attachment(&self) -> Option<Attachment> {
        self.connected()?.attachment()
    }

    /// Returns the error counters: the controller also counts on another wire, and without one.
    fn brings(&self) -> Option<ErrorCounters> {
        Some(self.connected()?.error_counters())
    }

    fn request_at(&self) -> Option<Time> {
        self.connected()?.request_at()
    }

    fn contend(&self, at: Time) -> Option<WireFrame> {
        self.connected()?.contend(at)
    }

    fn on_wire(&mut self, at: Time, event: &WireEvent) {
        // A frame that ends after the controller left its pins is ignored.
        if self.is_selected()
            && let Some(mut line) = self.peripherals.can_line(self.port.plug.controller)
        {
            line.on_wire(at, event);
        }
    }

    fn watches_line(&self) -> bool {
        true
    }

    fn on_line(&mut self, changes: &[(Time, bool)]) {
        if !self.is_selected() {
            return;
        }
        if let Some(mut line) = self.peripherals.can_line(self.port.plug.controller) {
            line.on_line(changes);
        }
        self.port.changes.extend(changes);
    }
}
