//! SYNC object: producer and message (CiA 301 7.2.5, ECSS 6.3, 6.9).

use crate::link::{CobId, Frame};
use crate::time::{Duration, Instant, Periodic};

/// The SYNC message, without counter (object 1019h is 0).
pub fn encode() -> Frame {
    Frame::of(CobId::SYNC, [])
}

/// Whether it is a SYNC: no data, or the one counter byte of producers that number theirs.
pub fn is_well_formed(frame: &Frame) -> bool {
    frame.dlc() <= 1
}

/// Producer (objects 1005h, 1006h).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Producer {
    timer: Periodic,
}

impl Producer {
    /// Silent until started. A communication cycle period of zero keeps it silent.
    pub const fn new(period: Duration) -> Self {
        Producer { timer: Periodic::new(period) }
    }

    /// The first SYNC is due a period from now.
    pub fn start(&mut self, now: Instant) {
        self.timer.restart(now);
    }

    /// The SYNC, when it is due.
    pub fn poll(&mut self, now: Instant) -> Option<Frame> {
        self.timer.due(now).then(encode)
    }

    /// When the next one is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline()
    }
}
