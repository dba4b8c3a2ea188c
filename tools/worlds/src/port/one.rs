//! One controller behind a transceiver switch, and the port of a board that has one or two.

use std::cell::Cell;
use std::rc::Rc;
use std::task::{Context, Poll};

use ecss_can::link::Stamp;
use ecss_can::link::one_controller::{Movable, OneController, Side, TransceiverSwitch};
use ecss_can::link::port::{Busy, CanPort, Filter, Health, Mailbox, PortEvent};
use ecss_can::types::{Bus, Frame, PerBus};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;

use super::{FILTERS, MAILBOXES, MockPort};

/// The switch of a controller. The controller keeps its error counters when the bus changes, as the real one does.
#[derive(Debug)]
pub struct MockSwitch {
    plugs: PerBus<MockPort>,
    position: Rc<Cell<usize>>,
}

/// The port of a node with one controller.
pub type MockSide = Side<NoopRawMutex, MockPort, MockSwitch>;

/// The ports of a node with one controller, on the wires of `plugs`.
pub fn one_controller(plugs: &PerBus<MockPort>) -> PerBus<MockSide> {
    // No position before the first selection.
    let position = Rc::new(Cell::new(usize::MAX));
    let chips = Bus::ALL.map(|bus| plugs[bus].plugs[0].clone()).into();
    let controller = MockPort { plugs: chips, position: position.clone() };
    let switch = MockSwitch { plugs: plugs.clone(), position };
    Box::leak(Box::new(OneController::new(controller, switch))).ports()
}

impl TransceiverSwitch for MockSwitch {
    /// # Panics
    /// When the controller is still on the old bus, or has pending events of it.
    fn select(&mut self, bus: Bus) {
        if let Some(&from) = Bus::ALL.get(self.position.replace(bus as usize)) {
            let plug = &self.plugs[from];
            assert!(plug.is_off_bus(), "the switch moves while the controller is on the {from:?} bus");
            assert!(!plug.has_events(), "the switch moves before the events of the {from:?} bus were taken");
        }
    }
}

impl Movable for MockPort {
    fn is_silent(&self) -> bool {
        self.is_off_bus()
    }
}

/// A port of a board.
pub enum BoardPort {
    /// Has its own controller.
    Own(MockPort),
    /// Shares a controller with the port of the other bus.
    Shared(MockSide),
}

/// Calls the same method for both variants.
macro_rules! either {
    ($port:expr, $inner:ident => $work:expr) => {
        match $port {
            BoardPort::Own($inner) => $work,
            BoardPort::Shared($inner) => $work,
        }
    };
}

impl CanPort for BoardPort {
    type PerMailbox<T: Default> = [T; MAILBOXES];

    const FILTERS: usize = FILTERS;

    fn set_filters(&mut self, filters: &[Filter]) {
        either!(self, port => port.set_filters(filters));
    }

    fn set_filter(&mut self, number: u8, filter: Filter) {
        either!(self, port => port.set_filter(number, filter));
    }

    fn join(&mut self) {
        either!(self, port => port.join());
    }

    fn listen(&mut self) {
        either!(self, port => port.listen());
    }

    fn leave(&mut self) {
        either!(self, port => port.leave());
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        either!(self, port => port.send(frame))
    }

    fn abort(&mut self, mailbox: Mailbox) {
        either!(self, port => port.abort(mailbox));
    }

    fn health(&self) -> Health {
        either!(self, port => port.health())
    }

    fn recover(&mut self) {
        either!(self, port => port.recover());
    }

    fn stamp(&mut self, frame: &Frame, reported: Stamp) -> Stamp {
        either!(self, port => port.stamp(frame, reported))
    }

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        either!(self, port => port.poll_event(context))
    }
}
