//! Runs virtual time in real time.
//!
//! A short delay is caught up. A long one is not: virtual time then stays behind permanently. It may run slower, but it
//! never jumps.

use std::fmt;
use std::time::{Duration, Instant};

use can_twin::wire::time::Time;

/// Longest delay that is caught up.
const SHORT: Duration = Duration::from_millis(250);

/// Relation of virtual time to real time.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Instant at which virtual time was, or would have been, zero.
    began: Instant,
    /// Permanent delay of virtual time.
    pub behind: Duration,
}

impl Pace {
    /// Starts with virtual time zero now.
    pub fn new(now: Instant) -> Self {
        Pace { began: now, behind: Duration::ZERO }
    }

    /// Records that virtual time becomes `at` at the real time `now`. A long delay becomes permanent.
    pub fn reached(&mut self, at: Time, now: Instant) {
        let late = now.saturating_duration_since(self.instant_of(at));
        if late > SHORT {
            self.began += late;
            self.behind += late;
        }
    }

    /// Returns the instant at which virtual time may become `at`.
    pub fn instant_of(&self, at: Time) -> Instant {
        self.began + Duration::from_micros(at.as_us())
    }
}

/// Time between two reports of a growing lag.
const BETWEEN_REPORTS: Duration = Duration::from_secs(10);

/// Decides when a lag is reported: at once when it begins, then every [`BETWEEN_REPORTS`] while it grows.
#[derive(Clone, Copy, Debug, Default)]
pub struct LagReporter {
    /// Time and lag of the last report.
    last: Option<(Instant, Duration)>,
}

/// A lag to be reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// Permanent delay of virtual time.
    pub behind: Duration,
    /// Time since the last report, and the share of it by which virtual time advanced; `None` in the first report.
    pub speed: Option<(Duration, f64)>,
}

impl LagReporter {
    /// Returns the report that is due `now`, if any.
    pub fn due(&mut self, behind: Duration, now: Instant) -> Option<Lag> {
        let speed = match self.last {
            None if behind.is_zero() => return None,
            None => None,
            Some((at, before)) => {
                let span = now.saturating_duration_since(at);
                if behind <= before || span < BETWEEN_REPORTS {
                    return None;
                }
                let lost = (behind - before).as_secs_f64();
                Some((span, (1.0 - lost / span.as_secs_f64()).max(0.0)))
            }
        };
        self.last = Some((now, behind));
        Some(Lag { behind, speed })
    }
}

impl fmt::Display for Lag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "virtual time is {:.1} s behind the clock on the wall", self.behind.as_secs_f64())?;
        match self.speed {
            None => f.write_str(
                ": this computer is too slow or was paused. Nothing is skipped, everything just takes longer",
            ),
            Some((span, speed)) => {
                write!(f, ": in the last {:.0} s it ran at {:.0} % of it", span.as_secs_f64(), 100.0 * speed)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    /// Given delays of virtual time, then a short one is caught up and a long one is permanent. Each step: virtual
    /// time, real time in ms after the start, the instant of a later time, and the delay.
    #[test]
    fn virtual_time_follows_the_wall_and_only_a_long_delay_stays() {
        let start = Instant::now();
        for (what, steps, later, expected, behind) in [
            ("no delay", &[(7, 7)][..], 8, 8, 0),
            ("a short delay is made up for", &[(50, 300)], 300, 300, 0),
            ("a long delay stays", &[(100, 1300)], 120, 1320, 1200),
            ("two long delays stay", &[(100, 1300), (110, 1700)], 110, 1700, 1590),
        ] {
            let mut pace = Pace::new(start);
            steps.iter().for_each(|(at, wall)| pace.reached(Time::from_ms(*at), start + ms(*wall)));
            assert_eq!(pace.instant_of(Time::from_ms(later)), start + ms(expected), "{what}");
            assert_eq!(pace.behind, ms(behind), "{what}");
        }
    }

    #[test]
    fn growing_lag_is_reported_every_ten_seconds() {
        let start = Instant::now();
        let mut reporter = LagReporter::default();
        assert_eq!(reporter.due(ms(0), start), None);
        let first = reporter.due(ms(300), start + ms(1000)).expect("at once");
        assert!(first.to_string().contains("0.3 s behind the clock on the wall: this computer is too slow"));
        assert_eq!(reporter.due(ms(900), start + ms(10_999)), None, "not yet");
        let second = reporter.due(ms(4300), start + ms(11_000)).expect("10 s later");
        assert_eq!(second, Lag { behind: ms(4300), speed: Some((ms(10_000), 0.6)) });
        let text =
            "virtual time is 4.3 s behind the clock on the wall: in the last 10 s it ran at 60 % of it";
        assert_eq!(second.to_string(), text);
        assert!(reporter.due(ms(9000), start + ms(21_000)).is_some());
    }

    #[test]
    fn lag_that_stays_is_reported_once() {
        let start = Instant::now();
        let mut reporter = LagReporter::default();
        assert!(reporter.due(ms(300), start).is_some());
        assert_eq!(reporter.due(ms(300), start + ms(60_000)), None);
    }
}
