//! One controller behind a transceiver switch: two ports, of which one at a time is on its bus.
//!
//! This is the selective bus access architecture with a single controller:
//!
//! ```text
//! Side nominal ───┐                           ┌── transceiver ── nominal bus
//!                 ├── controller ── switch ───┤
//! Side redundant ─┘                           └── transceiver ── redundant bus
//! ```
//!
//! The switch moves when the controller is silent and every event of the old bus was taken. A frame that is cut off
//! would disturb both buses. A result that comes later would count for the new bus.

use core::cell::RefCell;
use core::task::{Context, Poll};

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::RawMutex;
use embassy_sync::waitqueue::WakerRegistration;

use crate::link::Stamp;
use crate::link::port::{Busy, CanPort, Filter, Health, Mailbox, PortEvent};
use crate::types::{Bus, Frame, PerBus};

/// Connects the controller to one of two transceivers.
///
/// The driver input of the other transceiver stays recessive.
pub trait TransceiverSwitch {
    /// Connects the controller to the transceiver of this bus.
    fn select(&mut self, bus: Bus);
}

/// Controller that can be moved from one bus to the other.
///
/// Its filters are set once for each bus, with equal ones.
pub trait Movable: CanPort {
    /// Returns whether the controller is off its bus and drives no dominant bit. While it is not, the controller
    /// wakes the task that last polled for events when it becomes silent.
    fn is_silent(&self) -> bool;
}

/// Controller that the two ports of a node share.
///
/// The port that called `join` or `listen` last has the controller. From then on the other port is off its bus. It
/// sends nothing, hands out the events that it still has and then none, and keeps its last health. A node has the
/// same filters on both buses, so the controller has one set of them.
pub struct OneController<M: RawMutex, P, S> {
    shared: Mutex<M, RefCell<Shared<P, S>>>,
}

impl<M: RawMutex, P: Movable, S: TransceiverSwitch> OneController<M, P, S> {
    /// Takes a controller that is off its bus, and selects the nominal bus.
    pub fn new(controller: P, mut switch: S) -> Self {
        switch.select(Bus::Nominal);
        let shared = Shared {
            controller,
            switch,
            selected: Bus::Nominal,
            wanted: None,
            is_stuck: false,
            past: Health::default(),
            tasks: PerBus::from_fn(|_| WakerRegistration::new()),
        };
        OneController { shared: Mutex::new(RefCell::new(shared)) }
    }

    /// Returns the ports of both buses. Each port needs a task, also the one that is not in use: the controller
    /// moves while the port that loses it is polled.
    pub fn ports(&'static mut self) -> PerBus<Side<M, P, S>> {
        let controller: &'static Self = self;
        PerBus::from_fn(|bus| Side { bus, controller })
    }
}

/// Port of one bus, on a controller that also serves the other bus.
pub struct Side<M: RawMutex + 'static, P: 'static, S: 'static> {
    bus: Bus,
    controller: &'static OneController<M, P, S>,
}

impl<M: RawMutex, P, S> Side<M, P, S> {
    /// Works on the controller, which no interrupt and no other thread has.
    fn with<R>(&self, work: impl FnOnce(Bus, &mut Shared<P, S>) -> R) -> R {
        self.controller.shared.lock(|shared| work(self.bus, &mut shared.borrow_mut()))
    }
}

struct Shared<P, S> {
    controller: P,
    switch: S,
    /// Bus that the switch selects: reports of the controller are of this bus.
    selected: Bus,
    /// The bus to be on, and whether only to listen there.
    wanted: Option<(Bus, bool)>,
    /// It does not get off the selected bus.
    is_stuck: bool,
    /// Health on the other bus when that was left.
    past: Health,
    tasks: PerBus<WakerRegistration>,
}

impl<P: Movable, S: TransceiverSwitch> Shared<P, S> {
    /// Returns whether the port of a bus has the controller. Then its commands are executed at once.
    fn serves(&self, bus: Bus) -> bool {
        self.selected == bus && self.wanted.is_some_and(|(wanted, _)| wanted == bus)
    }

    fn join(&mut self, bus: Bus, listens: bool) {
        self.wanted = Some((bus, listens));
        if bus == self.selected {
            return self.enter(listens);
        }
        self.controller.leave();
        // Its port moves the controller, when there is nothing left to take.
        self.tasks[self.selected].wake();
    }

    fn enter(&mut self, listens: bool) {
        self.is_stuck = false;
        if listens { self.controller.listen() } else { self.controller.join() }
    }

    fn leave(&mut self, bus: Bus) {
        if self.serves(bus) {
            self.controller.leave();
        }
        self.wanted = self.wanted.filter(|(wanted, _)| *wanted != bus);
    }

    fn poll_event(&mut self, bus: Bus, context: &mut Context<'_>) -> Poll<PortEvent> {
        self.tasks[bus].register(context.waker());
        if bus != self.selected {
            return Poll::Pending;
        }
        let event = self.next_event(bus, context);
        let Some((to, listens)) = self.wanted.filter(|(to, _)| event.is_pending() && *to != bus) else {
            return event;
        };
        // A controller cannot leave a bus that is dominant all the time. That must not keep the node from the other bus.
        if !self.is_stuck && !self.controller.is_silent() {
            return Poll::Pending;
        }
        // What came before it was silent. From here on nothing more comes.
        let event = self.next_event(bus, context);
        if event.is_pending() {
            self.move_to(to, listens);
        }
        event
    }

    fn next_event(&mut self, bus: Bus, context: &mut Context<'_>) -> Poll<PortEvent> {
        let event = self.controller.poll_event(context);
        if event == Poll::Ready(PortEvent::Stalled) && !self.serves(bus) {
            self.is_stuck = true;
        }
        event
    }

    fn move_to(&mut self, bus: Bus, listens: bool) {
        self.past = self.controller.health();
        self.selected = bus;
        self.switch.select(bus);
        self.enter(listens);
        // It has frames to send, perhaps, and takes the events from now on.
        self.tasks[bus].wake();
    }
}

impl<M: RawMutex, P: Movable, S: TransceiverSwitch> CanPort for Side<M, P, S> {
    type PerMailbox<T: Default> = P::PerMailbox<T>;

    const FILTERS: usize = P::FILTERS;

    fn set_filters(&mut self, filters: &[Filter]) {
        self.with(|_, shared| shared.controller.set_filters(filters));
    }

    fn set_filter(&mut self, number: u8, filter: Filter) {
        self.with(|_, shared| shared.controller.set_filter(number, filter));
    }

    fn join(&mut self) {
        self.with(|bus, shared| shared.join(bus, false));
    }

    fn listen(&mut self) {
        self.with(|bus, shared| shared.join(bus, true));
    }

    fn leave(&mut self) {
        self.with(|bus, shared| shared.leave(bus));
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        self.with(|bus, shared| if shared.serves(bus) { shared.controller.send(frame) } else { Err(Busy) })
    }

    fn abort(&mut self, mailbox: Mailbox) {
        self.with(|bus, shared| {
            if shared.selected == bus {
                shared.controller.abort(mailbox);
            }
        });
    }

    fn health(&self) -> Health {
        self.with(|bus, shared| if shared.selected == bus { shared.controller.health() } else { shared.past })
    }

    fn recover(&mut self) {
        self.with(|bus, shared| {
            if shared.serves(bus) {
                shared.controller.recover();
            }
        });
    }

    fn stamp(&mut self, frame: &Frame, reported: Stamp) -> Stamp {
        self.with(
            |bus, shared| {
                if shared.selected == bus { shared.controller.stamp(frame, reported) } else { reported }
            },
        )
    }

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        self.with(|bus, shared| shared.poll_event(bus, context))
    }
}
