//! Periodic timer on a fixed grid.

use crate::types::{Canonical, Duration, Instant};

/// Timer that is due every period, on the grid of its start. A late poll does not move the grid.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Periodic {
    period: Duration,
    #[canonical(grid = self.period)]
    next: Option<Instant>,
}

impl Periodic {
    /// Makes a timer that is stopped. With a period of zero it never starts.
    pub const fn new(period: Duration) -> Self {
        Periodic { period, next: None }
    }

    /// Starts the timer: due at `now`, then every period.
    pub fn start(&mut self, now: Instant) {
        self.next = (self.period > Duration::ZERO).then_some(now);
    }

    /// Starts the timer: due a period from `now`, then every period.
    pub fn restart(&mut self, now: Instant) {
        self.start(now + self.period);
    }

    /// Stops the timer: it is never due.
    pub fn stop(&mut self) {
        self.next = None;
    }

    /// Returns whether the timer is due. If so, it is next due at the next point of its grid after `now`. Missed
    /// points are skipped.
    pub fn due(&mut self, now: Instant) -> bool {
        self.take(now).is_some()
    }

    /// Works as [`Periodic::due`]. Returns the number of points that were skipped.
    pub fn take(&mut self, now: Instant) -> Option<u64> {
        let next = self.next.filter(|next| *next <= now)?;
        let period = self.period.as_micros();
        // In 32 bits: whoever was not polled for an hour skips the rest the next time.
        let late = now.since(next).as_micros().min(u64::from(u32::MAX)) as u32;
        let skipped = late.checked_div(period.min(u64::from(u32::MAX)) as u32).unwrap_or(0);
        self.next = Some(next + self.period.times(skipped.saturating_add(1)));
        Some(u64::from(skipped))
    }

    /// Returns the period. Zero: never due.
    pub const fn period(&self) -> Duration {
        self.period
    }

    /// Moves the grid by `us` microseconds. A negative value moves it earlier.
    pub fn shift(&mut self, us: i32) {
        if let Some(next) = &mut self.next {
            *next = Instant::from_micros(next.as_micros().wrapping_add_signed(us.into()));
        }
    }

    /// Returns whether the timer never starts, or is due within two periods, or was due less than two periods ago.
    pub fn is_on_schedule(&self, now: Instant) -> bool {
        let (now, period) = (now.as_micros(), self.period.as_micros());
        let is_near = |next: Instant| next.as_micros().abs_diff(now) / 2 < period;
        period == 0 || self.next.is_some_and(is_near)
    }

    /// Returns when the timer is due next.
    pub fn deadline(&self) -> Option<Instant> {
        self.next
    }
}
