//! Periodic timer on a fixed grid.

use crate::types::{Canonical, Duration, Instant};

/// Longest time by which a timer may be due later than a period from now: heartbeats that are sent late, and a poll for a
/// frame that waited.
const SLACK: Duration = Duration::from_millis(100);

/// Longest time for which no timer is polled.
const LONGEST_AGO: Duration = Duration::from_micros(u32::MAX as u64);

/// Timer that is due every period, on the grid of its start. A late poll does not move the grid.
///
/// The instant at which it is due is bounded. One that is later than a period and 100 ms, or was 71 minutes ago, has a flipped
/// bit: the timer is due at the next poll, and its grid begins there.
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
        self.confine(now);
        let next = self.next.filter(|next| *next <= now)?;
        let period = self.period.as_micros();
        // In 32 bits: it is less than 71 minutes.
        let late = now.since(next).as_micros() as u32;
        let skipped = late.checked_div(period.min(u64::from(u32::MAX)) as u32).unwrap_or(0);
        self.next = Some(next + self.period.times(skipped.saturating_add(1)));
        Some(u64::from(skipped))
    }

    /// Makes the timer due at `now` if it is due outside of its bounds: a bit of it flipped.
    pub fn confine(&mut self, now: Instant) {
        if let Some(next) = &mut self.next
            && (next.since(now) > self.period + SLACK || now.since(*next) > LONGEST_AGO)
        {
            *next = now;
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(250);
    /// A start with bits in all parts: 13 hours after power-on.
    const START: Instant = Instant::from_micros(46_912_496_118);

    /// Given a timer in its third period, when any bit of the next instant flips, then the timer is due within a period and
    /// 100 ms of that instant, and every period from then on.
    #[test]
    fn a_flipped_bit_delays_a_timer_by_a_period_at_most() {
        for bit in 0..64 {
            let mut timer = Periodic::new(PERIOD);
            timer.restart(START);
            let (first, second) = (START + PERIOD, START + PERIOD.times(2));
            assert!(timer.due(first), "bit {bit}");
            timer.next = timer.next.map(|next| Instant::from_micros(next.as_micros() ^ 1 << bit));
            // The node wakes at the instant that it knew before.
            let mut now = second;
            while !timer.due(now) {
                now += Duration::from_millis(1);
                assert!(now <= second + PERIOD + SLACK, "bit {bit}");
            }
            assert!(!timer.due(now), "bit {bit}: twice at once");
            assert!(timer.deadline().is_some_and(|next| next <= now + PERIOD), "bit {bit}");
        }
    }
}
