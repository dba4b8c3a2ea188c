//! Number of slaves that a master hears, for its claim.

use super::{Heard, Peers};
use crate::types::{Duration, Instant};

impl<const N: usize> Peers<N> {
    /// Returns the number of slaves that count and were last heard on the active bus, within the consumer time.
    pub(crate) fn heard_here(&self, now: Instant, consumer: Duration) -> u8 {
        // The silence of one whose last heartbeat came elsewhere, or before a change of the bus, begins at another instant.
        let is_here = |heard: &Heard| heard.heartbeat.deadline(consumer) == Some(heard.silent_at);
        self.each_counted().filter(|(_, heard)| is_here(heard) && heard.silent_at > now).count() as u8
    }
}
