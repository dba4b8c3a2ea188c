//! Consumer of one node's heartbeat.

use crate::types::{Duration, Instant};

/// Armed by the first heartbeat; one timeout event; the next heartbeat resolves it.
///
/// The consumer time is an argument because many consumers share it. A consumer time of zero disables the monitoring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Consumer {
    /// No heartbeat yet.
    #[default]
    Unarmed,
    /// Heard in time.
    Armed {
        /// The last heartbeat.
        last: Instant,
    },
    /// Overdue, and reported.
    Missed {
        /// The last heartbeat.
        last: Instant,
    },
}

impl Consumer {
    /// A heartbeat ended at `at`. Returns whether it ends a miss.
    pub fn on_heartbeat(&mut self, at: Instant) -> bool {
        let resolved = matches!(self, Consumer::Missed { .. });
        *self = Consumer::Armed { last: at };
        resolved
    }

    /// Returns the instant of the last heartbeat, once, when the next one is overdue.
    pub fn poll(&mut self, now: Instant, time: Duration) -> Option<Instant> {
        match (*self, self.deadline(time)) {
            (Consumer::Armed { last }, Some(deadline)) if deadline <= now => {
                *self = Consumer::Missed { last };
                Some(last)
            }
            _ => None,
        }
    }

    /// Returns when the next heartbeat is overdue.
    pub fn deadline(&self, time: Duration) -> Option<Instant> {
        match *self {
            Consumer::Armed { last } if time > Duration::ZERO => Some(last + time),
            _ => None,
        }
    }

    /// Returns when the last heartbeat ended.
    pub const fn last(&self) -> Option<Instant> {
        match *self {
            Consumer::Unarmed => None,
            Consumer::Armed { last } | Consumer::Missed { last } => Some(last),
        }
    }

    /// Returns whether a heartbeat is missed now.
    pub fn is_missed(&self) -> bool {
        matches!(self, Consumer::Missed { .. })
    }

    /// Shifts the clock. `memory`: how long the age of a miss matters.
    #[cfg(feature = "model")]
    pub fn rebase(&mut self, to: &crate::types::Rebase, time: Duration, memory: Duration) {
        match self {
            Consumer::Unarmed => {}
            Consumer::Armed { last } => *last = to.aged(*last, time),
            Consumer::Missed { last } => *last = to.aged(*last, memory),
        }
    }
}
