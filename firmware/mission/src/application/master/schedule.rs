//! Schedule of commands and telemetry requests: each slave has one turn in a period, in a separate part of it, so that
//! bursts never fill a queue.
//!
//! Missed turns are skipped.

use ecss_can::types::{Duration, Instant, NodeId, Periodic};

use crate::{SLAVES, slot};

/// Node-ID of the slave with the first turn.
const FIRST: u8 = 2;

/// The turn of one slave.
#[derive(Clone, Copy)]
pub struct Turn {
    /// The slave.
    pub node: NodeId,
    /// Instant of the turn.
    pub at: Instant,
    /// Turns that the slave had since power-on; wraps.
    pub count: u32,
}

/// Turns of the participating slaves.
pub struct Schedule {
    period: Duration,
    turns: [Periodic; SLAVES],
    counts: [u32; SLAVES],
    next: Option<Turn>,
}

impl Schedule {
    /// Makes a schedule without slaves.
    pub fn new(period: Duration) -> Self {
        Schedule {
            period,
            turns: core::array::from_fn(|_| Periodic::new(period)),
            counts: [0; SLAVES],
            next: None,
        }
    }

    /// Adds a slave to the schedule. A Node-ID that straps cannot set is ignored.
    pub fn start(&mut self, node: NodeId, now: Instant) {
        let Some(slot) = slot(node) else { return };
        let period = self.period.as_micros().max(1);
        let offset = Duration::from_micros(period * slot as u64 / SLAVES as u64);
        let began = Instant::from_micros(now.as_micros() / period * period);
        let first = began + offset;
        if let Some(turns) = self.turns.get_mut(slot).filter(|turns| turns.deadline().is_none()) {
            turns.start(if first > now { first } else { first + self.period });
            self.plan();
        }
    }

    /// Removes a slave from the schedule.
    pub fn stop(&mut self, node: NodeId) {
        if let Some(turns) = slot(node).and_then(|slot| self.turns.get_mut(slot)) {
            turns.stop();
            self.plan();
        }
    }

    /// Returns the next turn.
    pub fn next(&self) -> Option<Turn> {
        self.next
    }

    fn plan(&mut self) {
        let turns = self.turns.iter().zip(&self.counts).zip(FIRST..).filter_map(|((turns, count), node)| {
            Some(Turn { node: NodeId::new(node)?, at: turns.deadline()?, count: *count })
        });
        self.next = turns.min_by_key(|turn| turn.at);
    }

    /// Completes a turn at `now`. Returns the number of turns of that slave that were missed before it.
    pub fn taken(&mut self, turn: Turn, now: Instant) -> u64 {
        let Some(slot) = slot(turn.node) else { return 0 };
        if let Some(count) = self.counts.get_mut(slot) {
            *count = count.wrapping_add(1);
        }
        let missed = self.turns.get_mut(slot).and_then(|turns| turns.take(now)).unwrap_or(0);
        self.plan();
        missed
    }
}
