//! Clock of mock boards.

use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};
use core::future::poll_fn;
use core::task::{Poll, Waker};

use crate::runner::Clock;
use crate::types::{Duration, Instant};

/// Clock that shows power-on until the test advances it. Clones show the same time.
///
/// ```
/// use async_canopen::mock::ManualClock;
/// use async_canopen::prelude::*;
/// use async_canopen::runner::Clock;
///
/// let clock = ManualClock::new();
/// clock.advance(Duration::from_millis(20));
/// assert_eq!(clock.now(), Instant::from_micros(20_000));
/// assert_eq!(clock.deadline(), None); // no task waits for it
/// ```
#[derive(Clone, Debug, Default)]
pub struct ManualClock(Rc<Time>);

#[derive(Debug, Default)]
struct Time {
    now: Cell<Instant>,
    /// Tasks that wait, each with its deadline. A task may have given up waiting: it is woken for nothing then.
    waiting: RefCell<Vec<(Instant, Waker)>>,
}

impl ManualClock {
    /// Makes a clock that shows power-on.
    pub fn new() -> Self {
        Self::default()
    }

    /// Advances the clock by `span` and wakes the tasks whose deadline has come.
    pub fn advance(&self, span: Duration) {
        let now = self.0.now.get() + span;
        self.0.now.set(now);
        let mut waiting = self.0.waiting.borrow_mut();
        waiting.iter().filter(|(deadline, _)| *deadline <= now).for_each(|(_, task)| task.wake_by_ref());
        waiting.retain(|(deadline, _)| *deadline > now);
    }

    /// Returns the earliest deadline that a task waits for. `None`: no task waits.
    pub fn deadline(&self) -> Option<Instant> {
        self.0.waiting.borrow().iter().map(|(deadline, _)| *deadline).min()
    }

    fn wake_at(&self, deadline: Instant, task: &Waker) {
        let mut waiting = self.0.waiting.borrow_mut();
        if !waiting.iter().any(|(at, other)| *at == deadline && other.will_wake(task)) {
            waiting.push((deadline, task.clone()));
        }
    }
}

impl Clock for ManualClock {
    fn now(&self) -> Instant {
        self.0.now.get()
    }

    async fn at(&self, deadline: Instant) {
        poll_fn(|context| {
            if self.now() >= deadline {
                return Poll::Ready(());
            }
            self.wake_at(deadline, context.waker());
            Poll::Pending
        })
        .await;
    }
}
