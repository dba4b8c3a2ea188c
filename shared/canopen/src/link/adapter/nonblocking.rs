//! Driver over the trait `embedded_can::nb::Can`.

use core::task::{Context, Poll};

use embassy_sync::waitqueue::AtomicWaker;
use embedded_can::nb::Can;
use embedded_can::{Error as _, ErrorKind, Frame as _, Id, StandardId};

use super::driver::{Accepted, Driver, Mode, Received, Refused};
use crate::link::Stamp;
use crate::link::port::{Health, LastError};
use crate::types::{CobId, Frame, Instant};

/// Wakes the task of a bus from the interrupts of its controller.
///
/// A driver of `embedded_can::nb` has no wakers. The interrupt handlers for a received frame, for a free transmit
/// mailbox and for a change of the error state call [`WakeUp::notify`]. A handler that does not read the frame has to
/// disable its interrupt, which would otherwise occur again at once. Without such interrupts, a task calls it
/// periodically: the node answers late by up to this period.
pub struct WakeUp {
    task: AtomicWaker,
}

impl WakeUp {
    /// Makes one that no task waits for.
    pub const fn new() -> Self {
        WakeUp { task: AtomicWaker::new() }
    }

    /// Wakes the task of the bus. May be called from any interrupt.
    pub fn notify(&self) {
        self.task.wake();
    }
}

impl Default for WakeUp {
    fn default() -> Self {
        Self::new()
    }
}

/// Driver over any `embedded_can::nb::Can`.
///
/// The trait has two methods, `transmit` and `receive`. So this driver has no results of transmissions, no abort, no
/// overruns beyond `ErrorKind::Overrun`, and stamps of the instant at which a frame is read. A controller has more
/// than the trait: give the adapter its error state, its modes and its recovery by [`Nonblocking::with_health`],
/// [`Nonblocking::with_mode`] and [`Nonblocking::with_recovery`].
///
/// ```no_run
/// use async_canopen::link::adapter::{Adapter, Nonblocking, WakeUp};
/// use async_canopen::types::Instant;
/// # fn example<C: embedded_can::nb::Can>(can: C, now: fn() -> Instant) {
/// static CAN: WakeUp = WakeUp::new(); // its interrupt handlers call `CAN.notify()`
/// let port = Adapter::new(Nonblocking::new(can, &CAN, now));
/// # }
/// ```
pub struct Nonblocking<C> {
    can: C,
    wake_up: &'static WakeUp,
    now: fn() -> Instant,
    health: fn(&C) -> Option<Health>,
    set_mode: fn(&mut C, Mode),
    recover: fn(&mut C),
}

impl<C: Can> Nonblocking<C> {
    /// Makes a driver. `now` returns the present instant on the clock of the node.
    pub fn new(can: C, wake_up: &'static WakeUp, now: fn() -> Instant) -> Self {
        Nonblocking { can, wake_up, now, health: |_| None, set_mode: |_, _| {}, recover: |_| {} }
    }

    /// Adds a function that reads error state and counters. Without it the node takes the controller for error active.
    pub fn with_health(self, health: fn(&C) -> Option<Health>) -> Self {
        Nonblocking { health, ..self }
    }

    /// Adds a function that joins the bus, leaves it, or only listens. Without it the controller acknowledges frames
    /// from its start on.
    pub fn with_mode(self, set_mode: fn(&mut C, Mode)) -> Self {
        Nonblocking { set_mode, ..self }
    }

    /// Adds a function that begins the recovery from bus-off, for a controller that does not recover by itself.
    pub fn with_recovery(self, recover: fn(&mut C)) -> Self {
        Nonblocking { recover, ..self }
    }
}

impl<C: Can> Driver for Nonblocking<C> {
    fn transmit(&mut self, frame: &Frame, context: &mut Context<'_>) -> Result<Accepted, Refused> {
        self.wake_up.task.register(context.waker());
        let own = StandardId::new(frame.id().raw()).and_then(|id| C::Frame::new(id, frame.data()));
        let own = own.ok_or(Refused::Error(LastError::None))?;
        match self.can.transmit(&own) {
            Ok(replaced) => Ok(Accepted::Unfollowed { replaced: replaced.as_ref().and_then(classic) }),
            Err(nb::Error::WouldBlock) => Err(Refused::Full),
            Err(nb::Error::Other(error)) => Err(Refused::Error(cause(error.kind()))),
        }
    }

    fn poll_receive(&mut self, context: &mut Context<'_>) -> Poll<Received> {
        // Before looking: a frame that arrives meanwhile wakes the task again.
        self.wake_up.task.register(context.waker());
        loop {
            return match self.can.receive() {
                Ok(frame) => {
                    let Some(frame) = classic(&frame) else { continue };
                    Poll::Ready(Received::Frame { frame, stamp: Stamp::interrupt((self.now)()) })
                }
                Err(nb::Error::WouldBlock) => Poll::Pending,
                Err(nb::Error::Other(error)) if error.kind() == ErrorKind::Overrun => {
                    Poll::Ready(Received::Overrun(1))
                }
                Err(nb::Error::Other(error)) => Poll::Ready(Received::Error(cause(error.kind()))),
            };
        }
    }

    fn now(&self) -> Instant {
        (self.now)()
    }

    fn health(&self) -> Option<Health> {
        (self.health)(&self.can)
    }

    fn set_mode(&mut self, mode: Mode) {
        (self.set_mode)(&mut self.can, mode);
    }

    fn recover(&mut self) {
        (self.recover)(&mut self.can);
    }
}

/// A data frame with an identifier of 11 bits; `None` for any other frame.
fn classic(frame: &impl embedded_can::Frame) -> Option<Frame> {
    let Id::Standard(id) = frame.id() else { return None };
    if frame.is_remote_frame() {
        return None;
    }
    Frame::new(CobId::new(id.as_raw())?, frame.data()).ok()
}

/// The trait does not distinguish the two bit errors.
fn cause(kind: ErrorKind) -> LastError {
    match kind {
        ErrorKind::Bit => LastError::BitDominant,
        ErrorKind::Stuff => LastError::Stuff,
        ErrorKind::Crc => LastError::Crc,
        ErrorKind::Form => LastError::Form,
        ErrorKind::Acknowledge => LastError::Ack,
        _ => LastError::None,
    }
}
