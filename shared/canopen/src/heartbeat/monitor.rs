//! Consumers of many nodes' heartbeats (object 1016h).

use super::ConsumerSlots;
use super::entry::monitored;
use super::objects::CONSUMERS;
use crate::types::{Address, Duration, Instant, NmtState, NodeId};

/// Monitors the heartbeats of many nodes: one [`Consumer`](super::machine::Consumer) for each entry of 1016h.
///
/// An entry is node << 16 | milliseconds. It is not in use if the node is not in 1 to 127 or the time is zero.
/// Monitoring begins with the first heartbeat after the entry was written. A boot-up message alone does not start
/// it. For a node that is monitored already, a boot-up message counts as a sign of life.
#[doc(alias("1016h", "consumer heartbeat time", "heartbeat consumer"))]
#[derive(Debug)]
pub struct Monitor<S: ConsumerSlots> {
    entries: S::Each<Entry>,
    /// Nothing is overdue before. Later heartbeats only move the truth further away.
    check: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Entry {
    /// Instant at which the next heartbeat is overdue, never unless monitoring.
    deadline: Instant,
    /// Consumer time in microseconds.
    time: u32,
    /// Zero when not in use.
    node: u8,
    /// NMT state of the last heartbeat.
    state: Option<NmtState>,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Phase {
    /// No heartbeat yet.
    Armed,
    /// Heard in time.
    Monitoring,
    /// Missed, and reported.
    Missed,
}

/// Meaning of a heartbeat or boot-up message of a monitored node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heard {
    /// State before. `None` until the first heartbeat after the entry was written. A boot-up message after
    /// another state: the node restarted.
    pub before: Option<NmtState>,
    /// `true`: the heartbeat was missed before.
    pub resolved: bool,
}

/// Report of a heartbeat that is overdue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Missed {
    /// Node-ID of the producer.
    pub node: NodeId,
    /// End of its last heartbeat.
    pub last: Instant,
}

impl Entry {
    const UNUSED: Entry =
        Entry { deadline: Instant::NEVER, time: 0, node: 0, state: None, phase: Phase::Armed };

    const fn new(value: u32) -> Entry {
        match monitored(value) {
            Some(node) => Entry { node: node.get(), time: (value & 0xFFFF) * 1_000, ..Entry::UNUSED },
            None => Entry::UNUSED,
        }
    }

    const fn time(&self) -> Duration {
        Duration::from_micros(self.time as u64)
    }

    fn is_missed(&self) -> bool {
        self.phase == Phase::Missed
    }
}

impl<S: ConsumerSlots> Default for Monitor<S> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: ConsumerSlots> Monitor<S> {
    /// Makes a monitor without entries in use.
    pub fn new() -> Self {
        Monitor { entries: S::each(Entry::UNUSED), check: Instant::NEVER }
    }

    /// Takes a new value of the entry at sub-index `sub`. Returns the node that it monitored before, if that was
    /// missed: the monitor will not report that it returns.
    pub fn set(&mut self, sub: u8, value: u32) -> Option<NodeId> {
        let place = usize::from(sub).checked_sub(1)?;
        let entry = self.entries.as_mut().get_mut(place)?;
        let before = core::mem::replace(entry, Entry::new(value));
        NodeId::new(before.node).filter(|_| before.is_missed())
    }

    /// Takes the new value of an object that was written. Returns a node as [`Monitor::set`] does.
    pub fn follow(&mut self, at: Address, objects: &S) -> Option<NodeId> {
        let entry = usize::from(at.sub).wrapping_sub(1);
        let value = objects.entries().get(entry).copied().unwrap_or(0);
        if at.index == CONSUMERS { self.set(at.sub, value) } else { None }
    }

    /// Takes all entries from the objects. Calls `missed` with each node that [`Monitor::set`] would return.
    pub fn configure(&mut self, objects: &S, missed: &mut dyn FnMut(NodeId)) {
        for (value, sub) in objects.entries().iter().zip(1..) {
            self.set(sub, *value).into_iter().for_each(&mut *missed);
        }
    }

    /// Takes those entries again that differ from the objects.
    pub(crate) fn refresh(&mut self, objects: &S) {
        for (entry, value) in self.entries.as_mut().iter_mut().zip(objects.entries()) {
            let right = Entry::new(*value);
            if (entry.node, entry.time) != (right.node, right.time) {
                *entry = right;
            }
        }
    }

    /// Lets the next poll look at every entry.
    pub(crate) fn recheck(&mut self) {
        self.check = Instant::ZERO;
    }

    /// Takes a heartbeat or boot-up message of `node` that ended at `at`. Returns `None` if the node is not
    /// monitored.
    pub fn on_heartbeat(&mut self, node: NodeId, state: NmtState, at: Instant) -> Option<Heard> {
        let entry = self.entries.as_mut().iter_mut().find(|entry| entry.node == node.get())?;
        let heard = Heard { before: entry.state, resolved: entry.is_missed() };
        entry.state = Some(state);
        if state != NmtState::Initialising || entry.phase != Phase::Armed {
            entry.phase = Phase::Monitoring;
            entry.deadline = at + entry.time();
            self.check = self.check.min(entry.deadline);
        }
        Some(heard)
    }

    /// Returns the next node whose heartbeat is overdue, each once. Call it until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<Missed> {
        if now < self.check {
            return None;
        }
        let mut check = Instant::NEVER;
        for entry in self.entries.as_mut() {
            if entry.deadline <= now
                && entry.phase == Phase::Monitoring
                && let Some(node) = NodeId::new(entry.node)
            {
                let last = entry.deadline - entry.time();
                entry.deadline = Instant::NEVER;
                entry.phase = Phase::Missed;
                return Some(Missed { node, last });
            }
            check = check.min(entry.deadline);
        }
        self.check = check;
        None
    }

    /// Returns when to poll next: a heartbeat may be overdue then.
    pub fn deadline(&self) -> Option<Instant> {
        (self.check < Instant::NEVER).then_some(self.check)
    }
}
