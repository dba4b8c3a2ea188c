//! Whose turn it is: every slave once in a period, evenly spread, so that bursts never fill a queue.

use ecss_can::nmt::NodeId;
use ecss_can::time::{Duration, Instant};

/// Slaves that straps can number: 2..=15.
pub const SLAVES: usize = 14;
const FIRST: u8 = 2;

/// Place of a slave in a round, `None` for a Node-ID that straps cannot express.
pub fn slot(node: NodeId) -> Option<usize> {
    node.get().checked_sub(FIRST).map(usize::from).filter(|slot| *slot < SLAVES)
}

/// The turn of one slave.
pub struct Turn {
    /// Whose.
    pub node: NodeId,
    /// In which round, from 0; wraps.
    pub round: u32,
}

/// Turns without end.
pub struct Round {
    period: Duration,
    began: Instant,
    round: u32,
    slot: u8,
}

impl Round {
    /// The first turn is at `now`.
    pub fn new(period: Duration, now: Instant) -> Self {
        Round { period, began: now, round: 0, slot: 0 }
    }

    /// When the next turn is.
    pub fn next(&self) -> Instant {
        let offset = self.period.as_micros() * u64::from(self.slot) / SLAVES as u64;
        self.began + Duration::from_micros(offset)
    }

    /// Take the next turn.
    pub fn take(&mut self) -> Turn {
        let node = NodeId::new(FIRST + self.slot).unwrap_or(NodeId::MASTER);
        let turn = Turn { node, round: self.round };
        self.slot += 1;
        if usize::from(self.slot) == SLAVES {
            self.slot = 0;
            self.began += self.period;
            self.round = self.round.wrapping_add(1);
        }
        turn
    }
}
