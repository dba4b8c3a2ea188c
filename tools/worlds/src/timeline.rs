//! The present of a world, and tasks that wait for an instant.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::future::Future;
use std::pin::Pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use can_twin::wire::time::Time;

/// Greatest number of steps of one kind at one instant; more mean an endless loop.
pub(crate) const MAX_STEPS_PER_INSTANT: u32 = 10_000;

/// Virtual time shared by all parts of a world. Only [`Timeline::advance`] changes it.
#[derive(Debug, Default)]
pub struct Timeline {
    now: Cell<Time>,
    /// Wakers in the order of time, then of registration.
    sleepers: RefCell<BTreeMap<(Time, u64), Waker>>,
    registrations: Cell<u64>,
    interrupts: Cell<u64>,
    /// Number of sleeps that ended at once since time advanced.
    overdue: Cell<u32>,
}

impl Timeline {
    /// Makes a timeline at time zero.
    pub fn new() -> Rc<Self> {
        Rc::default()
    }

    /// Returns the present.
    pub fn now(&self) -> Time {
        self.now.get()
    }

    /// Returns when the next sleeper wakes.
    pub fn next_wake(&self) -> Option<Time> {
        self.sleepers.borrow().keys().next().map(|(at, _)| *at)
    }

    /// Makes `now` the present and wakes all tasks that are due.
    ///
    /// # Panics
    /// When time would run backwards.
    pub fn advance(&self, now: Time) {
        assert!(now >= self.now.get(), "time runs forwards only");
        if now > self.now.replace(now) {
            self.overdue.set(0);
        }
        loop {
            let Some(entry) =
                self.sleepers.borrow_mut().first_entry().filter(|e| e.key().0 <= now).map(|e| e.remove())
            else {
                return;
            };
            entry.wake();
        }
    }

    /// Sleeps until `at`; returns at once if that has passed.
    pub fn sleep_until(self: &Rc<Self>, at: Time) -> Sleep {
        Sleep { timeline: self.clone(), at, registered: None }
    }

    /// Returns how often controllers have woken their tasks so far.
    pub fn interrupts(&self) -> u64 {
        self.interrupts.get()
    }

    /// Records that a controller wakes its task.
    pub fn interrupt(&self) {
        self.interrupts.set(self.interrupts.get() + 1);
    }

    /// Counts a sleep that ends at once.
    ///
    /// # Panics
    /// When a task requests only such sleeps, so that time would never advance.
    fn note_overdue(&self) {
        let count = self.overdue.get() + 1;
        assert!(count < MAX_STEPS_PER_INSTANT, "a task waits for what has passed, at {:?}", self.now());
        self.overdue.set(count);
    }

    fn register(&self, at: Time, waker: &Waker) -> (Time, u64) {
        let key = (at, self.registrations.get());
        self.registrations.set(key.1 + 1);
        self.sleepers.borrow_mut().insert(key, waker.clone());
        key
    }
}

/// Future of [`Timeline::sleep_until`]. Dropping it removes the waker.
#[derive(Debug)]
pub struct Sleep {
    timeline: Rc<Timeline>,
    at: Time,
    registered: Option<(Time, u64)>,
}

impl Sleep {
    fn forget(&mut self) {
        if let Some(key) = self.registered.take() {
            self.timeline.sleepers.borrow_mut().remove(&key);
        }
    }
}

impl Future for Sleep {
    type Output = ();

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        let is_first = self.registered.is_none();
        self.forget();
        if self.timeline.now() >= self.at {
            if is_first {
                self.timeline.note_overdue();
            }
            return Poll::Ready(());
        }
        let key = self.timeline.register(self.at, context.waker());
        self.registered = Some(key);
        Poll::Pending
    }
}

impl Drop for Sleep {
    fn drop(&mut self) {
        self.forget();
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use futures_util::FutureExt;

    use super::*;

    /// Given a task that waits for a deadline in the past again and again, then it is stopped, and not when time passes in between.
    #[test]
    fn a_task_that_never_lets_time_pass_is_stopped() {
        let timeline = Timeline::new();
        let wait = |times| {
            for _ in 0..times {
                timeline.sleep_until(Time(0)).now_or_never().expect("it is over at once");
            }
        };
        wait(MAX_STEPS_PER_INSTANT - 1);
        timeline.advance(Time(1));
        wait(MAX_STEPS_PER_INSTANT - 1);
        assert!(catch_unwind(AssertUnwindSafe(|| wait(1))).is_err());
    }
}
