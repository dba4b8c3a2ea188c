//! Clock of a node: microseconds of its own crystal.

use can_wire::time::{TICKS_PER_US, Time};
use ecss_can::types::Instant;

/// Clock of a node. It counts from the beginning of the run: machines need differences alone.
#[derive(Clone, Copy, Debug)]
pub struct NodeClock {
    /// Microseconds of the node in a tick of the run.
    rate: f64,
}

impl NodeClock {
    /// Makes the clock of a crystal that runs fast by `ppm` parts per million.
    pub fn new(ppm: f64) -> NodeClock {
        NodeClock { rate: (1.0 + ppm * 1e-6) / TICKS_PER_US as f64 }
    }

    /// Returns what the clock shows at `at`, rounded down.
    pub fn show(&self, at: Time) -> Instant {
        Instant::from_micros((at.0 as f64 * self.rate) as u64)
    }

    /// Returns when the clock shows `at`.
    pub fn time(&self, at: Instant) -> Time {
        Time((at.as_micros() as f64 / self.rate).ceil() as u64)
    }
}
