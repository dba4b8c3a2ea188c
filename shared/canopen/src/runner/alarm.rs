//! Timer of a task. It is armed again only if it would fire too late.

use core::pin::Pin;
use core::task::Context;

use crate::types::Instant;

/// Wakes its task at the earliest instant that it was set to, or before: a deadline that moved away is not worth
/// the work.
pub(super) struct Alarm<'a, F> {
    timer: Pin<&'a mut Option<F>>,
    at: Instant,
}

impl<'a, F: Future<Output = ()>> Alarm<'a, F> {
    /// Makes an alarm that is not set.
    pub fn new(timer: Pin<&'a mut Option<F>>) -> Self {
        Alarm { timer, at: Instant::NEVER }
    }

    /// Returns the instant at which it wakes the task.
    pub fn at(&self) -> Instant {
        self.at
    }

    /// Makes sure that the task of `context` is woken at `due`. `wait` returns a future that completes then.
    #[inline]
    pub fn set(&mut self, due: Instant, now: Instant, context: &mut Context<'_>, wait: impl FnOnce() -> F) {
        if due < self.at || self.at <= now {
            self.arm(due, context, wait);
        }
    }

    /// Sets the alarm as [`Alarm::set`], even if it would fire earlier.
    #[inline(never)] // once in many turns
    pub fn arm(&mut self, due: Instant, context: &mut Context<'_>, wait: impl FnOnce() -> F) {
        self.at = due;
        self.timer.set((due != Instant::NEVER).then(wait));
        if let Some(timer) = self.timer.as_mut().as_pin_mut()
            && timer.poll(context).is_ready()
        {
            context.waker().wake_by_ref();
        }
    }
}
