//! The time consumer: sets its clock by the Spacecraft Time PDO, tells its own in the Local Time PDO (ECSS 7.2.2).

use super::{LocalClock, Scet, Stamp};
use crate::link::{CobId, Frame};
use crate::nmt::NodeId;

/// Local time of a slave.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TimeConsumer {
    node: NodeId,
    clock: LocalClock,
}

impl TimeConsumer {
    /// A clock that starts at zero.
    pub fn new(node: NodeId) -> Self {
        TimeConsumer { node, clock: LocalClock::default() }
    }

    /// The local clock.
    pub fn clock(&self) -> &LocalClock {
        &self.clock
    }

    /// The Spacecraft Time PDO: the clock is set to it as of the end of the frame. `None` when malformed: fewer than 7
    /// bytes (CiA 301 7.2.2.1 has a longer PDO used as far as it is mapped).
    pub fn on_spacecraft_time(&mut self, frame: &Frame, stamp: Stamp) -> Option<Scet> {
        let scet = Scet::decode(frame.data())?;
        self.clock.set(scet, stamp.at);
        Some(scet)
    }

    /// The Local Time PDO that answers a SYNC: the local time at the end of that SYNC (ECSS 7.2.3k).
    pub fn on_sync(&self, stamp: Stamp) -> Frame {
        Frame::of(CobId::local_time(self.node), self.clock.at(stamp.at).encode())
    }
}
