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

/// A controller that is plugged in where its switch is. Its error counters are those of each bus: the real one takes them along.
#[derive(Debug)]
pub struct MockController {
    plugs: PerBus<MockPort>,
    position: Rc<Cell<Option<Bus>>>,
}

/// The switch of a [`MockController`].
#[derive(Debug)]
pub struct MockSwitch {
    plugs: PerBus<MockPort>,
    position: Rc<Cell<Option<Bus>>>,
}

/// The port of a node with one controller.
pub type MockSide = Side<NoopRawMutex, MockController, MockSwitch>;

/// The ports of a node with one controller, on the wires of `plugs`.
pub fn one_controller(plugs: &PerBus<MockPort>) -> PerBus<MockSide> {
    let position = Rc::new(Cell::new(None));
    let controller = MockController { plugs: plugs.clone(), position: position.clone() };
    let switch = MockSwitch { plugs: plugs.clone(), position };
    Box::leak(Box::new(OneController::new(controller, switch))).ports()
}

impl TransceiverSwitch for MockSwitch {
    /// # Panics
    /// When the controller still drives the bus that it is to lose, or reports of it.
    fn select(&mut self, bus: Bus) {
        if let Some(from) = self.position.replace(Some(bus)) {
            let plug = &self.plugs[from];
            assert!(plug.is_off_bus(), "the switch moves while the controller is on the {from:?} bus");
            assert!(!plug.has_events(), "the switch moves before the events of the {from:?} bus were taken");
        }
    }
}

impl MockController {
    fn plug(&self) -> &MockPort {
        &self.plugs[self.position.get().expect("the switch is somewhere")]
    }

    fn plug_mut(&mut self) -> &mut MockPort {
        &mut self.plugs[self.position.get().expect("the switch is somewhere")]
    }
}

impl Movable for MockController {
    fn is_silent(&self) -> bool {
        self.plug().is_off_bus()
    }
}

impl CanPort for MockController {
    type PerMailbox<T: Default> = [T; MAILBOXES];

    const FILTERS: usize = FILTERS;

    fn set_filters(&mut self, filters: &[Filter]) {
        Bus::ALL.into_iter().for_each(|bus| self.plugs[bus].set_filters(filters));
    }

    fn set_filter(&mut self, number: u8, filter: Filter) {
        Bus::ALL.into_iter().for_each(|bus| self.plugs[bus].set_filter(number, filter));
    }

    fn join(&mut self) {
        self.plug_mut().join();
    }

    fn listen(&mut self) {
        self.plug_mut().listen();
    }

    fn leave(&mut self) {
        self.plug_mut().leave();
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        self.plug_mut().send(frame)
    }

    fn abort(&mut self, mailbox: Mailbox) {
        self.plug_mut().abort(mailbox);
    }

    fn health(&self) -> Health {
        self.plug().health()
    }

    fn recover(&mut self) {
        self.plug_mut().recover();
    }

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        self.plug_mut().poll_event(context)
    }
}

/// A port of a board.
pub enum BoardPort {
    /// A controller of its own.
    Own(MockPort),
    /// It shares one with the port of the other bus.
    Shared(MockSide),
}

/// The same for both.
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
