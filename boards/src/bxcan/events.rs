//! From the interrupts of a controller to its port: bounded, nothing lost unseen.

use core::cell::RefCell;
use core::task::{Context, Poll};

use ecss_can::link::Stamp;
use ecss_can::link::port::PortEvent;
use ecss_can::types::Frame;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::waitqueue::AtomicWaker;

use super::status::{Enables, Status};
use super::waiting::Waiting;

/// What happened on a controller and was not taken yet.
pub struct EventQueue {
    waiting: Mutex<CriticalSectionRawMutex, RefCell<Waiting>>,
    waker: AtomicWaker,
}

impl EventQueue {
    pub(super) const fn new() -> Self {
        EventQueue { waiting: Mutex::new(RefCell::new(Waiting::new())), waker: AtomicWaker::new() }
    }

    /// A frame came; when the queue is full it is counted as lost.
    pub(super) fn received(&self, frame: Frame, stamp: Stamp) {
        self.update(|waiting| waiting.received(PortEvent::Received { frame, stamp }));
    }

    /// A frame was lost before it could be read, or more than one: FOVR says no more than that.
    pub(super) fn overrun(&self) {
        self.update(Waiting::lose);
    }

    /// The result of a mailbox.
    pub(super) fn finished(&self, result: PortEvent) {
        self.update(|waiting| waiting.finished(result));
    }

    /// The error register as it is now; what may raise the error interrupt from now on.
    pub(super) fn error_status(&self, now: Status) -> Enables {
        self.update(|waiting| waiting.errors.note(now))
    }

    /// The error interrupt; `repeated`: it would have come at once again.
    pub(super) fn error_interrupt(&self, now: Status, repeated: bool) -> Enables {
        self.update(|waiting| waiting.errors.on_interrupt(now, repeated))
    }

    /// Whether such an event waits.
    pub(super) fn holds(&self, such: impl Fn(&PortEvent) -> bool) -> bool {
        self.with(|waiting| waiting.holds(such))
    }

    /// The next event.
    pub(super) fn poll(&self, cx: &mut Context<'_>) -> Poll<PortEvent> {
        self.waker.register(cx.waker());
        match self.with(Waiting::take) {
            Some(event) => Poll::Ready(event),
            None => Poll::Pending,
        }
    }

    fn update<R>(&self, change: impl FnOnce(&mut Waiting) -> R) -> R {
        let result = self.with(change);
        self.waker.wake();
        result
    }

    fn with<R>(&self, what: impl FnOnce(&mut Waiting) -> R) -> R {
        self.waiting.lock(|waiting| what(&mut waiting.borrow_mut()))
    }
}
