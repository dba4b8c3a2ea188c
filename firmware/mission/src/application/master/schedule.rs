//! Schedule of commands and telemetry requests: each slave has one turn in a period, in a separate part of it, so that
//! bursts never fill a queue.
//!
//! Missed turns are skipped. A turn that is later than one of a slave that starts now has a flipped bit, and is planned again.

use ecss_can::pdo::Sequence;
use ecss_can::types::{Duration, Instant, NodeId};

use crate::{COMMAND_PERIOD, SLAVES, slot};

/// Node-ID of the slave with the first turn.
pub const FIRST: u8 = 2;

/// Longest time by which the start of a slave lies ahead.
const AHEAD: Duration = Sequence::delay(COMMAND_PERIOD);

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

/// Turns of the participating slaves, with a period of `PERIOD` microseconds.
pub struct Schedule<const PERIOD: u64> {
    /// Next turn of each slave. [`Instant::NEVER`]: it does not participate. An `Option` has bit patterns that are neither `Some`
    /// nor `None`.
    turns: [Instant; SLAVES],
    counts: [u32; SLAVES],
    next: Option<Turn>,
}

impl<const PERIOD: u64> Schedule<PERIOD> {
    /// Makes a schedule without slaves.
    pub const fn new() -> Self {
        Schedule { turns: [Instant::NEVER; SLAVES], counts: [0; SLAVES], next: None }
    }

    /// Adds a slave to the schedule from `from` on, an instant that may lie ahead. A Node-ID that straps cannot set is ignored.
    pub fn start(&mut self, node: NodeId, from: Instant) {
        let Some(slot) = slot(node) else { return };
        if let Some(turn) = self.turns.get_mut(slot).filter(|turn| **turn == Instant::NEVER) {
            *turn = Self::after(slot, from);
            self.plan(from);
        }
    }

    /// Removes a slave from the schedule.
    pub fn stop(&mut self, node: NodeId, now: Instant) {
        if let Some(turn) = slot(node).and_then(|slot| self.turns.get_mut(slot))
            && *turn != Instant::NEVER
        {
            *turn = Instant::NEVER;
            self.plan(now);
        }
    }

    /// Returns the next turn.
    pub fn next(&mut self, now: Instant) -> Option<Turn> {
        if self.next.is_none_or(|turn| turn.at.since(now) > Self::period()) {
            self.plan(now);
        }
        self.next
    }

    /// Completes a turn at `now`. Returns the number of turns of that slave that were missed before it.
    pub fn taken(&mut self, turn: Turn, now: Instant) -> u64 {
        let mut missed = 0;
        if let Some(slot) = slot(turn.node)
            && let (Some(at), Some(count)) = (self.turns.get_mut(slot), self.counts.get_mut(slot))
        {
            *count = count.wrapping_add(1);
            if *at != Instant::NEVER {
                let next = Self::after(slot, now);
                missed = (next.since(*at).as_micros() / PERIOD).saturating_sub(1);
                *at = next;
            }
        }
        self.plan(now);
        missed
    }

    /// Finds the next turn.
    fn plan(&mut self, now: Instant) {
        let latest = now + AHEAD + Self::period();
        for (slot, turn) in self.turns.iter_mut().enumerate() {
            if *turn != Instant::NEVER && *turn > latest {
                *turn = Self::after(slot, now);
            }
        }
        let turns = self.turns.iter().zip(&self.counts).zip(FIRST..).filter_map(|((turn, count), node)| {
            Some(Turn { node: NodeId::new(node)?, at: *turn, count: *count })
        });
        self.next = turns.filter(|turn| turn.at != Instant::NEVER).min_by_key(|turn| turn.at);
    }

    /// Returns the first turn of a slave after `now`.
    fn after(slot: usize, now: Instant) -> Instant {
        let offset = PERIOD * slot as u64 / SLAVES as u64;
        let turn = Instant::from_micros(now.as_micros() / PERIOD * PERIOD + offset);
        if turn > now { turn } else { turn + Self::period() }
    }

    const fn period() -> Duration {
        Duration::from_micros(PERIOD)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Schedule = super::Schedule<100_000>;
    const PERIOD: Duration = Schedule::period();
    /// A start with bits in all parts: 13 hours after power-on.
    const BEGIN: Instant = Instant::from_micros(46_912_496_118);

    const NODES: [NodeId; 3] = [NodeId::of::<2>(), NodeId::of::<3>(), NodeId::of::<4>()];

    fn flipped(at: Instant, bit: u32) -> Instant {
        Instant::from_micros(at.as_micros() ^ 1 << bit)
    }

    /// A field, its bits, and how one of them flips.
    type Field = (&'static str, u32, fn(&mut Schedule, u32));

    /// All fields of a schedule of three slaves. A bit that makes no Node-ID makes no turn.
    const FIELDS: [Field; 5] = [
        ("next.node", 8, |schedule, bit| {
            let Turn { node, at, count } = schedule.next.unwrap();
            schedule.next = NodeId::new(node.get() ^ 1 << bit).map(|node| Turn { node, at, count });
        }),
        ("next.at", 64, |schedule, bit| {
            let next = schedule.next.as_mut().unwrap();
            next.at = flipped(next.at, bit);
        }),
        ("next.count", 32, |schedule, bit| schedule.next.as_mut().unwrap().count ^= 1 << bit),
        ("turns", 3 * 64, |schedule, bit| {
            let turn = &mut schedule.turns[bit as usize / 64];
            *turn = flipped(*turn, bit % 64);
        }),
        ("counts", 3 * 32, |schedule, bit| schedule.counts[bit as usize / 32] ^= 1 << (bit % 32)),
    ];

    fn begun() -> Schedule {
        let mut schedule = Schedule::new();
        NODES.iter().for_each(|node| schedule.start(*node, BEGIN));
        schedule
    }

    /// Given a schedule of three slaves, when any bit of it flips, then each of them has a turn in each of the periods after the
    /// next two.
    #[test]
    fn every_slave_keeps_its_turns_whatever_bit_has_flipped() {
        for (name, bit, flip) in
            FIELDS.iter().flat_map(|(name, bits, flip)| (0..*bits).map(move |bit| (name, bit, flip)))
        {
            let mut schedule = begun();
            flip(&mut schedule, bit);
            let mut taken = [0; 3];
            for step in 0..700 {
                // An event of the node ends the wait at least this often.
                let now = BEGIN + Duration::from_millis(step);
                let mut burst = 0;
                while let Some(turn) = schedule.next(now).filter(|turn| turn.at <= now) {
                    schedule.taken(turn, now);
                    burst += 1;
                    assert!(burst <= 2 * NODES.len(), "{name}, bit {bit}: turns without end");
                    if step >= 300
                        && let Some(node) = NODES.iter().position(|node| *node == turn.node)
                    {
                        taken[node] += 1;
                    }
                }
            }
            assert_eq!(taken, [4; 3], "{name}, bit {bit}");
        }
    }

    /// Given a slave whose first turn lies as far ahead as it may, then it has none before.
    #[test]
    fn a_slave_waits_for_its_start() {
        let mut schedule = Schedule::new();
        let start = BEGIN + AHEAD;
        schedule.start(NODES[0], start);
        let first = schedule.next(BEGIN).unwrap().at;
        assert!(first > start && first <= start + PERIOD);
    }
}
