//! A node's clock: starts at power-on and runs as fast as its crystal.

use std::rc::Rc;

use can_twin::wire::time::{TICKS_PER_US, Time};
use ecss_can::runner::Clock;
use ecss_can::types::{FineInstant, Instant};

use crate::timeline::{Sleep, Timeline};

const MILLION: i64 = 1_000_000;

/// A clock with its own drift.
#[derive(Clone, Debug)]
pub struct MockClock {
    timeline: Rc<Timeline>,
    power_on: Time,
    /// Local microseconds per second of the world.
    rate: u128,
}

impl MockClock {
    /// Starts a clock at zero at the present of the timeline; it is fast by `drift_ppm`.
    ///
    /// # Panics
    /// When the drift is a million ppm or more: a mistake in a test.
    pub fn power_on(timeline: Rc<Timeline>, drift_ppm: i32) -> Self {
        let rate = u128::try_from(MILLION + i64::from(drift_ppm)).expect("a clock runs forwards");
        assert!(rate > 0, "a clock runs forwards");
        let power_on = timeline.now();
        MockClock { timeline, power_on, rate }
    }

    /// Returns the time of this clock at an instant of the world.
    pub fn instant(&self, at: Time) -> Instant {
        let elapsed = u128::from(at.since(self.power_on).0);
        let local = elapsed * self.rate / (u128::from(TICKS_PER_US) * MILLION as u128);
        Instant::from_micros(u64::try_from(local).unwrap_or(u64::MAX))
    }

    /// As [`MockClock::instant`], with a resolution of 2^-8 µs, as a capture timer.
    pub fn fine(&self, at: Time) -> FineInstant {
        let elapsed = u128::from(at.since(self.power_on).0) * u128::from(FineInstant::PER_MICRO);
        let local = elapsed * self.rate / (u128::from(TICKS_PER_US) * MILLION as u128);
        FineInstant::from_units(u64::try_from(local).unwrap_or(u64::MAX))
    }

    /// The first instant of the world at which this clock shows `local`.
    pub fn world_time(&self, local: Instant) -> Time {
        let elapsed =
            (u128::from(local.as_micros()) * u128::from(TICKS_PER_US) * MILLION as u128).div_ceil(self.rate);
        self.power_on + Time(u64::try_from(elapsed).unwrap_or(u64::MAX))
    }

    /// The present of the world.
    pub fn timeline(&self) -> &Rc<Timeline> {
        &self.timeline
    }

    fn sleep(&self, deadline: Instant) -> Sleep {
        self.timeline.sleep_until(self.world_time(deadline))
    }
}

impl Clock for MockClock {
    fn now(&self) -> Instant {
        self.instant(self.timeline.now())
    }

    async fn at(&self, deadline: Instant) {
        self.sleep(deadline).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fast_clock_is_ahead_and_wakes_early() {
        let timeline = Timeline::new();
        timeline.advance(Time::from_ms(5));
        let clock = MockClock::power_on(timeline.clone(), 100);
        assert_eq!(clock.now(), Instant::ZERO);
        // 10 s of the world are 10 s and 1 ms on a clock that is 100 ppm fast.
        assert_eq!(clock.instant(Time::from_ms(10_005)), Instant::from_micros(10_001_000));
        assert_eq!(clock.world_time(Instant::from_micros(10_001_000)), Time::from_ms(10_005));
    }

    #[test]
    fn clock_shows_a_deadline_when_it_wakes_and_not_a_tick_before() {
        let clock = MockClock::power_on(Timeline::new(), -37);
        for us in [1, 999, 1_000_003, 86_400_000_001] {
            let at = clock.world_time(Instant::from_micros(us));
            assert_eq!(clock.instant(at), Instant::from_micros(us));
            assert_eq!(clock.instant(Time(at.0 - 1)), Instant::from_micros(us - 1));
        }
    }
}
