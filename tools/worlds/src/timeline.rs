//! The present of a world, and who waits for the future.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::future::Future;
use std::pin::Pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use can_wire::time::Time;

/// Steps of one kind at one instant, above which something runs without end.
pub(crate) const MAX_STEPS_PER_INSTANT: u32 = 10_000;

/// Virtual time shared by everything in a world. It moves only when told to.
#[derive(Debug, Default)]
pub struct Timeline {
    now: Cell<Time>,
    /// Wakes in the order of time, then of registration.
    sleepers: RefCell<BTreeMap<(Time, u64), Waker>>,
    registrations: Cell<u64>,
    interrupts: Cell<u64>,
    /// Sleeps that were over at once since time moved.
    overdue: Cell<u32>,
}

impl Timeline {
    /// At the start of time.
    pub fn new() -> Rc<Self> {
        Rc::default()
    }

    /// The present.
    pub fn now(&self) -> Time {
        self.now.get()
    }

    /// When the next sleeper wakes.
    pub fn next_wake(&self) -> Option<Time> {
        self.sleepers.borrow().keys().next().map(|(at, _)| *at)
    }

    /// Makes `now` the present and wakes everybody whose time has come.
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

    /// Sleeps until `at`; at once when that has passed.
    pub fn sleep_until(self: &Rc<Self>, at: Time) -> Sleep {
        Sleep { timeline: self.clone(), at, registered: None }
    }

    /// How often a controller called its task so far.
    pub fn interrupts(&self) -> u64 {
        self.interrupts.get()
    }

    /// A controller calls its task.
    pub fn interrupt(&self) {
        self.interrupts.set(self.interrupts.get() + 1);
    }

    /// Counts a sleep that is over at once.
    ///
    /// # Panics
    /// When a task asks for no other: it would never let time pass.
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

/// Future of [`Timeline::sleep_until`]. Dropped, it leaves no trace.
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
