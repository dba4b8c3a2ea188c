//! Time relative to now, for the model checker: states that differ only in age become equal.

use super::{Duration, Instant};

/// Shifts the instants of a state machine so that now becomes [`Rebase::ORIGIN`].
///
/// An instant whose age has no effect any more moves to the last one whose age has. So all later decisions stay the
/// same.
#[derive(Clone, Copy, Debug)]
pub struct Rebase {
    now: Instant,
}

impl Rebase {
    /// The present in every rebased state: 12 days. No age that has an effect is as long.
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
