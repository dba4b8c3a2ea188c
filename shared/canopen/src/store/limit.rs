//! Limit of the number of saves: a client that saves in a loop must not wear out the flash.

use crate::types::{Duration, Instant};

/// Saves allowed in a row.
const BURST: u32 = 10;
/// Time after which one more save is allowed.
const INTERVAL: Duration = Duration::from_millis(6 * 60 * 1_000);

/// Allows ten saves in a row, then one every six minutes. That is at most twenty in any hour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SaveLimit {
    /// An interval later for each save. At most `BURST` intervals in the future.
    earned_until: Instant,
}

impl SaveLimit {
    /// Makes a limit as at power-on: all ten saves are left.
    pub const fn new() -> SaveLimit {
        SaveLimit { earned_until: Instant::ZERO }
    }

    /// Returns whether a save is allowed at `now`.
    pub fn allows(&self, now: Instant) -> bool {
        self.earned_until.since(now) <= INTERVAL.times(BURST - 1)
    }

    /// Counts a save.
    pub fn on_save(&mut self, now: Instant) {
        self.earned_until = self.earned_until.max(now) + INTERVAL;
    }
}

impl Default for SaveLimit {
    fn default() -> Self {
        Self::new()
    }
}
