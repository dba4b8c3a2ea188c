//! Detects two slaves with one Node-ID, in the master.

use heapless::Vec;

use crate::types::{Duration, Instant, NmtState, NodeId};

/// Node-IDs that are watched at a time: those that left Operational last.
const WATCHED: usize = 8;
/// Turns in a row that make a clash: a slave may report a change of its state at once, and be started at once.
const TURNS: u8 = 3;
/// Consumer times: a clash ends when one of the two nodes was silent for them, and turns further apart are not in a
/// row.
const MEMORY: u32 = 10;

/// Heartbeats of one Node-ID.
#[derive(Clone, Copy, Debug)]
struct Watch {
    node: NodeId,
    /// Last heartbeat that reported Operational.
    operational: Instant,
    /// Last heartbeat that reported another state.
    other: Instant,
    /// Turns in a row, at most [`TURNS`].
    turns: u8,
}

/// Watches the heartbeats of all Node-IDs for state clashes.
///
/// A *state clash* is a Node-ID whose heartbeats report Operational and another state in turn, faster than one
/// slave can change its state. A slave that leaves Operational and is started again reports Operational two
/// heartbeat periods after the last time. In a clash this happens within one and a half periods, each time that the
/// other node is heard in between.
///
/// In a clash the master continues to command. While heartbeats on the active bus report Operational within the
/// consumer time, it ignores the state that the other node reports.
///
/// # Limits
///
/// - Two nodes that report the same state are not detected.
/// - A slave whose heartbeat period is more than one and a half times that of the master shows no clash.
/// - At most eight Node-IDs are watched at a time.
#[derive(Clone, Debug, Default)]
pub struct StateClashes {
    watches: Vec<Watch, WATCHED>,
}

/// Meaning of a heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judged {
    /// State that the master acts on.
    pub state: NmtState,
    /// `true`: a clash begins with this heartbeat.
    pub is_new: bool,
}

impl StateClashes {
    /// Judges a heartbeat or boot-up message of `node` that ended at `at`. `operational`: end of its last
    /// heartbeat, if that reported Operational. `period`: heartbeat period of the network.
    pub fn on_heartbeat(
        &mut self,
        node: NodeId,
        state: NmtState,
        at: Instant,
        operational: Option<Instant>,
        [period, consumer]: [Duration; 2],
    ) -> Judged {
        let known = self.watches.iter_mut().find(|watch| watch.node == node);
        let Some(watch) = known else {
            if let (NmtState::PreOperational | NmtState::Stopped, Some(operational)) = (state, operational) {
                self.watch(Watch { node, operational, other: at, turns: 0 });
            }
            return Judged { state, is_new: false };
        };
        let was_clash = watch.is_clash();
        let state = watch.on_heartbeat(state, at, period, consumer);
        Judged { state, is_new: watch.is_clash() && !was_clash }
    }

    /// Takes the place of the watch that is no clash and whose node left Operational first, where none is free.
    fn watch(&mut self, new: Watch) {
        if let Err(new) = self.watches.push(new) {
            let others = self.watches.iter_mut().filter(|watch| !watch.is_clash());
            if let Some(oldest) = others.min_by_key(|watch| watch.other) {
                *oldest = new;
            }
        }
    }

    /// Returns the next clash that is over, once. Call it until `None`.
    pub fn poll(&mut self, now: Instant, consumer: Duration) -> Option<NodeId> {
        let is_over = |watch: &Watch| watch.is_clash() && watch.quiet_at(consumer) <= now;
        let nth = self.watches.iter().position(is_over)?;
        Some(self.watches.swap_remove(nth).node)
    }
}

impl Watch {
    const fn is_clash(&self) -> bool {
        self.turns == TURNS
    }

    /// Returns when one of the two nodes has been silent for long enough.
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
            // A slave that was reset is Operational soon.
            NmtState::Initialising => {
                if !self.is_clash() {
                    self.turns = 0;
                    self.operational = Instant::ZERO;
                }
                state
            }
            NmtState::Operational => {
                self.on_operational(at, period);
                state
            }
            NmtState::PreOperational | NmtState::Stopped => {
                if !self.is_clash() && self.other + consumer.times(MEMORY) <= at {
                    self.turns = 0;
                }
                self.other = at;
                let is_running = self.is_clash() && at < self.operational + consumer;
                if is_running { NmtState::Operational } else { state }
            }
        }
    }

    fn on_operational(&mut self, at: Instant, period: Duration) {
        let last = core::mem::replace(&mut self.operational, at);
        if self.is_clash() || self.other <= last || last == Instant::ZERO {
            return;
        }
        let is_turn = at < last + Duration::from_micros(period.times(3).as_micros() / 2);
        self.turns = if is_turn { self.turns.saturating_add(1) } else { 0 };
    }
}
