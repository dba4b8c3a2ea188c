//! Schedule of commands and telemetry requests: each slave has one turn in a period, in a separate part of it, so that
//! bursts never fill a queue.
//!
//! Missed turns are skipped. A turn that is further away than a period, counted from the last start of a slave, has a flipped bit, and is
//! due at once.

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
    /// The last start of a slave, which may lie ahead.
    started: Instant,
    next: Option<Turn>,
}

impl Schedule {
    /// Makes a schedule without slaves.
    pub fn new(period: Duration) -> Self {
        Schedule {
            period,
            turns: core::array::from_fn(|_| Periodic::new(period)),
            counts: [0; SLAVES],
            started: Instant::ZERO,
            next: None,
        }
    }

    /// Adds a slave to the schedule from `now` on, an instant that may lie ahead. A Node-ID that straps cannot set is ignored.
    pub fn start(&mut self, node: NodeId, now: Instant) {
        let Some(slot) = slot(node) else { return };
        let period = self.period.as_micros().max(1);
        let offset = Duration::from_micros(period * slot as u64 / SLAVES as u64);
        let began = Instant::from_micros(now.as_micros() / period * period);
        let first = began + offset;
        if let Some(turns) = self.turns.get_mut(slot).filter(|turns| turns.deadline().is_none()) {
            turns.start(if first > now { first } else { first + self.period });
            self.started = self.started.max(now);
            self.plan(now);
        }
    }

    /// Removes a slave from the schedule.
    pub fn stop(&mut self, node: NodeId, now: Instant) {
        if let Some(turns) = slot(node).and_then(|slot| self.turns.get_mut(slot)) {
            turns.stop();
            self.plan(now);
        }
    }

    /// Returns the next turn.
    pub fn next(&mut self, now: Instant) -> Option<Turn> {
        if self.next.is_some_and(|turn| turn.at.since(now) > self.period) {
            self.plan(now);
        }
        self.next
    }

    fn plan(&mut self, now: Instant) {
        let from = self.started.max(now);
        self.turns.iter_mut().for_each(|turns| turns.confine(from));
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
        self.plan(now);
        missed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(100);

    /// Given a schedule of three slaves, when any bit of an instant of it flips, then each of them has a turn in each of the periods
    /// after the next.
    #[test]
    fn every_slave_keeps_its_turns_whatever_bit_has_flipped() {
        let nodes = [2, 3, 4].map(|raw| NodeId::new(raw).unwrap());
        let begin = Instant::from_micros(46_912_496_118);
        let flipped = |at: Instant, bit: u32| Instant::from_micros(at.as_micros() ^ 1 << bit);
        for bit in 0..128 {
            let mut schedule = Schedule::new(PERIOD);
            nodes.iter().for_each(|node| schedule.start(*node, begin));
            if bit < 64 {
                schedule.next.as_mut().unwrap().at = flipped(schedule.next.unwrap().at, bit);
            } else {
                let at = schedule.turns[0].deadline().unwrap();
                schedule.turns[0].start(flipped(at, bit - 64));
            }
            let mut taken = [0; 3];
            for step in 0..700 {
                // An event of the node ends the wait at least this often.
                let now = begin + Duration::from_millis(step);
                while let Some(turn) = schedule.next(now).filter(|turn| turn.at <= now) {
                    schedule.taken(turn, now);
                    taken[usize::from(turn.node.get()) - 2] += usize::from(step >= 300);
                }
            }
            assert!(taken.iter().all(|taken| (4..=5).contains(taken)), "bit {bit}: {taken:?}");
        }
    }
}
