//! Between the interrupts of a controller and its port: events, bounded, nothing lost unseen, and the frame that waits.

use core::cell::Cell;
use core::task::{Context, Poll, Waker};

use ecss_can::link::port::{Mailbox, PortEvent};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;

use super::held::Held;
use super::waiting::Waiting;

/// What happened on a controller and was not taken yet, who takes it, and what its transmit interrupt has to request.
pub struct EventQueue {
    queue: Mutex<CriticalSectionRawMutex, Queue>,
    held: Mutex<CriticalSectionRawMutex, Cell<Held>>,
}

struct Queue {
    waiting: Waiting,
    /// Task that takes the events. With `WakerRegistration` of embassy-sync the row `rx.interrupt_to_dictionary_median_accelerated`
    /// is 2.7 % higher and `rx.interrupt_to_dictionary_median` misses its target. With `AtomicWaker` the latter is 2.7 % higher.
    task: Option<Waker>,
}

impl EventQueue {
    pub(super) const fn new() -> Self {
        EventQueue {
            queue: Mutex::new(Queue { waiting: Waiting::new(), task: None }),
            held: Mutex::new(Cell::new(Held::NOTHING)),
        }
    }

    /// Adds what an interrupt found. Wakes the task once.
    #[inline]
    pub(super) fn update<R>(&self, change: impl FnOnce(&mut Waiting) -> R) -> R {
        self.with(|queue| {
            let result = change(&mut queue.waiting);
            if let Some(task) = &queue.task {
                task.wake_by_ref();
            }
            result
        })
    }

    /// Adds what the task itself found. It takes events next, so it is not woken.
    pub(super) fn note(&self, change: impl FnOnce(&mut Waiting)) {
        self.with(|queue| change(&mut queue.waiting));
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
            self.update(|waiting| waiting.finished(PortEvent::Failed { mailbox }));
        }
        waited
    }

    /// Whether such an event waits.
    pub(super) fn holds(&self, such: impl Fn(&PortEvent) -> bool) -> bool {
        self.with(|queue| queue.waiting.holds(such))
    }

    /// Takes the next event. While there is none, the task is woken at the next one.
    #[inline]
    pub(super) fn poll(&self, context: &Context<'_>) -> Poll<PortEvent> {
        self.with(|queue| match queue.waiting.take() {
            Some(event) => Poll::Ready(event),
            None => {
                if !queue.task.as_ref().is_some_and(|task| task.will_wake(context.waker())) {
                    queue.task = Some(context.waker().clone());
                }
                Poll::Pending
            }
        })
    }

    fn held<R>(&self, what: impl FnOnce(&mut Held) -> R) -> R {
        self.held.lock(|cell| {
            let mut held = cell.get();
            let result = what(&mut held);
            cell.set(held);
            result
        })
    }

    #[inline]
    fn with<R>(&self, what: impl FnOnce(&mut Queue) -> R) -> R {
        // SAFETY: no function of this type calls another that takes the queue from within, nor lets a caller do so: what they
        // are given sees the queue's parts only. A waker only marks its task.
        unsafe { self.queue.lock_mut(what) }
    }
}
