//! Two slaves with one Node-ID, as the master hears them.
//!
//! A *state clash* is a Node-ID whose heartbeats report Operational and another state in turn, faster than one slave can
//! change its state. A slave that leaves Operational and is started again reports Operational two heartbeat periods after
//! the last time. In a clash it does so within one and a half, each time that the other node is heard in between.
//!
//! In a clash the master goes on commanding: while heartbeats report Operational within the consumer time, the state that
//! the other node reports is ignored.
//!
//! Limits: two nodes that report the same state are not told apart. A slave whose heartbeat period is more than one and a
//! half times that of the master is not watched.

use crate::types::{Duration, Instant, NmtState, NodeId};

/// Node-IDs 0..=127.
const PLACES: usize = 128;
/// Turns in a row that make a clash: a slave may report a change of its state at once, and be started at once.
const TURNS: u8 = 3;
/// Consumer times: a clash ends when one of the two nodes was silent for them, and turns further apart are not in a row.
const MEMORY: u32 = 10;

/// Heartbeats of one Node-ID.
#[derive(Clone, Copy, Debug)]
struct Watch {
    /// Last heartbeat that reported Operational; zero before the first.
    operational: Instant,
    /// Last heartbeat that reported another state; zero before the first.
    other: Instant,
    /// Turns in a row, at most [`TURNS`].
    turns: u8,
}

/// Watches all Node-IDs for state clashes.
#[derive(Clone, Debug)]
pub struct StateClashes {
    watches: [Watch; PLACES],
    /// Number of clashes.
    known: u8,
}

/// Meaning of a heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judged {
    /// State that the master acts on.
    pub state: NmtState,
    /// A clash begins.
    pub is_new: bool,
}

impl Default for StateClashes {
    fn default() -> Self {
        Self::new()
    }
}

impl StateClashes {
    /// No heartbeat yet.
    pub const fn new() -> Self {
        StateClashes { watches: [Watch::NONE; PLACES], known: 0 }
    }

    /// Judges a heartbeat or boot-up message of `node` that ended at `at`. `period`: heartbeat period of the network.
    pub fn on_heartbeat(
        &mut self,
        node: NodeId,
        state: NmtState,
        at: Instant,
        period: Duration,
        consumer: Duration,
    ) -> Judged {
        let Some(watch) = self.watches.get_mut(usize::from(node.get())) else {
            return Judged { state, is_new: false };
        };
        let was_known = watch.is_known();
        let state = watch.on_heartbeat(state, at, period, consumer);
        let is_new = watch.is_known() && !was_known;
        self.known += u8::from(is_new);
        Judged { state, is_new }
    }

    /// The next clash that is over, once; call until `None`.
    pub fn poll(&mut self, now: Instant, consumer: Duration) -> Option<NodeId> {
        if self.known == 0 {
            return None;
        }
        let is_over = |watch: &Watch| watch.is_known() && watch.quiet_at(consumer) <= now;
        let (watch, raw) = self.watches.iter_mut().zip(0_u8..).find(|(watch, _)| is_over(watch))?;
        *watch = Watch::NONE;
        self.known = self.known.saturating_sub(1);
        NodeId::new(raw)
    }
}

impl Watch {
    const NONE: Watch = Watch { operational: Instant::ZERO, other: Instant::ZERO, turns: 0 };

    const fn is_known(&self) -> bool {
        self.turns == TURNS
    }

    /// When one of the two nodes has been silent long enough.
    fn quiet_at(&self, consumer: Duration) -> Instant {
        self.operational.min(self.other) + consumer.times(MEMORY)
    }

    /// Returns the state that counts.
    fn on_heartbeat(
        &mut self,
        state: NmtState,
        at: Instant,
        period: Duration,
        consumer: Duration,
    ) -> NmtState {
        match state {
            NmtState::Initialising => {
                if !self.is_known() {
                    *self = Watch::NONE;
                }
                state
            }
            NmtState::Operational => {
                self.on_operational(at, period);
                state
            }
            NmtState::PreOperational | NmtState::Stopped => {
                if !self.is_known() && self.other + consumer.times(MEMORY) <= at {
                    self.turns = 0;
                }
                self.other = at;
                let is_running = self.is_known() && at < self.operational + consumer;
                if is_running { NmtState::Operational } else { state }
            }
        }
    }

    fn on_operational(&mut self, at: Instant, period: Duration) {
        let last = core::mem::replace(&mut self.operational, at);
        if self.is_known() || self.other <= last || last == Instant::ZERO {
            return;
        }
        let is_turn = at < last + Duration::from_micros(period.times(3).as_micros() / 2);
        self.turns = if is_turn { self.turns.saturating_add(1) } else { 0 };
    }
}
