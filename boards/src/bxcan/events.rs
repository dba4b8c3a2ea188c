//! Between the interrupts of a controller and its port: events, bounded, nothing lost unseen, and the frame that waits.

use core::cell::{Cell, RefCell};
use core::task::{Context, Poll};

use ecss_can::link::Stamp;
use ecss_can::link::port::{Mailbox, PortEvent};
use ecss_can::types::Frame;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::waitqueue::AtomicWaker;

use super::held::Held;
use super::status::{Enables, Status};
use super::waiting::Waiting;

/// What happened on a controller and was not taken yet, and what its transmit interrupt has to request.
pub struct EventQueue {
    waiting: Mutex<CriticalSectionRawMutex, RefCell<Waiting>>,
    waker: AtomicWaker,
    held: Mutex<CriticalSectionRawMutex, Cell<Held>>,
}

impl EventQueue {
    pub(super) const fn new() -> Self {
        EventQueue {
            waiting: Mutex::new(RefCell::new(Waiting::new())),
            waker: AtomicWaker::new(),
            held: Mutex::new(Cell::new(Held::NOTHING)),
        }
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

    /// Whether a frame waits in its mailbox.
    pub(super) fn holds_frame(&self) -> bool {
        self.held(|held| held.waits())
    }

    /// A frame waits in its mailbox. Returns the mailbox to request if those before it have `ended` already.
    pub(super) fn hold(&self, frame: Held, ended: impl Fn(usize) -> bool) -> Option<Mailbox> {
        self.held(|held| {
            *held = frame;
            held.end(ended)
        })
    }

    /// Mailboxes `ended`. Returns the mailbox to request now.
    pub(super) fn ended(&self, ended: impl Fn(usize) -> bool) -> Option<Mailbox> {
        self.held(|held| held.end(ended))
    }

    /// Gives up the frame that waits in this mailbox and reports it. Returns whether it waited.
    pub(super) fn cancel(&self, mailbox: Mailbox) -> bool {
        let waited = self.held(|held| held.cancel(mailbox));
        if waited {
            self.finished(PortEvent::Failed { mailbox });
        }
        waited
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

    fn held<R>(&self, what: impl FnOnce(&mut Held) -> R) -> R {
        self.held.lock(|cell| {
            let mut held = cell.get();
            let result = what(&mut held);
            cell.set(held);
            result
        })
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
