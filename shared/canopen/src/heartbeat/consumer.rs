//! Consumer of one node's heartbeat.

use crate::types::{Canonical, Duration, Instant};

/// Consumer of the heartbeat of one node.
///
/// The first heartbeat starts the monitoring. A missed heartbeat is reported once. The next heartbeat ends the miss.
///
/// The consumer time is an argument because many consumers share it. A consumer time of zero disables the monitoring.
#[doc(alias("consumer heartbeat time", "1016h"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[canonical(context = ConsumerTimes)]
pub enum Consumer {
    /// There was no heartbeat yet.
    #[default]
    Unarmed,
    /// The last heartbeat came in time.
    Armed {
        /// End of the last heartbeat.
        // An owner that polls late reports a miss late, and still knows its age.
        #[canonical(age = context.consumer.max(context.memory))]
        last: Instant,
    },
    /// A heartbeat is overdue, and was reported.
    Missed {
        /// End of the last heartbeat.
        #[canonical(age = context.memory)]
        last: Instant,
    },
}

/// Times of a [`Consumer`] that its owner knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConsumerTimes {
    /// Consumer time, as for [`Consumer::poll`]. Zero: no monitoring.
    pub consumer: Duration,
    /// Longest time for which the age of a miss has an effect on its owner.
    pub memory: Duration,
}

impl Consumer {
    /// Takes a heartbeat that ended at `at`. Returns whether it ends a miss.
    pub fn on_heartbeat(&mut self, at: Instant) -> bool {
        let resolved = matches!(self, Consumer::Missed { .. });
        *self = Consumer::Armed { last: at };
        resolved
    }

    /// Returns the instant of the last heartbeat when the next one is overdue, once.
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
}
