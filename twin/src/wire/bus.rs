//! One bus: controllers along a cable, in virtual time, bit by bit.
//!
//! The caller runs the systems behind the controllers for a quantum (at most 20 us, never beyond [`Wire::next_event`])
//! and then calls [`Wire::advance`]. Requests carry their own times, so a frame may start inside the quantum that has
//! just passed. Events within that quantum are reported late, with their true times. Later events are reported exactly
//! at their times, because the caller stops there. Exceptions are an error or a lost arbitration that is not expected,
//! such as within an identifier: they may be reported late by a quantum as well.
//!
//! Every node has its own engine for bit timing, protocol and fault confinement; [`crate::wire::controller`] describes the
//! interface to the chip. Levels propagate at the speed of the cable; a node sees dominant while any driver that has
//! reached it is dominant. Undisturbed frames are computed on a fast path with the same result
//! ([`WireConfig::bit_by_bit`]).

use crate::wire::arrivals::{Arrival, Change};
use crate::wire::calendar::Calendar;
use crate::wire::controller::{Attachment, Controllers, ErrorCounters, NodeIndex, WireEvent};
use crate::wire::errors::BitErrors;
use crate::wire::fault::{Fault, FaultError, Flip};
use crate::wire::fine::Fine;
use crate::wire::mac::DOMINANT;
use crate::wire::node::{Drivers, MOST_NODES, Node};
use crate::wire::record::{Counters, Destruction, Observation};
use crate::wire::segment::{Mode, Segment};
use crate::wire::stage::{Observed, Stage};
use crate::wire::time::Time;
use crate::wire::transceiver::Transceiver;
use crate::wire::waveform::Waveform;

/// Properties of the cable, and mode of computation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireConfig {
    /// Propagation delay, nanoseconds per metre.
    pub ns_per_m: u32,
    /// Loop delay of transceivers and isolation, nanoseconds, for nodes without a transceiver of their own. It also
    /// applies between a node's output and its own input.
    pub transceiver_ns: u32,
    /// Computes every bit, also those of undisturbed frames.
    pub bit_by_bit: bool,
}

impl Default for WireConfig {
    /// Twisted pair with 5 ns/m, ideal transceivers.
    fn default() -> Self {
        WireConfig { ns_per_m: 5, transceiver_ns: 0, bit_by_bit: false }
    }
}

/// Something that is to happen.
#[derive(Clone, Copy, Debug)]
enum Planned {
    Fault(Fault),
    /// A controller begins to take part.
    Join(NodeIndex, Attachment),
    /// A waveform is recorded from here to the given instant.
    Record(Time),
    EndOfRecord,
}

/// One bus.
#[derive(Clone, Debug)]
pub struct Wire {
    config: WireConfig,
    now: Time,
    nodes: Vec<Node>,
    /// Positions of cuts, ascending, without duplicates.
    cuts: Vec<f64>,
    shorts: Vec<(f64, bool)>,
    segments: Vec<Segment>,
    /// Planned events in chronological order.
    planned: Vec<(Time, Planned)>,
    flips: Vec<Flip>,
    errors: Option<BitErrors>,
    /// Waveform that is being recorded.
    recorder: Option<Waveform>,
    waveform: Option<Waveform>,
    observed: Observed,
    /// Any controller watches its line.
    is_watched: bool,
}

impl Wire {
    /// A cable without nodes, at time zero.
    pub fn new(config: WireConfig) -> Self {
        Wire {
            config,
            now: Time::ZERO,
            nodes: Vec::new(),
            cuts: Vec::new(),
            shorts: Vec::new(),
            segments: vec![Segment::new(Vec::new(), Fine(0))],
            planned: Vec::new(),
            flips: Vec::new(),
            errors: None,
            recorder: None,
            waveform: None,
            observed: Observed::default(),
            is_watched: false,
        }
    }

    /// Attaches a controller `position_m` metres from the left end; positions may be in any order.
    ///
    /// # Panics
    /// As [`Wire::attach_through`].
    pub fn attach(&mut self, position_m: f64) -> NodeIndex {
        self.attach_through(position_m, Transceiver::with_loop(self.config.transceiver_ns))
    }

    /// Attaches a controller behind a transceiver of its own.
    ///
    /// # Panics
    /// When the position is negative or not finite, after the first [`Wire::advance`], or for a node too many (128): a
    /// mistake in a test, not an input.
    pub fn attach_through(&mut self, position_m: f64, transceiver: Transceiver) -> NodeIndex {
        assert!(position_m.is_finite() && position_m >= 0.0, "no place on a cable: {position_m} m");
        assert_eq!(self.now, Time::ZERO, "nodes are attached before time runs");
        assert!(self.nodes.len() < MOST_NODES, "a wire has at most {MOST_NODES} nodes");
        let node = self.nodes.len();
        let delay_ns = position_m * f64::from(self.config.ns_per_m);
        let offset = Fine::from_ratio((delay_ns * 336.0).round() as u64, 1000);
        self.nodes.push(Node::new(position_m, offset, transceiver));
        self.segments = self.pieces().into_iter().map(|members| Segment::new(members, Fine(0))).collect();
        node
    }

    /// Delay from the output of one node to the input of another, or to its own: both transceivers and the cable, cut
    /// or not.
    pub fn delay(&self, from: NodeIndex, to: NodeIndex) -> Time {
        self.nodes[from].path_to(&self.nodes[to]).nearest()
    }

    /// Returns the instant to which the wire has been advanced.
    pub fn now(&self) -> Time {
        self.now
    }

    /// Returns the next instant after [`Wire::now`] at which the wire has an event, as known at the last
    /// [`Wire::advance`]: an event for a controller, a bit of a disturbed frame, the start of a waiting frame, a
    /// planned fault. `None`: none, unless a controller requests a frame.
    pub fn next_event(&self) -> Option<Time> {
        let (planned, error) = self.next_faults();
        let segments = self.segments.iter().map(|segment| segment.next).filter(|&at| at != Fine::NEVER);
        let next = segments.map(Fine::ceil).fold(planned.min(error), Time::min);
        (next != Time::NEVER).then(|| next.max(self.now + Time(1)))
    }

    /// Returns the instants of the next planned event and of the next random bit error; [`Time::NEVER`]: none.
    fn next_faults(&self) -> (Time, Time) {
        let planned = self.planned.first().map_or(Time::NEVER, |&(at, _)| at);
        (planned, self.errors.as_ref().map_or(Time::NEVER, |errors| errors.next))
    }

    /// Returns whether `node` neither sends nor receives a frame or an error frame, so that it may leave the bus.
    pub fn is_idle(&self, node: NodeIndex) -> bool {
        let now = Fine::from_time(self.now);
        let landed = self.segments.iter().find_map(|segment| match &segment.mode {
            Mode::Flight(flight) => flight.has_landed(node, now),
            _ => None,
        });
        landed.unwrap_or_else(|| self.nodes[node].mac.is_quiet())
    }

    /// Error counters of `node`, at its last [`WireEvent::Counters`] or later.
    pub fn error_counters(&self, node: NodeIndex) -> ErrorCounters {
        let in_flight = self.segments.iter().find_map(|segment| match &segment.mode {
            Mode::Flight(flight) => flight.counters(node),
            _ => None,
        });
        in_flight.unwrap_or(self.nodes[node].mac.counters)
    }

    /// Advances to `until` and reports the events on the way to the controllers.
    ///
    /// # Panics
    /// When `until` lies before [`Wire::now`], or beyond 58 hours (2^46 ticks).
    pub fn advance(&mut self, until: Time, controllers: &mut dyn Controllers) {
        assert!(until >= self.now, "a wire does not run backwards");
        assert!(Fine::from_time(until) < Fine::NEVER, "a wire runs for 58 hours at most");
        let mut changed = controllers.have_changed();
        if changed {
            (0..self.nodes.len()).for_each(|node| self.look_at(node, until, controllers));
            self.is_watched = self.nodes.iter().any(|node| node.watches);
        }
        loop {
            let (planned, error) = self.next_faults();
            let at = planned.min(error);
            if at > until {
                break;
            }
            self.run_to(at.max(self.now), changed, controllers);
            changed = true;
            if error < planned {
                let count = self.nodes.len();
                if let Some(glitch) = self.errors.as_mut().map(|errors| errors.strike(count)) {
                    self.apply(glitch, controllers);
                }
                continue;
            }
            match self.planned.remove(0).1 {
                Planned::Join(node, asked) => {
                    let attachment = self.nodes[node].condition.bends(asked);
                    self.set_attachment(node, attachment, controllers);
                }
                Planned::Record(to) => self.begin_record(to, controllers),
                Planned::EndOfRecord => self.waveform = self.recorder.take().map(Waveform::finish),
                Planned::Fault(fault) => {
                    self.observed.records.push(Observation::Fault { at: self.now, fault });
                    self.apply(fault, controllers);
                }
            }
        }
        self.run_to(until, changed, controllers);
        for node in 0..if self.is_watched { self.nodes.len() } else { 0 } {
            if !self.nodes[node].changes.is_empty() {
                controllers.with(node, |controller| controller.on_line(&self.nodes[node].changes));
                self.nodes[node].changes.clear();
            }
        }
    }

    /// Leaves the fast path, on which nodes have no bits, and begins a record.
    fn begin_record(&mut self, to: Time, controllers: &mut dyn Controllers) {
        self.wake_all(controllers);
        self.recorder = Some(Waveform::begin(self.now, to, &self.nodes));
    }

    /// Breaks the cable now, [`Fault::Cut`].
    ///
    /// # Panics
    /// When the position is invalid: a mistake in a test. [`Wire::schedule`] refuses it.
    pub fn cut(&mut self, position_m: f64) {
        self.schedule(self.now, Fault::Cut { position_m }).expect("a place on the cable");
    }

    /// Repairs one break now, [`Fault::Restore`].
    ///
    /// # Panics
    /// When the position is invalid: a mistake in a test. [`Wire::schedule`] refuses it.
    pub fn restore(&mut self, position_m: f64) {
        self.schedule(self.now, Fault::Restore { position_m }).expect("a place on the cable");
    }

    /// Repairs every break now, [`Fault::RestoreAll`].
    pub fn restore_all(&mut self) {
        self.plan(self.now, Planned::Fault(Fault::RestoreAll));
    }

    /// Schedules a fault at `at`; it takes effect after events that end at that instant.
    ///
    /// # Errors
    /// [`FaultError`] if the fault is impossible; nothing is scheduled then.
    pub fn schedule(&mut self, at: Time, fault: Fault) -> Result<(), FaultError> {
        fault.check(self.nodes.len())?;
        if at < self.now {
            return Err(FaultError::Past { at, now: self.now });
        }
        self.plan(at, Planned::Fault(fault));
        Ok(())
    }

    /// Takes the records since the last call, in chronological order. They accumulate without calls.
    pub fn take_records(&mut self) -> Vec<Observation> {
        let mut records = std::mem::take(&mut self.observed.records);
        records.sort_by_key(Observation::at);
        records
    }

    /// Records every bit of every node from `from` to `to`, for [`Wire::take_waveform`]. It changes nothing else. A
    /// span that is requested before another one has ended replaces that one.
    ///
    /// # Panics
    /// When `from` lies in the past, or `to` not after it: a mistake in a test.
    pub fn record_waveform(&mut self, from: Time, to: Time) {
        assert!(self.now <= from && from < to, "no span to come: {from:?} to {to:?}, it is {:?}", self.now);
        self.planned.retain(|(_, planned)| !matches!(planned, Planned::Record(_) | Planned::EndOfRecord));
        self.recorder = None;
        self.plan(from, Planned::Record(to));
        self.plan(to, Planned::EndOfRecord);
    }

    /// Takes the waveform after the wire has reached its end.
    pub fn take_waveform(&mut self) -> Option<Waveform> {
        self.waveform.take()
    }

    /// Returns a copy without records and totals.
    #[cfg(feature = "boards")]
    pub(crate) fn without_totals(&self) -> Wire {
        Wire { observed: Observed::default(), ..self.clone() }
    }

    /// Totals since the start.
    pub fn counters(&self) -> Counters {
        Counters { busy: self.observed.busy.nearest(), ..self.observed.counters }
    }

    fn plan(&mut self, at: Time, what: Planned) {
        let index = self.planned.partition_point(|&(due, _)| due <= at);
        self.planned.insert(index, (at, what));
    }

    /// Checks whether a controller joined, left or changed, at the latest at `until`.
    fn look_at(&mut self, node: NodeIndex, until: Time, controllers: &mut dyn Controllers) {
        let (watches, attachment) =
            controllers.with(node, |controller| (controller.watches_line(), controller.attachment()));
        self.nodes[node].watches = watches;
        let condition = self.nodes[node].condition;
        let attachment = attachment.and_then(|attachment| condition.bends(attachment));
        let before = self.nodes[node].mac.attachment;
        let is_same = |before: Attachment, now: Attachment| {
            before.since == now.since && before.power_cycle == now.power_cycle
        };
        match (before, attachment) {
            (Some(_), None) => self.set_attachment(node, None, controllers),
            (Some(before), Some(now)) if before == now => {}
            (Some(before), Some(now)) if is_same(before, now) => {
                self.set_attachment(node, Some(now), controllers);
            }
            (_, Some(_)) if !self.is_joining(node) => {
                // A controller that left and rejoined between two checks has left nevertheless.
                if before.is_some() {
                    self.set_attachment(node, None, controllers);
                }
                if let Some(asked) = controllers.with(node, |controller| controller.attachment()) {
                    self.plan(asked.since.clamp(self.now, until), Planned::Join(node, asked));
                }
            }
            _ => {}
        }
    }

    fn is_joining(&self, node: NodeIndex) -> bool {
        self.planned.iter().any(|(_, planned)| matches!(planned, Planned::Join(other, _) if *other == node))
    }

    /// Runs all segments to `until`, without a fault on the way. `changed`: there was an external change since the last
    /// run.
    fn run_to(&mut self, until: Time, changed: bool, controllers: &mut dyn Controllers) {
        let fine = Fine::from_time(until);
        for segment in 0..self.segments.len() {
            if changed || self.is_watched || !self.segments[segment].rests_until(fine) {
                self.with_stage(segment, controllers, |segment, stage| {
                    if changed {
                        segment.calendar = Calendar::default();
                    }
                    segment.run(fine, stage);
                });
            }
        }
        self.now = until;
    }

    /// Calls a function with one segment.
    fn with_stage<R>(
        &mut self,
        segment: usize,
        controllers: &mut dyn Controllers,
        work: impl FnOnce(&mut Segment, &mut Stage) -> R,
    ) -> R {
        let (planned, error) = self.next_faults();
        let mut stage = Stage {
            nodes: &mut self.nodes,
            controllers,
            observed: &mut self.observed,
            flips: &mut self.flips,
            horizon: Fine::from_time(planned.min(error)),
            fast: !self.config.bit_by_bit && self.recorder.is_none(),
            recorder: self.recorder.as_mut(),
            segment,
        };
        work(&mut self.segments[segment], &mut stage)
    }

    fn segment_of(&self, node: NodeIndex) -> usize {
        let is_here = |segment: &Segment| segment.members.contains(&node);
        self.segments.iter().position(is_here).expect("every node is on some piece")
    }

    /// Calls a function with the segment of a node, on the bit path.
    fn awake(
        &mut self,
        node: NodeIndex,
        controllers: &mut dyn Controllers,
        work: impl FnOnce(&mut Segment, &mut Stage),
    ) {
        let segment = self.segment_of(node);
        self.with_stage(segment, controllers, |segment, stage| {
            segment.wake(stage);
            work(segment, stage);
        });
    }

    fn wake_all(&mut self, controllers: &mut dyn Controllers) {
        for segment in 0..self.segments.len() {
            self.with_stage(segment, controllers, |segment, stage| _ = segment.wake(stage));
        }
    }

    fn set_attachment(
        &mut self,
        node: NodeIndex,
        attachment: Option<Attachment>,
        controllers: &mut dyn Controllers,
    ) {
        let brought = controllers.with(node, |controller| controller.brings());
        self.awake(node, controllers, |segment, stage| {
            let at = segment.cursor;
            let left = stage.nodes[node].mac.transmission.take();
            let stays = attachment.is_some() && left.is_some();
            stage.nodes[node].mac.attach(attachment, brought, at);
            if stays {
                stage.nodes[node].mac.transmission = left;
            } else {
                stage.destroyed(&mut segment.ledger, at, node, left.as_ref(), Destruction::TransmitterLeft);
            }
            segment.drive(node, stage);
        });
    }

    /// Applies a fault now.
    fn apply(&mut self, fault: Fault, controllers: &mut dyn Controllers) {
        match fault {
            Fault::Cut { position_m } => {
                let index = self.cuts.partition_point(|&cut| cut < position_m);
                if self.cuts.get(index) != Some(&position_m) {
                    self.cuts.insert(index, position_m);
                }
                self.rewire(controllers);
            }
            Fault::Restore { position_m } => {
                self.cuts.retain(|&cut| cut != position_m);
                self.rewire(controllers);
            }
            Fault::RestoreAll => {
                self.cuts.clear();
                self.rewire(controllers);
            }
            Fault::Short { position_m, level } => {
                self.shorts.push((position_m, level));
                self.rewire(controllers);
            }
            Fault::ClearShorts => {
                self.shorts.clear();
                self.rewire(controllers);
            }
            Fault::Disconnect(node) => self.set_connected(node, false, controllers),
            Fault::Reconnect(node) => self.set_connected(node, true, controllers),
            Fault::PowerOff(node) => {
                self.nodes[node].condition.unpowered = true;
                self.set_attachment(node, None, controllers);
            }
            Fault::PowerOn(node) => {
                if std::mem::take(&mut self.nodes[node].condition.unpowered) {
                    self.awake(node, controllers, |segment, stage| {
                        segment.drive(node, stage);
                        let counters = ErrorCounters::default();
                        if std::mem::replace(&mut stage.nodes[node].mac.counters, counters) != counters {
                            let at = segment.cursor;
                            stage.tell(&mut segment.ledger, at, node, WireEvent::Counters(counters), None);
                        }
                    });
                    self.look_at(node, self.now, controllers);
                }
            }
            Fault::StuckDominant(node) => self.set_stuck(node, true, controllers),
            Fault::ReleaseDriver(node) => self.set_stuck(node, false, controllers),
            Fault::Babble(node, frame) => {
                self.awake(node, controllers, |_, stage| {
                    stage.nodes[node].condition.babbles = Some(frame);
                });
            }
            Fault::StopBabbling(node) => self.nodes[node].condition.babbles = None,
            Fault::Drift(node, ppb) => {
                self.nodes[node].condition.drift_ppb = ppb;
                self.look_at(node, self.now, controllers);
            }
            Fault::Glitch { nodes, duration, effect } => {
                let (from, to) = (Fine::from_time(self.now), Fine::from_time(self.now + duration));
                for node in (0..self.nodes.len()).filter(|&node| nodes.contains(node)) {
                    self.awake(node, controllers, |segment, _| {
                        for (at, change) in
                            [(from, Change::GlitchBegins(effect)), (to, Change::GlitchEnds(effect))]
                        {
                            segment.arrivals().push_glitch(Arrival { at, node, change });
                        }
                    });
                }
            }
            Fault::Flip(flip) => {
                self.wake_all(controllers);
                self.flips.push(flip.among(self.nodes.len()));
            }
            Fault::BitErrors { rate, seed } => {
                self.errors = BitErrors::new(rate, seed, self.now, self.nodes.len())
            }
        }
    }

    fn set_connected(&mut self, node: NodeIndex, connected: bool, controllers: &mut dyn Controllers) {
        self.nodes[node].condition.disconnected = !connected;
        self.rewire(controllers);
    }

    fn set_stuck(&mut self, node: NodeIndex, stuck: bool, controllers: &mut dyn Controllers) {
        // In a reverted flight its driver was not stuck.
        self.awake(node, controllers, |segment, stage| {
            stage.nodes[node].condition.stuck_dominant = stuck;
            segment.drive(node, stage);
        });
    }

    /// The nodes of every piece of cable, left to right, then of every open stub; on a piece in the order of their
    /// place.
    fn pieces(&self) -> Vec<Vec<NodeIndex>> {
        let mut pieces = vec![Vec::new(); self.cuts.len() + 1];
        let mut stubs = Vec::new();
        let mut nodes: Vec<NodeIndex> = (0..self.nodes.len()).collect();
        nodes.sort_by_key(|&node| self.nodes[node].offset);
        for node in nodes {
            let Node { position_m, condition, .. } = &self.nodes[node];
            if condition.disconnected {
                stubs.push(vec![node]);
            } else {
                pieces[self.piece_at(*position_m)].push(node);
            }
        }
        pieces.append(&mut stubs);
        pieces
    }

    fn piece_at(&self, position_m: f64) -> usize {
        self.cuts.partition_point(|&cut| cut <= position_m)
    }

    /// Rebuilds the segments on the bit path after a change of cables, stubs or shorts.
    fn rewire(&mut self, controllers: &mut dyn Controllers) {
        let pieces = self.pieces();
        let mut before: Vec<Drivers> = vec![0; self.nodes.len()];
        let mut arrivals: Vec<Arrival> = Vec::new();
        for segment in 0..self.segments.len() {
            let mask = self.segments[segment].members.iter().fold(0, |mask, &node| mask | 1 << node);
            self.segments[segment].members.iter().for_each(|&node| before[node] = mask);
            let under_way =
                self.with_stage(segment, controllers, |segment, stage| std::mem::take(segment.wake(stage)));
            arrivals.extend(under_way.into_iter());
        }
        let old = std::mem::take(&mut self.segments);
        let mut ledgers: Vec<_> = old.into_iter().map(|segment| (segment.members, segment.ledger)).collect();
        let now = Fine::from_time(self.now);
        for (index, members) in pieces.iter().enumerate() {
            let mask: Drivers = members.iter().fold(0, |mask, &node| mask | 1 << node);
            let mut segment = Segment::new(members.clone(), now);
            segment.grounded = true;
            // The present frame continues on the segment of its transmitter.
            let sends = |&node: &NodeIndex| self.nodes[node].mac.transmission.is_some();
            let heir = members.iter().copied().find(sends).or(members.first().copied());
            if let Some(heir) = heir
                && let Some(position) = ledgers.iter().position(|(members, _)| members.contains(&heir))
            {
                segment.ledger = ledgers.swap_remove(position).1;
            }
            for &node in members {
                self.nodes[node].seen &= mask;
                let short = self.shorts.iter().rev().find(|&&(at, _)| self.piece_at(at) == index);
                let connected = !self.nodes[node].condition.disconnected;
                self.nodes[node].short = short.filter(|_| connected).map(|&(_, level)| level);
                for &driver in members {
                    let is_new = before[node] >> driver & 1 == 0;
                    if is_new && self.nodes[driver].driving_others {
                        let at = now + self.nodes[driver].path_to(&self.nodes[node]);
                        let arrival = Arrival { at, node, change: Change::Driver(DOMINANT, driver) };
                        segment.arrivals().push(arrival, now, &mut self.nodes[node].seen);
                    }
                }
            }
            self.segments.push(segment);
        }
        for arrival in arrivals {
            let segment = self.segment_of(arrival.node);
            let driver = match arrival.change {
                Change::Driver(_, driver) => driver,
                Change::GlitchBegins(_) | Change::GlitchEnds(_) => arrival.node,
            };
            if self.segments[segment].members.contains(&driver) {
                let seen = &mut self.nodes[arrival.node].seen;
                self.segments[segment].arrivals().push(arrival, now, seen);
            }
        }
        for segment in 0..self.segments.len() {
            self.with_stage(segment, controllers, |segment, stage| {
                for n in 0..segment.members.len() {
                    segment.relevel(segment.members[n], now, stage);
                }
            });
        }
    }
}
