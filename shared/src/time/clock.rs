//! The local SCET clock: spacecraft time at an instant of this node.

use super::objects::{LocalScet, SCET_SET};
use crate::types::{Address, Instant, Scet};

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

    /// Follows its objects when the time was written. Returns whether it was.
    pub fn follow(&mut self, at: Address, objects: &LocalScet, now: Instant) -> bool {
        let is_set = at.index == SCET_SET;
        if is_set {
            self.set(objects.scet_set.into(), now);
        }
        is_set
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
