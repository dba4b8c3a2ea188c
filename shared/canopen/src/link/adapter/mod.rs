//! Adapter: a port over a driver that was not written for this crate.
//!
//! A *driver* sends and receives frames. Few report the end of each transmission, as a [`CanPort`] has to. An
//! [`Adapter`] is a port over any [`Driver`]: it has three mailboxes in front of the driver, keeps frames of one
//! COB-ID in order, keeps a frame that the driver gave up for a more urgent one, and filters in software.
//!
//! [`Nonblocking`] is a driver over any `embedded_can::nb::Can`.
//! For another driver, implement [`Driver`] in about 60 lines.
//!
//! # What a driver may lack
//!
//! | the driver lacks | what the adapter does | what the node does then |
//! | --- | --- | --- |
//! | results of transmissions | reports `Transmitted` as soon as the driver accepts a frame | counts a frame as sent that no other node acknowledges; a lifetime ends only for frames that the driver refuses |
//! | abort | aborts only frames that it has not handed over | an urgent frame waits behind frames in the driver; these leave when a cut heals, however old |
//! | stamps | reads the clock when it reads the frame | times SYNC and heartbeats late by the latency of its task |
//! | an interrupt that wakes the task | does nothing between two polls of the runner | answers up to 100 ms late |
//! | error state and counters | reports error active, both counters zero, and the cause of the last error that the driver returned | raises no EMCY for error passive and bus-off, and does not recover from bus-off |
//! | recovery on command | ignores `recover` | is back on the bus when the driver is |
//! | leaving the bus, listen-only mode | sends nothing, and drops received frames while it is off the bus | the controller still acknowledges |
//! | acceptance filters | filters in software | spends an interrupt on every frame of the bus |
//! | overruns | reports none | misses frames unnoticed |
//!
//! # Limits
//!
//! - A driver that gives up a frame has to give up the last one of its COB-ID, as `embedded_can::nb::Can` requires of
//!   frames of equal identifier. Otherwise the two leave in the wrong order.
//! - A frame that the driver gave up after its end was reported is handed over again. Until then its mailbox stays in
//!   use. [`CanPort::leave`] drops it.
//! - A frame that the driver refuses with an error waits, and is tried again when the task is woken, until its
//!   lifetime ends.
//! - A change of the error state is found when the task is woken: a bus-off between two wake-ups is not reported.
//! - [`PortEvent::Stalled`] is never reported.

mod driver;
mod nonblocking;
mod slots;

use core::task::{Context, Poll, Waker};

use heapless::Vec;

pub use self::driver::{Accepted, Driver, Mode, Received, Refused};
pub use self::nonblocking::{Nonblocking, WakeUp};
use self::slots::{SLOTS, Slots};
use crate::link::port::{Busy, CanPort, ErrorState, Filter, Health, LastError, Mailbox, PortEvent};
use crate::types::Frame;

/// Greatest number of filters that a port may have.
const MOST_FILTERS: usize = 32;

/// Frames that the filters reject in one poll. Then other tasks have their turn.
const LOOKS: usize = 16;

/// Port over a driver that was not written for this crate. See the table of [the module](self) for its limits.
pub struct Adapter<D> {
    driver: D,
    mode: Mode,
    filters: Vec<Filter, MOST_FILTERS>,
    slots: Slots,
    /// As of the last poll: reading it may clear the cause of the last error in the controller.
    health: Health,
    /// Error state of the last event with one.
    reported: ErrorState,
    /// Cause of the last error since the last successful transfer.
    last_error: LastError,
    /// Task that polled last.
    task: Option<Waker>,
}

impl<D: Driver> Adapter<D> {
    /// Makes a port that is off its bus.
    pub fn new(driver: D) -> Self {
        Adapter {
            driver,
            mode: Mode::Off,
            filters: Vec::new(),
            slots: Slots::default(),
            health: Health::default(),
            reported: ErrorState::default(),
            last_error: LastError::None,
            task: None,
        }
    }

    fn enter(&mut self, mode: Mode) {
        if mode != Mode::On {
            self.slots.abort_all(&mut self.driver);
        }
        self.mode = mode;
        self.driver.set_mode(mode);
        self.wake();
    }

    fn wake(&self) {
        if let Some(task) = &self.task {
            task.wake_by_ref();
        }
    }

    fn hand_over(&mut self, context: &mut Context<'_>) {
        if let Some(error) = self.slots.hand_over(&mut self.driver, context) {
            self.last_error = error;
        }
    }

    /// Takes what the driver received until it is an event. Two errors in a row end this: a driver that fails would
    /// otherwise keep the task for itself.
    fn poll_receive(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        let mut has_failed = false;
        for _ in 0..LOOKS {
            match self.driver.poll_receive(context) {
                Poll::Ready(Received::Frame { frame, stamp }) => {
                    (self.last_error, has_failed) = (LastError::None, false);
                    if self.mode != Mode::Off && self.filters.iter().any(|filter| filter.admits(frame.id())) {
                        return Poll::Ready(PortEvent::Received { frame, stamp });
                    }
                }
                Poll::Ready(Received::Overrun(lost)) => return Poll::Ready(PortEvent::Overrun { lost }),
                Poll::Ready(Received::Error(error)) => {
                    self.last_error = error;
                    if core::mem::replace(&mut has_failed, true) {
                        return Poll::Pending;
                    }
                }
                Poll::Pending => return Poll::Pending,
            }
        }
        context.waker().wake_by_ref();
        Poll::Pending
    }

    /// Reads the health of the driver. Returns whether the error state is another one than that reported last.
    fn look(&mut self) -> bool {
        let mut health = self.driver.health().unwrap_or_default();
        if health.last_error == LastError::None {
            health.last_error = self.last_error;
        }
        self.health = health;
        health.state != self.reported
    }
}

impl<D: Driver> CanPort for Adapter<D> {
    type PerMailbox<T: Default> = [T; SLOTS];

    const FILTERS: usize = D::FILTERS;

    fn set_filters(&mut self, filters: &[Filter]) {
        self.filters = filters.iter().copied().take(MOST_FILTERS).collect();
        self.driver.set_filters(&self.filters);
    }

    fn set_filter(&mut self, number: u8, filter: Filter) {
        // The runner also sets filters that have not changed. Setting them may interrupt reception.
        if let Some(own) = self.filters.get_mut(usize::from(number))
            && core::mem::replace(own, filter) != filter
        {
            self.driver.set_filters(&self.filters);
        }
    }

    fn join(&mut self) {
        self.enter(Mode::On);
    }

    fn listen(&mut self) {
        self.enter(Mode::Listening);
    }

    fn leave(&mut self) {
        self.enter(Mode::Off);
    }

    fn send(&mut self, frame: &Frame) -> Result<Mailbox, Busy> {
        if self.mode != Mode::On {
            return Err(Busy);
        }
        let mailbox = self.slots.put(frame)?;
        let task = self.task.clone();
        self.hand_over(&mut Context::from_waker(task.as_ref().unwrap_or(Waker::noop())));
        if self.slots.has_work() {
            self.wake();
        }
        Ok(mailbox)
    }

    fn abort(&mut self, mailbox: Mailbox) {
        self.slots.abort(mailbox, &mut self.driver);
        self.wake();
    }

    fn health(&self) -> Health {
        self.health
    }

    fn recover(&mut self) {
        self.driver.recover();
    }

    fn poll_event(&mut self, context: &mut Context<'_>) -> Poll<PortEvent> {
        if !self.task.as_ref().is_some_and(|task| task.will_wake(context.waker())) {
            self.task = Some(context.waker().clone());
        }
        if self.slots.take_sent(&mut self.driver, context) {
            self.last_error = LastError::None;
        }
        self.hand_over(context);
        if let Some(end) = self.slots.next_end() {
            return Poll::Ready(end);
        }
        let event = self.poll_receive(context);
        if self.look() && event.is_pending() {
            self.reported = self.health.state;
            return Poll::Ready(PortEvent::Health(self.health));
        }
        event
    }
}
