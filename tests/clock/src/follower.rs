//! Estimators that can follow a master: the clock of the product, and others to compare it with.

use ecss_can::time::LocalClock;
use ecss_can::time::TimeSource;
use ecss_can::types::{FineInstant, FineScet};

/// A clock that is disciplined by pairs.
pub trait Follower {
    /// At the instant `at` it was `scet`; this is known since `now`.
    fn pair(&mut self, at: FineInstant, scet: FineScet, source: TimeSource, now: FineInstant);

    /// Spacecraft time at an instant.
    fn at(&self, at: FineInstant) -> FineScet;

    /// Reported bound of the error, nanoseconds.
    fn bound(&self, now: FineInstant) -> f64;
}

impl Follower for LocalClock {
    fn pair(&mut self, at: FineInstant, scet: FineScet, source: TimeSource, now: FineInstant) {
        self.discipline(at, scet, source, now);
    }

    fn at(&self, at: FineInstant) -> FineScet {
        LocalClock::at(self, at)
    }

    fn bound(&self, now: FineInstant) -> f64 {
        self.quality(now).bound_ns.into()
    }
}
