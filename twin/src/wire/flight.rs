//! The fast path: an undisturbed frame, computed as a whole.
//!
//! For one transmitter and synchronised receivers only the edges of the frame matter. Each receiver's clock is advanced
//! from edge to edge with the same arithmetic as on the bit path, and every sample is checked to be within its bit. The
//! acknowledgement, whose first edge is the earliest of all receivers', and the recessive end follow. All other cases
//! (another contender, a sample outside its bit, a future disturbance) are left to the bit path.

use std::collections::VecDeque;

use crate::wire::arrivals::Arrivals;
use crate::wire::calendar::Calendar;
use crate::wire::controller::{ErrorKind, NodeIndex, WireEvent};
use crate::wire::encode::INTERMISSION_BITS;
use crate::wire::fine::Fine;
use crate::wire::mac::{DOMINANT, RECESSIVE, State, Transmission};
use crate::wire::node::Node;
use crate::wire::segment::{Flight, Landing, Lines, Mode, Segment};
use crate::wire::stage::Stage;
use crate::wire::timing::{BitClock, Edge};

/// ACK delimiter and EOF.
const RECESSIVE_END: u64 = 8;
/// Bits of an error flag and its delimiter that no other node extends.
const ERROR_FRAME: u64 = 14;
const FLAG: u64 = 6;

/// A node that takes part, with its present bit.
struct Participant {
    node: NodeIndex,
    clock: BitClock,
    transmits: bool,
    silent: bool,
}

/// A frame to compute: `own`, of which the transmitter sends bit `index`; 0 for a flight that begins with its SOF.
struct Plan<'a> {
    own: &'a Transmission,
    index: usize,
    /// Clock of the transmitter at bit `index`.
    clock: BitClock,
    transmitter: NodeIndex,
    /// Level changes that the transmitter will make up to the CRC delimiter.
    edges: Vec<Edge>,
}

impl<'a> Plan<'a> {
    fn new(own: &'a Transmission, index: usize, clock: BitClock, transmitter: NodeIndex) -> Self {
        let delimiter = own.encoded.stuffed_len();
        let bits = own.encoded.bits();
        let mut edges = Vec::with_capacity(own.encoded.changes().len());
        let mut before = index;
        for bit in own.encoded.changes().filter(|&bit| bit > index && bit <= delimiter) {
            let at = clock.end + clock.bit.times((bit - index) as u64 - 1);
            edges.push(Edge { bits: (bit - before) as u64, at, level: bits[bit] });
            before = bit;
        }
        Plan { own, index, clock, transmitter, edges }
    }

    fn with_sof(&self) -> bool {
        self.index == 0
    }

    /// CRC delimiter.
    fn delimiter(&self) -> usize {
        self.own.encoded.stuffed_len()
    }

    /// Bits from the last change to the CRC delimiter.
    fn rest(&self) -> u64 {
        let led: u64 = self.edges.iter().map(|edge| edge.bits).sum();
        (self.delimiter() - self.index) as u64 - led
    }
}

/// Changes the level from `before` at `edge`, between the sample of the present bit and that of the next.
fn pass_edge(mut clock: BitClock, edge: Fine, before: bool, sends_dominant: bool) -> Option<BitClock> {
    let apply = |clock: &mut BitClock, sends_dominant| {
        if before == RECESSIVE {
            clock.dominant_edge(edge, sends_dominant);
        } else {
            clock.recessive_edge(edge);
        }
    };
    if edge < clock.end {
        if edge <= clock.sample || clock.latched.is_some() {
            return None;
        }
        // In this bit the node still sends the level of the line.
        apply(&mut clock, before == DOMINANT && sends_dominant);
        clock.next_bit(before);
    } else {
        clock.next_bit(before);
        if edge > clock.sample {
            return None;
        }
        apply(&mut clock, sends_dominant);
    }
    (edge <= clock.sample).then_some(clock)
}

impl Segment {
    /// Starts `own` of `node` now, on an idle line.
    pub(in crate::wire) fn launch(&mut self, node: NodeIndex, own: Transmission, stage: &mut Stage) {
        for n in 0..self.members.len() {
            self.catch_up(self.members[n], self.cursor, stage);
        }
        if stage.fast
            && let Some(flight) = self.plan_from_sof(node, &own, stage)
        {
            let bit = flight.landings[0].clock.bit;
            self.ledger.start(own.start, bit, stage.observed);
            stage.started(&mut self.ledger, own.start, own.start, node);
            self.mode = Mode::Flight(Box::new(flight));
            return;
        }
        self.mode = Mode::Bits(Arrivals::default());
        self.calendar = Calendar::default();
        self.begin(node, own, stage);
        self.drive(node, stage);
    }

    /// Changes to a flight when arbitration is over and all nodes are synchronised.
    pub(in crate::wire) fn try_take_off(&mut self, stage: &mut Stage) -> bool {
        if !stage.fast
            || self.grounded
            || !stage.flips.is_empty()
            || !self.arrivals().is_empty()
            || !self.is_in_step(stage)
        {
            return false;
        }
        match self.plan_from_here(stage) {
            Some(flight) => {
                self.mode = Mode::Flight(Box::new(flight));
                true
            }
            None => {
                self.grounded = true;
                false
            }
        }
    }

    /// Returns whether one node transmits after its arbitration, and all other participants have received the same
    /// bits.
    fn is_in_step(&self, stage: &Stage) -> bool {
        let mut first: Option<NodeIndex> = None;
        let mut transmitters = 0;
        for &node in &self.members {
            let mac = &stage.nodes[node].mac;
            match mac.state {
                State::Off | State::BusOff => continue,
                State::Stuffed => {}
                _ => return false,
            }
            if let Some(own) = &mac.transmission {
                transmitters += 1;
                // A node that became silent within the frame reaches no other node.
                if mac.decoder.index() < own.encoded.arbitration_len() || mac.is_silent() {
                    return false;
                }
            }
            let leader = *first.get_or_insert(node);
            if stage.nodes[leader].mac.decoder != mac.decoder {
                return false;
            }
        }
        transmitters == 1
    }

    fn plan_from_here(&self, stage: &mut Stage) -> Option<Flight> {
        let sends = |&&node: &&NodeIndex| stage.nodes[node].mac.transmission.is_some();
        let transmitter = *self.members.iter().find(sends)?;
        let mac = &stage.nodes[transmitter].mac;
        let (clock, index) = (mac.clock, mac.decoder.index());
        let own = mac.transmission.clone()?;
        let level = own.encoded.bits()[index];
        let mut participants = Vec::with_capacity(self.members.len());
        for &node in &self.members {
            let this = &stage.nodes[node];
            if !this.mac.is_running() {
                continue;
            }
            if this.level != level || this.mac.clock.latched.is_some() {
                return None;
            }
            participants.push(Participant {
                node,
                clock: this.mac.clock,
                transmits: node == transmitter,
                silent: this.mac.is_silent(),
            });
        }
        let plan = Plan::new(&own, index, clock, transmitter);
        self.plan(&plan, participants, stage)
    }

    fn plan_from_sof(&self, transmitter: NodeIndex, own: &Transmission, stage: &mut Stage) -> Option<Flight> {
        let timing = stage.nodes[transmitter].mac.attachment?.timing;
        let mut clock = BitClock::new(timing, own.start);
        clock.restart(timing, own.start);
        let mut participants = Vec::with_capacity(self.members.len());
        for &node in &self.members {
            let this = &stage.nodes[node];
            if this.level != RECESSIVE {
                return None;
            }
            if node == transmitter {
                participants.push(Participant { node, clock, transmits: true, silent: false });
                continue;
            }
            let arrival = own.start + stage.nodes[transmitter].path_to(this);
            let silent = this.mac.is_silent();
            let babbles = this.condition.babbles.is_some();
            let clock = match this.mac.state {
                State::Off | State::BusOff => continue,
                State::Idle => this.mac.clock_from_edge(arrival),
                _ => return None,
            };
            let mut waits = || stage.request_at(node).is_some_and(|request| request <= arrival);
            if !silent && (babbles || waits()) {
                return None;
            }
            participants.push(Participant { node, clock, transmits: false, silent });
        }
        let plan = Plan::new(own, 0, clock, transmitter);
        self.plan(&plan, participants, stage)
    }

    fn plan(&self, plan: &Plan, participants: Vec<Participant>, stage: &mut Stage) -> Option<Flight> {
        let sample = plan.clock.sample - plan.clock.start;
        let disturbed = self.members.iter().any(|&node| !stage.nodes[node].is_undisturbed());
        let slow = self.members.iter().any(|&node| stage.nodes[node].path_to(&stage.nodes[node]) > sample);
        if disturbed || !stage.flips.is_empty() || slow {
            return None;
        }
        let flight = if participants.len() == 1 {
            if !plan.with_sof() {
                return None;
            }
            self.alone(plan, stage)
        } else {
            self.acknowledged(plan, participants, stage)?
        };
        (flight.end < stage.horizon).then_some(flight)
    }

    /// Computes a flight without other nodes: a missing acknowledgement and its error frame.
    fn alone(&self, plan: &Plan, stage: &Stage) -> Flight {
        let node = plan.transmitter;
        let bit = plan.clock.bit;
        let mut counters = stage.nodes[node].mac.counters;
        let passive = counters.error_passive();
        let mut clock = plan.clock;
        clock.skip(plan.delimiter() as u64 + 2, RECESSIVE);
        let seen = clock.start;
        let mut agenda = VecDeque::from([(seen, node, WireEvent::TransmitError(ErrorKind::Ack))]);
        if !passive {
            counters.add_eight(true);
            agenda.push_back((seen, node, WireEvent::Counters(counters)));
        }
        clock.skip(ERROR_FRAME, RECESSIVE);
        let lines = self.lines(plan, stage, |distance| {
            let flag = (seen + distance, seen + bit.times(FLAG) + distance);
            (!passive).then_some(flag)
        });
        Flight {
            from: self.cursor,
            own: plan.own.clone(),
            transmitter: node,
            with_sof: true,
            agenda,
            end: clock.start,
            landings: vec![Landing { node, clock, counters }],
            lines,
        }
    }

    /// Computes a flight that other nodes acknowledge.
    fn acknowledged(&self, plan: &Plan, mut participants: Vec<Participant>, stage: &Stage) -> Option<Flight> {
        let rest = plan.rest();
        for participant in &mut participants {
            participant.clock = if participant.transmits {
                let mut clock = plan.clock;
                clock.skip((plan.delimiter() - plan.index) as u64, RECESSIVE);
                clock
            } else {
                let delay = stage.nodes[plan.transmitter].path_to(&stage.nodes[participant.node]);
                participant.clock.follow(&plan.edges, delay, rest)?
            };
        }
        let pulses = self.acknowledge(&mut participants, stage)?;
        let mut lines = self.lines(plan, stage, |_| None);
        for (node, changes) in &mut lines {
            let (from, to) = pulses.seen_by(*node, stage);
            changes.extend([(from, DOMINANT), (to, RECESSIVE)]);
        }
        self.land(plan, participants, lines, stage)
    }

    /// Advances all nodes from the CRC delimiter to intermission.
    fn acknowledge(&self, participants: &mut [Participant], stage: &Stage) -> Option<Pulses> {
        let place = |node: NodeIndex| stage.nodes[node].offset;
        let mut pulses = Pulses::default();
        for participant in &*participants {
            pulses.begins.push(participant, participant.clock.end, &stage.nodes[participant.node]);
        }
        for participant in &mut *participants {
            let edge = pulses.begins.reaching(participant.node, stage, Fine::min)?;
            participant.clock = pass_edge(participant.clock, edge, RECESSIVE, !participant.transmits)?;
        }
        for participant in &*participants {
            pulses.ends.push(participant, participant.clock.end, &stage.nodes[participant.node]);
        }
        let extent = match (self.members.first(), self.members.last()) {
            (Some(&left), Some(&right)) => place(right) - place(left),
            _ => Fine(0),
        };
        // The acknowledgement must be one pulse without a gap at every node.
        if pulses.begins.all().max()? + extent > pulses.ends.all().min()? {
            return None;
        }
        for participant in &mut *participants {
            let edge = pulses.ends.reaching(participant.node, stage, Fine::max)?;
            participant.clock = pass_edge(participant.clock, edge, DOMINANT, false)?;
            participant.clock.skip(RECESSIVE_END, RECESSIVE);
        }
        Some(pulses)
    }

    /// Returns the events at the end of an acknowledged frame, and the state of all nodes then.
    fn land(
        &self,
        plan: &Plan,
        participants: Vec<Participant>,
        lines: Lines,
        stage: &Stage,
    ) -> Option<Flight> {
        let bit = plan.clock.bit;
        let starts = participants.iter().map(|participant| participant.clock.start);
        let (earliest, end) = (starts.clone().min()?, starts.max()?);
        if end > earliest + bit {
            return None;
        }
        let mut agenda = Vec::with_capacity(2 * participants.len());
        let mut landings = Vec::with_capacity(participants.len());
        for Participant { node, clock, transmits, .. } in participants {
            let before = stage.nodes[node].mac.counters;
            let mut counters = before;
            let (at, event) = if transmits {
                counters.transmitted();
                (clock.start, WireEvent::Transmitted)
            } else {
                counters.received();
                (clock.start - clock.bit, WireEvent::Received(plan.own.frame))
            };
            agenda.push((at, node, event));
            if counters != before {
                agenda.push((at, node, WireEvent::Counters(counters)));
            }
            landings.push(Landing { node, clock, counters });
        }
        agenda.sort_by_key(|&(at, ..)| at);
        Some(Flight {
            from: self.cursor,
            own: plan.own.clone(),
            transmitter: plan.transmitter,
            with_sof: plan.with_sof(),
            agenda: agenda.into(),
            landings,
            end,
            lines,
        })
    }

    /// Returns the level changes for nodes that watch their line, up to the CRC delimiter, and an error flag if there
    /// is one.
    fn lines(&self, plan: &Plan, stage: &Stage, flag: impl Fn(Fine) -> Option<(Fine, Fine)>) -> Lines {
        let watching = self.members.iter().filter(|&&node| stage.nodes[node].watches);
        let line = |&node: &NodeIndex| {
            let delay = stage.nodes[plan.transmitter].path_to(&stage.nodes[node]);
            let mut changes = VecDeque::with_capacity(plan.own.encoded.changes().len());
            if plan.with_sof() {
                changes.push_back((plan.clock.start + delay, DOMINANT));
            }
            changes.extend(plan.edges.iter().map(|edge| (edge.at + delay, edge.level)));
            if let Some((from, to)) = flag(delay) {
                changes.extend([(from, DOMINANT), (to, RECESSIVE)]);
            }
            (node, changes)
        };
        watching.map(line).collect()
    }

    /// Returns whether a node that the SOF has not reached yet requests a frame that was unknown when the flight began.
    fn is_contested(&self, flight: &Flight, stage: &mut Stage) -> bool {
        flight.with_sof
            && self.cursor <= flight.own.start + flight.own.bit
            && flight.landings.iter().any(|&Landing { node, .. }| {
                let delay = stage.nodes[flight.transmitter].path_to(&stage.nodes[node]);
                let arrival = flight.own.start + delay;
                node != flight.transmitter
                    && self.cursor <= arrival
                    && !stage.nodes[node].mac.is_silent()
                    && stage.request_at(node).is_some_and(|request| request <= arrival)
            })
    }

    /// Continues a flight. Returns `true` if nothing more happens up to `until`.
    pub(in crate::wire) fn run_flight(&mut self, until: Fine, stage: &mut Stage) -> bool {
        if let Mode::Flight(flight) = &self.mode
            && self.is_contested(flight, stage)
        {
            self.replay(stage);
            return false;
        }
        let Mode::Flight(flight) = &mut self.mode else { return false };
        while let Some((at, node, event)) = flight.agenda.pop_front_if(|(at, ..)| *at <= until) {
            stage.tell(&mut self.ledger, at, node, event, Some(&flight.own));
        }
        for (node, line) in &mut flight.lines {
            while let Some((at, level)) = line.pop_front_if(|(at, _)| *at <= until) {
                stage.nodes[*node].changes.push((at.floor(), level));
            }
        }
        if flight.end > until {
            self.next = flight.agenda.front().map_or(flight.end, |&(at, ..)| at);
            return true;
        }
        for Landing { node, clock, counters } in &flight.landings {
            let mac = &mut stage.nodes[*node].mac;
            mac.clock = *clock;
            mac.counters = *counters;
            mac.state = State::Intermission(0);
            mac.transmitter = *node == flight.transmitter;
            mac.transmission = None;
            mac.finished = None;
            stage.nodes[*node].driving = false;
            stage.nodes[*node].driving_others = false;
        }
        for &node in &self.members {
            stage.nodes[node].seen = 0;
            stage.nodes[node].level = RECESSIVE;
        }
        self.cursor = flight.end;
        let bit = stage.nodes[flight.transmitter].mac.clock.bit;
        self.ledger.calm(flight.end + bit.times(INTERMISSION_BITS), stage.observed);
        self.mode = Mode::Still;
        false
    }

    /// Reverts a flight to its beginning and repeats it bit by bit up to now, without reporting events.
    pub(in crate::wire) fn replay(&mut self, stage: &mut Stage) {
        let Mode::Flight(flight) = std::mem::replace(&mut self.mode, Mode::Bits(Arrivals::default())) else {
            return;
        };
        let reached = self.cursor;
        self.cursor = flight.from;
        self.ledger.told_until = Some(reached);
        self.grounded = true;
        self.replaying = true;
        if flight.with_sof {
            self.begin(flight.transmitter, flight.own, stage);
            self.drive(flight.transmitter, stage);
        }
        self.calendar = Calendar::default();
        self.run_bits(reached, stage);
        self.calendar = Calendar::default();
        self.replaying = false;
        self.ledger.told_until = None;
        self.cursor = reached;
    }
}

/// Edges of the acknowledgement: its beginning and its end.
#[derive(Default)]
struct Pulses {
    begins: Origins,
    ends: Origins,
}

impl Pulses {
    /// Returns the first and last dominant instant at `node`.
    fn seen_by(&self, node: NodeIndex, stage: &Stage) -> (Fine, Fine) {
        let from = self.begins.reaching(node, stage, Fine::min).unwrap_or(Fine::NEVER);
        (from, self.ends.reaching(node, stage, Fine::max).unwrap_or(Fine::NEVER))
    }
}

/// Level changes that propagate from several nodes.
#[derive(Default)]
struct Origins {
    /// Instant at which the level is on the line, and position.
    heard_by_all: Vec<(Fine, Fine)>,
    /// Level changes of silent nodes, which only they themselves see.
    silent: Vec<(NodeIndex, Fine)>,
}

impl Origins {
    fn push(&mut self, participant: &Participant, at: Fine, from: &Node) {
        let at = at + from.driver;
        match participant {
            Participant { transmits: true, .. } => {}
            Participant { silent: true, node, .. } => self.silent.push((*node, at)),
            Participant { .. } => self.heard_by_all.push((at, from.offset)),
        }
    }

    /// Returns the instant that `pick` selects of all that reach `node`; `None` if only silent nodes acknowledge.
    fn reaching(&self, node: NodeIndex, stage: &Stage, pick: fn(Fine, Fine) -> Fine) -> Option<Fine> {
        let place = stage.nodes[node].offset;
        let heard = self.heard_by_all.iter().map(|&(at, from)| at + Fine(from.0.abs_diff(place.0)));
        let first = heard.reduce(pick)?;
        let own = self.silent.iter().find(|(silent, _)| *silent == node).map_or(first, |&(_, at)| at);
        Some(pick(first, own) + stage.nodes[node].receiver)
    }

    fn all(&self) -> impl Iterator<Item = Fine> {
        self.heard_by_all.iter().map(|&(at, _)| at).chain(self.silent.iter().map(|&(_, at)| at))
    }
}
