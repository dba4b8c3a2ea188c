//! Dwell: time that a master stays on a bus on which it hears none of its slaves.

use super::Parameters;
use crate::types::{Duration, Instant};

/// Runs from power-on, from the last switch, or from the last frame of a slave that counts, whichever was last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Dwell {
    since: Instant,
    shortest: Duration,
}

impl Dwell {
    pub const fn new(shortest: Duration) -> Dwell {
        Dwell { since: Instant::ZERO, shortest }
    }

    /// Restarts the dwell: a slave was heard, or the bus changed. An instant before the last one changes nothing.
    pub fn restart(&mut self, at: Instant) {
        self.since = self.since.max(at);
    }

    pub const fn length(&self, parameters: &Parameters) -> Duration {
        parameters.dwell(self.shortest)
    }

    /// Returns when to try the other bus. `None` while slaves are not monitored.
    pub fn end(&self, parameters: &Parameters) -> Option<Instant> {
        let is_monitoring = parameters.consumer > Duration::ZERO;
        is_monitoring.then(|| self.since + self.length(parameters))
    }

    /// Shifts the clock.
    #[cfg(feature = "model")]
    pub fn rebase(&mut self, to: &crate::types::Rebase, parameters: &Parameters) {
        self.since = to.aged(self.since, self.length(parameters));
    }
}
