//! Whose turn it is: every slave once in a period, each in its own part of it, so that bursts never fill a queue.

use ecss_can::nmt::NodeId;
use ecss_can::time::{Duration, Instant};

/// Slaves that straps can number: 2..=15.
const SLAVES: usize = 14;
const FIRST: u8 = 2;

/// The turn of one slave.
#[derive(Clone, Copy)]
pub struct Turn {
    /// Whose.
    pub node: NodeId,
    /// When.
    pub at: Instant,
    /// How many it had before, since power-on; wraps.
    pub count: u32,
}

/// Turns of the slaves that take part.
pub struct Schedule {
    period: Duration,
    next: [Option<Instant>; SLAVES],
    counts: [u32; SLAVES],
}

impl Schedule {
    /// Nobody takes part yet.
    pub fn new(period: Duration) -> Self {
        Schedule { period, next: [None; SLAVES], counts: [0; SLAVES] }
    }

    /// A slave takes part from now on. One that straps cannot number never does.
    pub fn start(&mut self, node: NodeId, now: Instant) {
        let Some(slot) = slot(node) else { return };
        let period = self.period.as_micros().max(1);
        let offset = Duration::from_micros(period * slot as u64 / SLAVES as u64);
        let began = Instant::from_micros(now.as_micros() / period * period);
        let first = began + offset;
        if let Some(next) = self.next.get_mut(slot).filter(|next| next.is_none()) {
            *next = Some(if first > now { first } else { first + self.period });
        }
    }

    /// It does not any more.
    pub fn stop(&mut self, node: NodeId) {
        if let Some(next) = slot(node).and_then(|slot| self.next.get_mut(slot)) {
            *next = None;
        }
    }

    /// The next turn.
    pub fn peek(&self) -> Option<Turn> {
        let turns = self.next.iter().zip(&self.counts).zip(FIRST..).filter_map(|((next, count), node)| {
            Some(Turn { node: NodeId::new(node)?, at: (*next)?, count: *count })
        });
        turns.min_by_key(|turn| turn.at)
    }

    /// A turn was taken.
    pub fn taken(&mut self, turn: Turn) {
        let Some(slot) = slot(turn.node) else { return };
        if let (Some(next), Some(count)) = (self.next.get_mut(slot), self.counts.get_mut(slot)) {
            *next = Some(turn.at + self.period);
            *count = count.wrapping_add(1);
        }
    }
}

fn slot(node: NodeId) -> Option<usize> {
    node.get().checked_sub(FIRST).map(usize::from).filter(|slot| *slot < SLAVES)
}
