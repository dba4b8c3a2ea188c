//! Time relative to now, for the model checker: states that differ in nothing but their age become equal.

use super::{Duration, Instant};

/// Shifts the instants of a state machine so that now becomes [`Rebase::ORIGIN`].
///
/// An instant whose age does not matter any more moves to the last one that did: all later decisions stay the same.
#[derive(Clone, Copy, Debug)]
pub struct Rebase {
    now: Instant,
}

impl Rebase {
    /// Now, in every rebased state. 12 days: nothing that matters is as old.
    pub const ORIGIN: Instant = Instant::from_micros(1 << 40);

    /// Shifts `now` to [`Rebase::ORIGIN`].
    pub const fn new(now: Instant) -> Rebase {
        Rebase { now }
    }

    /// Shifts an instant that is compared with now alone: all past ones are alike.
    pub fn due(&self, at: Instant) -> Instant {
        self.aged(at, Duration::ZERO)
    }

    /// Shifts an instant whose age matters up to `horizon`. Never stays never.
    pub fn aged(&self, at: Instant, horizon: Duration) -> Instant {
        if at == Instant::NEVER {
            at
        } else if at >= self.now {
            Self::ORIGIN + at.since(self.now)
        } else {
            Self::ORIGIN - self.now.since(at).min(horizon)
        }
    }

    /// Shifts a point of a grid: a past one moves to the last one before now.
    pub fn on_grid(&self, at: Instant, period: Duration) -> Instant {
        let late = self.now.since(at).as_micros();
        let rest = late.checked_rem(period.as_micros()).unwrap_or(late);
        self.aged(at, Duration::from_micros(rest))
    }
}
