//! Virtual time by the clock on the wall.
//!
//! A stretch that took too long is made up for as long as it was short. Beyond that virtual time stays behind for good:
//! it runs slower, but it never jumps.

use std::time::{Duration, Instant};

use can_wire::time::Time;

/// What is made up for.
const SHORT: Duration = Duration::from_millis(250);

/// Where virtual time should be.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// When virtual time was zero, or would have been.
    began: Instant,
    behind: Duration,
}

impl Pace {
    /// Virtual time is zero now.
    pub fn new(now: Instant) -> Self {
        Pace { began: now, behind: Duration::ZERO }
    }

    /// It is `now`, and virtual time is about to become `at`. Being late for longer than a moment is accepted.
    pub fn reached(&mut self, at: Time, now: Instant) {
        let late = now.saturating_duration_since(self.instant_of(at));
        if late > SHORT {
            self.began += late;
            self.behind += late;
        }
    }

    /// When virtual time may be `at`.
    pub fn instant_of(&self, at: Time) -> Instant {
        self.began + Duration::from_micros(at.as_us())
    }

    /// How far virtual time stays behind for good.
    pub fn behind(&self) -> Duration {
        self.behind
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn virtual_time_follows_the_wall() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        pace.reached(Time::from_ms(7), start + ms(7));
        assert_eq!(pace.instant_of(Time::from_ms(8)), start + ms(8));
        assert_eq!(pace.behind(), Duration::ZERO);
    }

    #[test]
    fn a_short_delay_is_made_up_for() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        pace.reached(Time::from_ms(50), start + ms(300));
        assert_eq!(pace.instant_of(Time::from_ms(300)), start + ms(300));
        assert_eq!(pace.behind(), Duration::ZERO);
    }

    #[test]
    fn a_long_delay_stays() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        pace.reached(Time::from_ms(100), start + ms(1300));
        assert_eq!(pace.behind(), ms(1200));
        assert_eq!(pace.instant_of(Time::from_ms(120)), start + ms(1320));
        pace.reached(Time::from_ms(110), start + ms(1700));
        assert_eq!(pace.behind(), ms(1590));
    }
}
