//! From the interrupts of a controller to its port: bounded, nothing lost unseen.

use core::cell::RefCell;
use core::task::{Context, Poll};

use ecss_can::link::Frame;
use ecss_can::link::port::{MAILBOXES, PortEvent};
use ecss_can::time::Stamp;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::waitqueue::AtomicWaker;
use heapless::Deque;

use super::status::{Enables, ErrorLog, Status};

/// Received frames that may wait for the task: 1.5 ms of the shortest frames, 3.5 ms of those with 8 bytes.
const FRAMES: usize = 32;

/// What happened on a controller and was not taken yet.
pub struct EventQueue {
    waiting: Mutex<CriticalSectionRawMutex, RefCell<Waiting>>,
    waker: AtomicWaker,
}

struct Waiting {
    /// In the order of time. A mailbox is not used again before its result was taken, so the places that frames leave
    /// free always suffice for results.
    events: Deque<PortEvent, { FRAMES + MAILBOXES }>,
    lost: u16,
    errors: ErrorLog,
}

impl EventQueue {
    pub(super) const fn new() -> Self {
        let waiting = Waiting { events: Deque::new(), lost: 0, errors: ErrorLog::new() };
        EventQueue { waiting: Mutex::new(RefCell::new(waiting)), waker: AtomicWaker::new() }
    }

    /// A frame came; when the queue is full it is counted as lost.
    pub(super) fn received(&self, frame: Frame, stamp: Stamp) {
        self.update(|waiting| {
            if waiting.events.len() >= FRAMES
                || waiting.events.push_back(PortEvent::Received { frame, stamp }).is_err()
            {
                waiting.lost = waiting.lost.saturating_add(1);
            }
        });
    }

    /// A frame was lost before it could be read, or more than one: FOVR says no more than that.
    pub(super) fn overrun(&self) {
        self.update(|waiting| waiting.lost = waiting.lost.saturating_add(1));
    }

    /// The result of a mailbox.
    pub(super) fn finished(&self, result: PortEvent) {
        self.update(|waiting| {
            let taken = waiting.events.push_back(result).is_ok();
            debug_assert!(taken, "a mailbox was used again before its result was taken");
        });
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
        self.with(|waiting| waiting.events.iter().any(such))
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

impl Waiting {
    fn take(&mut self) -> Option<PortEvent> {
        if let Some(health) = self.errors.take() {
            return Some(PortEvent::Health(health));
        }
        if self.lost > 0 {
            return Some(PortEvent::Overrun { lost: core::mem::take(&mut self.lost) });
        }
        self.events.pop_front()
    }
}
