//! One connected piece of a wire, in one of three modes.
//!
//! * [`Mode::Still`]: the line keeps its level; nodes only count bits, each by itself.
//! * [`Mode::Bits`]: bit by bit, node by node, level change by level change ([`crate::wire::bits`]).
//! * [`Mode::Flight`]: an undisturbed frame, computed as a whole ([`crate::wire::flight`]). It changes no node before its
//!   end, so that an unexpected disturbance can revert it and repeat it bit by bit.

use std::collections::VecDeque;

use crate::wire::arrivals::Arrivals;
use crate::wire::calendar::Calendar;
use crate::wire::confinement::ErrorCounters;
use crate::wire::controller::{NodeIndex, WireEvent};
use crate::wire::fine::Fine;
use crate::wire::mac::{RECESSIVE, State, Transmission};
use crate::wire::node::Drivers;
use crate::wire::stage::{Ledger, Stage};
use crate::wire::timing::BitClock;

/// Mode in which a segment is computed.
#[derive(Clone, Debug)]
pub(in crate::wire) enum Mode {
    Still,
    Bits(Arrivals),
    Flight(Box<Flight>),
}

/// Future level changes at some nodes.
pub(in crate::wire) type Lines = Vec<(NodeIndex, VecDeque<(Fine, bool)>)>;

/// A frame in progress whose rest is computed.
#[derive(Clone, Debug)]
pub(in crate::wire) struct Flight {
    /// Instant of the nodes' stored state.
    pub(in crate::wire) from: Fine,
    pub(in crate::wire) own: Transmission,
    pub(in crate::wire) transmitter: NodeIndex,
    /// The flight began with its SOF, which is not in the nodes' state.
    pub(in crate::wire) with_sof: bool,
    pub(in crate::wire) agenda: VecDeque<(Fine, NodeIndex, WireEvent)>,
    pub(in crate::wire) landings: Vec<Landing>,
    /// Instant at which all nodes have reached intermission.
    pub(in crate::wire) end: Fine,
    /// Level changes for nodes that watch their line.
    pub(in crate::wire) lines: Lines,
}

impl Flight {
    /// Returns the error counters of `node` after all changes have been reported.
    pub(in crate::wire) fn counters(&self, node: NodeIndex) -> Option<ErrorCounters> {
        let told = self.agenda.iter().all(|&(_, other, _)| other != node);
        let landing = self.landings.iter().find(|landing| landing.node == node);
        landing.filter(|_| told).map(|landing| landing.counters)
    }

    /// Returns whether `node` has reached its intermission at `now`; `None` if it does not take part.
    pub(in crate::wire) fn has_landed(&self, node: NodeIndex, now: Fine) -> Option<bool> {
        let landing = self.landings.iter().find(|landing| landing.node == node)?;
        Some(landing.clock.start <= now)
    }
}

/// A node at the beginning of its intermission.
#[derive(Clone, Debug)]
pub(in crate::wire) struct Landing {
    pub(in crate::wire) node: NodeIndex,
    pub(in crate::wire) clock: BitClock,
    pub(in crate::wire) counters: ErrorCounters,
}

/// One connected piece of a wire.
#[derive(Clone, Debug)]
pub(in crate::wire) struct Segment {
    /// Nodes on this piece in the order of their positions.
    pub(in crate::wire) members: Vec<NodeIndex>,
    /// Index of each node in `members`.
    pub(in crate::wire) places: Vec<usize>,
    /// Plans for [`Mode::Bits`]; empty if any may be outdated.
    pub(in crate::wire) calendar: Calendar,
    pub(in crate::wire) mode: Mode,
    /// Instant up to which everything has been computed.
    pub(in crate::wire) cursor: Fine,
    /// Instant of the next own event of the segment, as of the last run.
    pub(in crate::wire) next: Fine,
    pub(in crate::wire) ledger: Ledger,
    /// Stays on the bit path until everything has settled.
    pub(in crate::wire) grounded: bool,
    /// Replays past events without querying controllers.
    pub(in crate::wire) replaying: bool,
    /// Nodes that withdrew their request; they are not queried again in this run.
    pub(in crate::wire) withdrawn: Drivers,
}

impl Segment {
    pub(in crate::wire) fn new(members: Vec<NodeIndex>, cursor: Fine) -> Self {
        let mut places = vec![0; members.iter().max().map_or(0, |&last| last + 1)];
        members.iter().enumerate().for_each(|(member, &node)| places[node] = member);
        Segment {
            members,
            places,
            calendar: Calendar::default(),
            mode: Mode::Bits(Arrivals::default()),
            cursor,
            next: Fine::NEVER,
            ledger: Ledger::default(),
            grounded: false,
            replaying: false,
            withdrawn: 0,
        }
    }

    /// Returns whether a run to `until` has nothing to do, if there was no external change since the last run. If so,
    /// advances the time.
    pub(in crate::wire) fn rests_until(&mut self, until: Fine) -> bool {
        let rests = self.withdrawn == 0 && self.next > until && !matches!(self.mode, Mode::Bits(_));
        if rests {
            self.cursor = self.cursor.max(until);
        }
        rests
    }

    /// Runs to `until`.
    pub(in crate::wire) fn run(&mut self, until: Fine, stage: &mut Stage) {
        if std::mem::take(&mut self.withdrawn) != 0 {
            self.calendar = Calendar::default();
        }
        loop {
            let paused = match &mut self.mode {
                Mode::Still => self.run_still(until, stage),
                Mode::Bits(_) => self.run_bits(until, stage),
                Mode::Flight(_) => self.run_flight(until, stage),
            };
            if paused {
                break;
            }
        }
        self.cursor = self.cursor.max(until);
        self.ledger.told_until = None;
    }

    /// Changes to [`Mode::Bits`] at the instant up to which everything has been computed.
    pub(in crate::wire) fn wake(&mut self, stage: &mut Stage) -> &mut Arrivals {
        self.calendar = Calendar::default();
        if let Mode::Flight(_) = self.mode {
            self.replay(stage);
        }
        if let Mode::Still = self.mode {
            for n in 0..self.members.len() {
                self.catch_up(self.members[n], self.cursor, stage);
            }
            self.mode = Mode::Bits(Arrivals::default());
        }
        self.arrivals()
    }

    /// Advances time on an unchanging line. Returns `true` if nothing more happens up to `until`.
    fn run_still(&mut self, until: Fine, stage: &mut Stage) -> bool {
        // Of equal instants the first one counts.
        let first = |plan: &(Fine, NodeIndex)| plan.0;
        let due = self.members.iter().filter_map(|&node| Some((self.due(node, stage)?, node)));
        let due = due.min_by_key(first).unwrap_or((Fine::NEVER, 0));
        let start = self.members.iter().filter_map(|&node| Some((self.start_of(node, stage)?, node)));
        let start = start.min_by_key(first).unwrap_or((Fine::NEVER, 0));
        self.next = due.0.min(start.0);
        if self.next > until || self.next == Fine::NEVER {
            return true;
        }
        self.cursor = self.next;
        if due.0 <= start.0 {
            self.catch_up(due.1, due.0, stage);
            return false;
        }
        let (at, node) = start;
        match stage.contend(node, at) {
            Some(own) => self.launch(node, own, stage),
            None => self.withdrawn |= 1 << node,
        }
        false
    }

    /// Returns when `node` would start a frame of its own if its line stayed recessive.
    pub(in crate::wire) fn start_of(&self, node: NodeIndex, stage: &mut Stage) -> Option<Fine> {
        let asks = !self.replaying && self.withdrawn >> node & 1 == 0;
        if asks { stage.start_of(node, self.cursor) } else { None }
    }

    /// Returns the next event of `node` if its line keeps its level.
    fn due(&self, node: NodeIndex, stage: &Stage) -> Option<Fine> {
        let node = &stage.nodes[node];
        let bits = match node.mac.state {
            State::Integrating { recessive } | State::Recovering { recessive, sequences: 0 } => {
                u64::from(10 - recessive)
            }
            State::Recovering { recessive, sequences } => {
                u64::from(10 - recessive) + 11 * u64::from(127 - sequences)
            }
            _ => return None,
        };
        (node.level == RECESSIVE).then(|| node.mac.clock.end + node.mac.clock.bit.times(bits))
    }

    /// Ends the bits of `node` that end at or before `at`.
    pub(in crate::wire) fn catch_up(&mut self, node: NodeIndex, at: Fine, stage: &mut Stage) {
        while stage.nodes[node].mac.is_running() && stage.nodes[node].mac.clock.end <= at {
            let this = &mut stage.nodes[node];
            let end = this.mac.clock.end;
            if this.level != RECESSIVE {
                // Settled: only time passes.
                let bits = 1 + (at - end).0 / this.mac.clock.bit.0;
                this.mac.clock.skip(bits, this.level);
                break;
            }
            let observed = stage.recorder.is_some() || !stage.flips.is_empty();
            if observed || !stage.nodes[node].mac.pass_intermission(at) {
                self.step(node, end, stage);
            }
        }
    }

    /// Ends the present bit at `node` and reports the result.
    pub(in crate::wire) fn step(&mut self, node: NodeIndex, at: Fine, stage: &mut Stage) {
        let mac = &mut stage.nodes[node].mac;
        let line = stage.nodes[node].level;
        let mut sampled = mac.clock.sampled(line);
        let field = mac.field();
        let position = mac.position();
        let mut flipped = false;
        if let Some(flip) = stage.flips.iter_mut().find(|flip| flip.strikes(node, field, position)) {
            sampled = !sampled;
            flipped = true;
            if flip.strike(node) {
                stage.flips.retain(|flip| !flip.is_spent());
            }
        }
        if let Some(recorder) = &mut stage.recorder {
            recorder.bit(node, &stage.nodes[node], field, sampled, flipped);
        }
        let mac = &mut stage.nodes[node].mac;
        let before = mac.counters;
        let sof = mac.clock.start;
        let note = mac.step(sampled, line);
        let (after, finished) = (mac.counters, mac.finished.take());
        if let Some(event) = note.event {
            stage.tell(&mut self.ledger, at, node, event, finished.as_ref());
        }
        if after != before {
            stage.tell(&mut self.ledger, at, node, WireEvent::Counters(after), None);
        }
        if note.may_join {
            self.join(node, sof, at, stage);
        }
    }

    /// Handles the SOF of another node at `node`: with a frame that waited at its beginning, the node enters the
    /// arbitration.
    fn join(&mut self, node: NodeIndex, sof: Fine, at: Fine, stage: &mut Stage) {
        let babbles = stage.nodes[node].condition.babbles.is_some();
        let mut waits = || stage.request_at(node).is_some_and(|request| request <= sof);
        if self.replaying || !babbles && !waits() {
            return;
        }
        if let Some(own) = stage.contend(node, sof) {
            stage.nodes[node].mac.join(own);
            stage.started(&mut self.ledger, at, sof, node);
        }
    }

    /// Returns whether all nodes wait or count bits of an unchanging line.
    pub(in crate::wire) fn is_settled(&self, stage: &Stage) -> bool {
        self.members.iter().all(|&node| {
            let node = &stage.nodes[node];
            if node.mac.is_running() && node.mac.clock.latched.is_some_and(|sampled| sampled != node.level) {
                // The present bit was sampled before the last change.
                return false;
            }
            if node.level == RECESSIVE {
                return node.mac.is_quiet();
            }
            match node.mac.state {
                State::Off | State::BusOff => true,
                State::Integrating { recessive } | State::Recovering { recessive, .. } => recessive == 0,
                // The counter is at its limit and does not change any more.
                State::Superposition { .. } => !node.mac.transmitter && node.mac.counters.receive == 255,
                _ => false,
            }
        })
    }
}
