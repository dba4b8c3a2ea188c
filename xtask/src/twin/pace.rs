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

    /// Until when virtual time, which is at `virtual_now`, may run at once.
    pub fn due(&mut self, now: Instant, virtual_now: Time) -> Time {
        let due = now.saturating_duration_since(self.began);
        let late = due.saturating_sub(Duration::from_micros(virtual_now.as_us()));
        if late > SHORT {
            self.began += late;
            self.behind += late;
            return virtual_now + Time(1);
        }
        Time::from_us(due.as_micros() as u64)
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
        assert_eq!(pace.due(start, Time::ZERO), Time::ZERO);
        assert_eq!(pace.due(start + ms(7), Time::from_ms(6)), Time::from_ms(7));
        assert_eq!(pace.instant_of(Time::from_ms(8)), start + ms(8));
        assert_eq!(pace.behind(), Duration::ZERO);
    }

    #[test]
    fn a_short_delay_is_made_up_for() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        assert_eq!(pace.due(start + ms(300), Time::from_ms(50)), Time::from_ms(300));
        assert_eq!(pace.behind(), Duration::ZERO);
    }

    #[test]
    fn a_long_delay_stays_and_nothing_is_skipped() {
        let start = Instant::now();
        let mut pace = Pace::new(start);
        assert_eq!(pace.due(start + ms(1300), Time::from_ms(100)), Time::from_ms(100) + Time(1));
        assert_eq!(pace.behind(), ms(1200));
        assert_eq!(pace.due(start + ms(1310), Time::from_ms(100)), Time::from_ms(110));
        assert_eq!(pace.instant_of(Time::from_ms(120)), start + ms(1320));
        assert_eq!(pace.due(start + ms(1700), Time::from_ms(110)), Time::from_ms(110) + Time(1));
        assert_eq!(pace.behind(), ms(1590));
    }
}
