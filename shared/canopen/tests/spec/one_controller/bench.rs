//! A controller and its switch that the test plays by hand, and the tasks of two buses.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

use async_canopen::link::Stamp;
use async_canopen::link::one_controller::{Movable, OneController, Side, TransceiverSwitch};
use async_canopen::link::port::{Busy, CanPort, ErrorState, Filter, Health, Mailbox, PortEvent};
use async_canopen::types::{Bus, Frame, Instant, PerBus};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;

use crate::bench::NOMINAL;

/// What controller and switch were told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Told {
    Select(Bus),
    Join,
    Listen,
    Leave,
    Send(u16),
    Abort(u8),
    Recover,
    Filter(u8),
}
use Told::{Abort, Join, Leave, Listen, Recover, Select, Send};

/// The controller as the test plays it.
#[derive(Default)]
pub struct Chip {
    pub told: Vec<Told>,
    pub events: VecDeque<PortEvent>,
    pub is_silent: bool,
    pub health: Health,
    /// Gets off its bus while it is polled, with this event as the last one.
    pub last: Option<PortEvent>,
}

#[derive(Clone, Default)]
pub struct Scripted(Rc<RefCell<Chip>>);

impl Scripted {
    fn note(&self, told: Told) {
        self.0.borrow_mut().told.push(told);
    }
}

impl TransceiverSwitch for Scripted {
    fn select(&mut self, bus: Bus) {
        self.note(Select(bus));
    }
}

impl Movable for Scripted {
    fn is_silent(&self) -> bool {
        self.0.borrow().is_silent
    }
}

impl CanPort for Scripted {
    type PerMailbox<T: Default> = [T; 1];

    const FILTERS: usize = 28;

    fn set_filters(&mut self, _: &[Filter]) {}

    fn set_filter(&mut self, number: u8, _: Filter) {
        self.note(Told::Filter(number));
    }

    fn join(&mut self) {
        self.note(Join);
    }

    fn listen(&mut self) {
        self.note(Listen);
    }

    fn leave(&mut self) {
        self.note(Leave);
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        self.note(Send(frame.id().raw()));
        Ok(Mailbox(0))
    }

    fn abort(&mut self, mailbox: Mailbox) {
        self.note(Abort(mailbox.0));
    }

    fn health(&self) -> Health {
        self.0.borrow().health
    }

    fn recover(&mut self) {
        self.note(Recover);
    }

    fn stamp(&mut self, _: &Frame, _: Stamp) -> Stamp {
        MEASURED
    }

    fn poll_event(&mut self, _: &mut Context<'_>) -> Poll<PortEvent> {
        let mut chip = self.0.borrow_mut();
        let Some(event) = chip.events.pop_front() else {
            if let Some(last) = chip.last.take() {
                chip.is_silent = true;
                chip.events.push_back(last);
            }
            return Poll::Pending;
        };
        Poll::Ready(event)
    }
}

pub const MEASURED: Stamp = Stamp::interrupt(Instant::from_micros(7));
pub const REPORTED: Stamp = Stamp::interrupt(Instant::from_micros(9));
pub const FAILED: PortEvent = PortEvent::Failed { mailbox: Mailbox(0) };
pub const OFF: Health = Health { state: ErrorState::BusOff, ..PASSIVE };
pub const PASSIVE: Health = Health {
    state: ErrorState::Passive,
    tec: 128,
    rec: 3,
    last_error: async_canopen::link::port::LastError::Ack,
};

/// A task that was woken.
#[derive(Default)]
pub struct Task(AtomicBool);

impl Wake for Task {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

pub struct Bench {
    pub chip: Scripted,
    pub ports: PerBus<Side<NoopRawMutex, Scripted, Scripted>>,
    pub tasks: PerBus<Arc<Task>>,
}

impl Bench {
    /// At power-on; the tasks of both buses wait for events.
    pub fn new() -> Bench {
        let chip = Scripted::default();
        chip.0.borrow_mut().is_silent = true;
        let shared = Box::leak(Box::new(OneController::new(chip.clone(), chip.clone())));
        let tasks = PerBus::from_fn(|_| Arc::default());
        let mut bench = Bench { chip, ports: shared.ports(), tasks };
        assert_eq!(bench.told(), [Select(NOMINAL)]);
        Bus::ALL.into_iter().for_each(|bus| assert_eq!(bench.poll(bus), Poll::Pending));
        bench
    }

    /// On the nominal bus.
    pub fn joined() -> Bench {
        let mut bench = Bench::new();
        bench.ports.nominal.join();
        assert_eq!(bench.told(), [Join]);
        bench.with(|chip| chip.is_silent = false);
        bench
    }

    /// Away from the nominal bus, and silent.
    pub fn moved() -> Bench {
        let mut bench = Bench::joined();
        bench.ports.nominal.leave();
        bench.ports.redundant.join();
        bench.with(|chip| chip.is_silent = true);
        assert_eq!(bench.poll(NOMINAL), Poll::Pending);
        bench.with(|chip| chip.is_silent = false);
        bench.told();
        bench
    }

    pub fn with(&self, change: impl FnOnce(&mut Chip)) {
        change(&mut self.chip.0.borrow_mut());
    }

    pub fn happens(&self, event: PortEvent) {
        self.with(|chip| chip.events.push_back(event));
    }

    pub fn told(&mut self) -> Vec<Told> {
        std::mem::take(&mut self.chip.0.borrow_mut().told)
    }

    pub fn poll(&mut self, bus: Bus) -> Poll<PortEvent> {
        let waker = Waker::from(self.tasks[bus].clone());
        self.ports[bus].poll_event(&mut Context::from_waker(&waker))
    }

    /// Whether the task of a bus was woken since the last call.
    pub fn was_woken(&self, bus: Bus) -> bool {
        self.tasks[bus].0.swap(false, Ordering::Relaxed)
    }
}
