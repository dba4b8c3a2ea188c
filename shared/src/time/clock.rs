//! The local SCET clock: spacecraft time at an instant of this node.

use crate::types::{Instant, Scet};

/// Maps instants to SCET by an offset. Starts at zero at power-on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LocalClock {
    set_at: Instant,
    value: Scet,
}

impl LocalClock {
    /// It was `scet` at the instant `at` (Local SCET Set, object 2010h).
    pub fn set(&mut self, scet: Scet, at: Instant) {
        (self.set_at, self.value) = (at, scet);
    }

    /// The time at an instant before or after the clock was set (Local SCET Get, object 2011h).
    pub fn at(&self, instant: Instant) -> Scet {
        if instant >= self.set_at {
            self.value.plus(instant.since(self.set_at))
        } else {
            self.value.minus(self.set_at.since(instant))
        }
    }
}
