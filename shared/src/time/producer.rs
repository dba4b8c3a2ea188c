//! The time producer: Spacecraft Time PDO of the master (ECSS 7.2.2).
//!
//! Apart from the SYNC producer (ECSS 7.2.3d).

use super::LocalClock;
use crate::types::{CobId, Duration, Frame, Instant, NodeId, Periodic, Scet};

/// The Spacecraft Time PDO, the only one of a system (ECSS 7.2.2d): 181h.
pub fn encode(scet: Scet) -> Frame {
    Frame::of(CobId::local_time(NodeId::MASTER), scet.encode())
}

/// Sends the local time of the master every period.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TimeProducer {
    timer: Periodic,
}

impl TimeProducer {
    /// Silent until started. A period of zero keeps it silent.
    pub const fn new(period: Duration) -> Self {
        TimeProducer { timer: Periodic::new(period) }
    }

    /// The first is due a period from now.
    pub fn start(&mut self, now: Instant) {
        self.timer.restart(now);
    }

    /// The Spacecraft Time PDO, when it is due.
    pub fn poll(&mut self, now: Instant, clock: &LocalClock) -> Option<Frame> {
        self.timer.due(now).then(|| encode(clock.at(now)))
    }

    /// When the next one is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline()
    }
}
