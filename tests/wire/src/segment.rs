//! One connected piece of a wire, and the frame on it: the frame-level engine.
//!
//! A frame is one object from SOF to EOF. What its bits would do to the controllers is put on an agenda when the frame
//! starts and when its ACK slot has passed. Error frames are of fixed length: a flag of 6 bits after a missing
//! acknowledgement, of 12 (flag and echo) after every other error, and a delimiter of 8.

use std::sync::Arc;

use crate::arbitration::{Outcome, arbitrate};
use crate::controller::{ErrorKind, NodeIndex, Trace, WireEvent};
use crate::encode::{Encoded, INTERMISSION_BITS, encode};
use crate::frame::WireFrame;
use crate::record::{Counters, Destruction, Record};
use crate::time::Time;
use crate::wire::Controllers;

/// Wait of an error-passive transmitter beyond the intermission.
const SUSPEND_BITS: u64 = 8;
/// Six equal bits break the stuffing rule.
const STUFF_ERROR_BITS: u64 = 6;
const ERROR_FLAG_BITS: u64 = 6;
const ERROR_DELIMITER_BITS: u64 = 8;
/// Bits of SOF and a standard identifier: where contenders of different bit times have met a bit error for certain.
const IDENTIFIER_BITS: u64 = 12;

/// What is to be told, or decided, at an instant of the agenda.
#[derive(Clone, Copy, Debug)]
enum Action {
    Tell(NodeIndex, Told),
    Receive(NodeIndex),
    Collision,
    AckSlot,
    Complete,
}

#[derive(Clone, Copy, Debug)]
enum Told {
    Lost,
    TransmitError(ErrorKind),
    ReceiveError(ErrorKind),
}

#[derive(Debug)]
struct Listener {
    node: NodeIndex,
    /// Its bit time matches the transmitter's.
    understands: bool,
}

#[derive(Debug)]
struct Flight {
    trace: Arc<Trace>,
    /// The first one owns the trace; more when several sent the same bits.
    transmitters: Vec<NodeIndex>,
    listeners: Vec<Listener>,
    receivers: Vec<(NodeIndex, Time)>,
    /// The ACK slot passed with an acknowledgement: from here on the frame survives cuts and resets.
    acknowledged: bool,
}

/// A controller that waits for the bus.
#[derive(Clone, Copy)]
struct Waiting {
    node: NodeIndex,
    /// When it would begin its SOF.
    at: Time,
    bit: Time,
}

/// What an engine step needs from the wire around it.
pub(crate) struct Surroundings<'a> {
    pub(crate) controllers: &'a mut dyn Controllers,
    /// Propagation delay of each node from the left end.
    pub(crate) offsets: &'a [Time],
    pub(crate) observed: &'a mut Observed,
    /// Index of the segment, for the records.
    pub(crate) index: usize,
}

/// What observers are told.
#[derive(Debug, Default)]
pub(crate) struct Observed {
    pub(crate) records: Vec<Record>,
    pub(crate) counters: Counters,
}

impl Surroundings<'_> {
    fn bit_time(&mut self, node: NodeIndex) -> Option<Time> {
        self.controllers.controller(node).bit_time()
    }

    fn tell(&mut self, node: NodeIndex, at: Time, event: &WireEvent) {
        self.controllers.controller(node).on_wire(at, event);
    }

    fn delay(&self, from: NodeIndex, to: NodeIndex) -> Time {
        Time(self.offsets[from].0.abs_diff(self.offsets[to].0))
    }
}

/// One connected piece of a wire.
#[derive(Debug, Default)]
pub(crate) struct Segment {
    /// Nodes on this piece, ascending.
    pub(crate) members: Vec<NodeIndex>,
    flight: Option<Flight>,
    /// In the order of time; equal times in the order of insertion.
    agenda: Vec<(Time, Action)>,
    /// End of the last dominant bit; may lie ahead during an error frame.
    recessive_since: Time,
    /// End of the last frame or error delimiter.
    busy_until: Time,
    /// End of the intermission after it.
    free_from: Time,
    /// Length of a bit of the last frame.
    bit: Time,
    /// Where the last frame came from: its end reaches the others later.
    origin: Option<NodeIndex>,
    /// Who sent the last frame, for the suspend rule.
    suspended: Vec<NodeIndex>,
    /// When the arbitration of those that wait can be decided, as of the last [`Segment::due`].
    decision: Option<Time>,
    /// Everybody who asked for the bus withdrew; not to be asked again before the next advance.
    stalled: bool,
}

impl Segment {
    /// Since when the line is recessive without a frame, `None` while it is busy.
    pub(crate) fn idle_since(&self, now: Time) -> Option<Time> {
        let quiet =
            self.flight.as_ref().is_none_or(|flight| flight.acknowledged) && self.recessive_since <= now;
        quiet.then_some(self.recessive_since)
    }

    /// The next instant after `now` at which something happens here by itself.
    pub(crate) fn next_event(&self, now: Time) -> Option<Time> {
        let agenda = self.agenda.first().map(|&(at, _)| at);
        let free = (self.flight.is_none() && self.free_from > now).then_some(self.free_from);
        [agenda, free, self.decision].into_iter().flatten().min()
    }

    /// The next instant at which [`Segment::step`] has something to do.
    pub(crate) fn due(&mut self, around: &mut Surroundings) -> Option<Time> {
        self.decision = if self.stalled { None } else { self.decision_at(around) };
        let agenda = self.agenda.first().map(|&(at, _)| at);
        [agenda, self.decision].into_iter().flatten().min()
    }

    /// Does what is due at `at`.
    pub(crate) fn step(&mut self, at: Time, around: &mut Surroundings) {
        if self.agenda.first().is_some_and(|&(due, _)| due <= at) {
            let (due, action) = self.agenda.remove(0);
            self.act(due, action, around);
        } else {
            self.stalled = !self.start(around);
        }
    }

    /// Begins an advance: takes nodes that left the bus off the frame in flight, which dies with its last transmitter.
    pub(crate) fn drop_absent(&mut self, now: Time, around: &mut Surroundings) {
        self.stalled = false;
        let Some(flight) = &mut self.flight else { return };
        flight.listeners.retain(|listener| around.bit_time(listener.node).is_some());
        if flight.acknowledged {
            return;
        }
        flight.transmitters.retain(|&node| around.bit_time(node).is_some());
        if flight.transmitters.is_empty() {
            let at = self.agenda.first().map_or(now, |&(due, _)| due.min(now));
            let flight = self.end_flight(at, Destruction::TransmitterLeft, around.observed, around.index);
            let listeners = flight.listeners.into_iter().map(|listener| listener.node).collect();
            self.orphan(at, listeners);
            around.observed.counters.busy += self.free_from.since(flight.trace.start);
        }
    }

    /// When the SOF of `node` would begin if nobody else was there.
    fn waiting(&self, node: NodeIndex, around: &mut Surroundings) -> Option<Waiting> {
        let controller = around.controllers.controller(node);
        let bit = controller.bit_time()?;
        let request = controller.request_at()?;
        let mut free = self.free_from;
        if self.suspended.contains(&node) && controller.error_passive() {
            free += bits(self.bit, SUSPEND_BITS);
        }
        if let Some(origin) = self.origin {
            free += around.delay(origin, node);
        }
        Some(Waiting { node, at: request.max(free), bit })
    }

    /// The one whose SOF comes first; ties go to the lower index, which matters for nothing but the order of events.
    fn first(&self, around: &mut Surroundings) -> Option<Waiting> {
        self.members.iter().filter_map(|&node| self.waiting(node, around)).min_by_key(|waiting| waiting.at)
    }

    /// The contenders are known when the SOF of the first one has passed.
    fn decision_at(&self, around: &mut Surroundings) -> Option<Time> {
        if self.flight.is_some() {
            return None;
        }
        self.first(around).map(|first| first.at + first.bit)
    }

    /// Arbitrates among all whose SOF begins within the first one's SOF.
    fn start(&mut self, around: &mut Surroundings) -> bool {
        let Some(first) = self.first(around) else { return false };
        let mut contenders: Vec<Waiting> = Vec::new();
        let mut frames: Vec<WireFrame> = Vec::new();
        for &node in &self.members {
            let Some(waiting) = self.waiting(node, around).filter(|w| w.at < first.at + first.bit) else {
                continue;
            };
            if let Some(frame) = around.controllers.controller(node).contend(waiting.at) {
                contenders.push(waiting);
                frames.push(frame);
            }
        }
        let Some(first) = contenders.iter().min_by_key(|waiting| waiting.at).copied() else { return false };
        for waiting in &contenders {
            around.tell(waiting.node, waiting.at, &WireEvent::Started);
        }
        let encoded: Vec<Encoded> = frames.iter().map(encode).collect();
        let matching = contenders.iter().all(|waiting| understands(first.bit, waiting.bit));
        let Outcome { transmitters, lost, collision } = if matching {
            arbitrate(&encoded)
        } else {
            Outcome { transmitters: (0..contenders.len()).collect(), lost: Vec::new(), collision: None }
        };

        let Some(&winner) = transmitters.iter().min_by_key(|&&c| contenders[c].at) else { return false };
        let Waiting { node, at, bit } = contenders[winner];
        // Whoever has not begun when the first SOF arrives synchronises to it.
        let start = at.min(first.at + around.delay(first.node, node));
        let trace = Arc::new(encoded[winner].trace(frames[winner], node, start, bit));
        let transmitters: Vec<NodeIndex> = transmitters.into_iter().map(|c| contenders[c].node).collect();
        let mut listeners = Vec::new();
        for &member in &self.members {
            if transmitters.contains(&member) {
                continue;
            }
            if let Some(own) = around.bit_time(member) {
                listeners.push(Listener { node: member, understands: understands(bit, own) });
            }
        }

        for (contender, bit_index) in lost {
            let told = start + bits(bit, bit_index as u64 + 1);
            self.plan(told, Action::Tell(contenders[contender].node, Told::Lost));
        }
        match collision {
            Some(bit_index) => self.plan(start + bits(bit, bit_index as u64 + 1), Action::Collision),
            None if !matching => self.plan(start + bits(bit, IDENTIFIER_BITS), Action::Collision),
            None => {
                self.plan(start + bits(bit, encoded[winner].acknowledged_len() as u64), Action::AckSlot);
            }
        }
        self.bit = bit;
        self.origin = Some(node);
        self.suspended.clear();
        self.suspended.extend(&transmitters);
        self.decision = None;
        self.flight =
            Some(Flight { trace, transmitters, listeners, receivers: Vec::new(), acknowledged: false });
        true
    }

    fn act(&mut self, at: Time, action: Action, around: &mut Surroundings) {
        match action {
            Action::Tell(node, told) => around.tell(node, at, &told.event()),
            Action::Receive(node) => {
                let Some(flight) = &mut self.flight else { return };
                if flight.listeners.iter().any(|listener| listener.node == node) {
                    flight.receivers.push((node, at));
                    around.tell(node, at, &WireEvent::Received(Arc::clone(&flight.trace)));
                }
            }
            Action::Collision => {
                let flight = self.end_flight(at, Destruction::Collision, around.observed, around.index);
                for &node in &flight.transmitters {
                    around.tell(node, at, &WireEvent::TransmitError(ErrorKind::BitRecessive));
                }
                for listener in flight.listeners {
                    let seen = at + bits(self.bit, STUFF_ERROR_BITS);
                    self.plan_error(seen, listener.node, Told::ReceiveError(ErrorKind::Stuff));
                }
                self.error_frame(at, 2 * ERROR_FLAG_BITS);
                around.observed.counters.busy += self.free_from.since(flight.trace.start);
            }
            Action::AckSlot => self.ack_slot(at, around),
            Action::Complete => self.complete(at, around),
        }
    }

    fn ack_slot(&mut self, at: Time, around: &mut Surroundings) {
        let Some(mut flight) = self.flight.take() else { return };
        flight.listeners.retain(|listener| {
            if !listener.understands {
                around.tell(listener.node, at, &WireEvent::ReceiveError(ErrorKind::Form));
            }
            listener.understands
        });
        let acknowledges = |listener: &Listener| around.controllers.controller(listener.node).acknowledges();
        flight.acknowledged = flight.listeners.iter().any(acknowledges);
        if flight.acknowledged {
            self.recessive_since = at;
            let trace = &flight.trace;
            for listener in &flight.listeners {
                let valid = trace.end - trace.bit_time + around.delay(trace.transmitter, listener.node);
                self.plan(valid.min(trace.end), Action::Receive(listener.node));
            }
            self.plan(trace.end, Action::Complete);
            self.flight = Some(flight);
            return;
        }
        let passive =
            flight.transmitters.iter().all(|&node| around.controllers.controller(node).error_passive());
        let start = flight.trace.start;
        self.flight = Some(flight);
        let flight = self.end_flight(at, Destruction::Unacknowledged, around.observed, around.index);
        for &node in &flight.transmitters {
            around.tell(node, at, &WireEvent::TransmitError(ErrorKind::Ack));
        }
        for listener in &flight.listeners {
            around.tell(listener.node, at, &WireEvent::ReceiveError(ErrorKind::Form));
        }
        self.error_frame(at, ERROR_FLAG_BITS);
        if passive {
            // A passive flag is recessive, as were CRC delimiter and ACK slot.
            self.recessive_since = at - bits(self.bit, 2);
        }
        around.observed.counters.busy += self.free_from.since(start);
    }

    fn complete(&mut self, at: Time, around: &mut Surroundings) {
        let Some(flight) = self.flight.take() else { return };
        self.busy_until = at;
        self.free_from = at + bits(self.bit, INTERMISSION_BITS);
        for &node in &flight.transmitters {
            if around.bit_time(node).is_some() {
                around.tell(node, at, &WireEvent::Transmitted(Arc::clone(&flight.trace)));
            }
        }
        let observed = &mut *around.observed;
        observed.counters.completed += 1;
        observed.counters.busy += self.free_from.since(flight.trace.start);
        observed.records.push(Record::Completed {
            trace: flight.trace,
            receivers: flight.receivers,
            segment: around.index,
        });
    }

    /// Takes the flight off the wire unfinished. What was planned for it is forgotten; losers of its arbitration who
    /// do not know it yet get to know at once, so that the error that follows finds them as receivers.
    fn end_flight(&mut self, at: Time, cause: Destruction, observed: &mut Observed, index: usize) -> Flight {
        let flight = self.flight.take().expect("only called with a frame in flight");
        self.agenda.retain(|(_, action)| matches!(action, Action::Tell(..)));
        self.tell_losers(at);
        match cause {
            Destruction::Unacknowledged => observed.counters.ack_errors += 1,
            _ => observed.counters.destroyed += 1,
        }
        let Trace { frame, transmitter, start, .. } = *flight.trace;
        observed.records.push(Record::Destroyed { frame, transmitter, start, at, cause, segment: index });
        flight
    }

    /// The line went recessive within a frame: `listeners` see a stuff error and flag it.
    fn orphan(&mut self, at: Time, listeners: Vec<NodeIndex>) {
        if listeners.is_empty() {
            self.recessive_since = at;
            self.busy_until = at;
            self.free_from = at + bits(self.bit, INTERMISSION_BITS);
            return;
        }
        let seen = at + bits(self.bit, STUFF_ERROR_BITS);
        for node in listeners {
            self.plan_error(seen, node, Told::ReceiveError(ErrorKind::Stuff));
        }
        self.error_frame(seen, ERROR_FLAG_BITS);
    }

    fn error_frame(&mut self, at: Time, flag_bits: u64) {
        self.recessive_since = at + bits(self.bit, flag_bits);
        self.busy_until = self.recessive_since + bits(self.bit, ERROR_DELIMITER_BITS);
        self.free_from = self.busy_until + bits(self.bit, INTERMISSION_BITS);
    }

    fn plan(&mut self, at: Time, action: Action) {
        let index = self.agenda.partition_point(|&(due, _)| due <= at);
        self.agenda.insert(index, (at, action));
    }

    fn plan_error(&mut self, at: Time, node: NodeIndex, told: Told) {
        self.plan(at, Action::Tell(node, told));
    }

    /// Cuts the members that `is_right` names off: the left piece, and the right one.
    ///
    /// A frame whose ACK slot has passed stays whole: its rest is recessive on both sides. Before that it goes on at
    /// its transmitter; the nodes of the other side see a stuff error, and what they themselves were sending of the
    /// same frame is a bit error.
    pub(crate) fn split(mut self, at: Time, is_right: impl Fn(NodeIndex) -> bool) -> (Segment, Segment) {
        let flight_is_right = self.flight.as_ref().is_some_and(|flight| is_right(flight.trace.transmitter));
        let is_far = |node: NodeIndex| is_right(node) != flight_is_right;
        let (far, near) = self.members.iter().partition(|&&node| is_far(node));
        self.members = near;
        let mut other = Segment {
            members: far,
            recessive_since: self.recessive_since,
            busy_until: self.busy_until,
            free_from: self.free_from,
            bit: self.bit,
            origin: self.origin,
            suspended: self.suspended.clone(),
            decision: self.decision,
            ..Segment::default()
        };
        match &mut self.flight {
            Some(flight) if flight.acknowledged => {
                other.free_from = flight.trace.end + bits(self.bit, INTERMISSION_BITS);
            }
            Some(flight) => {
                let (gone, stay): (Vec<_>, Vec<_>) =
                    flight.listeners.drain(..).partition(|listener| is_far(listener.node));
                flight.listeners = stay;
                let (silenced, sending): (Vec<_>, Vec<_>) =
                    flight.transmitters.iter().partition(|&&node| is_far(node));
                flight.transmitters = sending;
                other.take_agenda(&mut self, is_far);
                other.tell_losers(at);
                for node in &silenced {
                    other.plan_error(at + self.bit, *node, Told::TransmitError(ErrorKind::BitDominant));
                }
                other.orphan(at, gone.into_iter().map(|listener| listener.node).collect());
                if !silenced.is_empty() {
                    other.error_frame(at + self.bit, 2 * ERROR_FLAG_BITS);
                }
            }
            None => other.take_agenda(&mut self, is_far),
        }
        if flight_is_right { (other, self) } else { (self, other) }
    }

    /// Joins with the piece on the right. A frame on one side alone goes on, unheard by the nodes of the other; when
    /// both sides are busy with frames or error frames, what is in flight is destroyed.
    pub(crate) fn merge(
        mut self,
        mut right: Segment,
        at: Time,
        observed: &mut Observed,
        index: usize,
    ) -> Segment {
        if self.is_busy(at) && right.is_busy(at) {
            self.destroy(at, observed, index);
            right.destroy(at, observed, index + 1);
        }
        if right.free_from > self.free_from || right.flight.is_some() {
            self.origin = right.origin;
            self.bit = right.bit;
        }
        self.members.append(&mut right.members);
        self.members.sort_unstable();
        self.flight = self.flight.or(right.flight);
        for (due, action) in right.agenda {
            self.plan(due, action);
        }
        self.agenda.sort_by_key(|&(due, _)| due);
        self.recessive_since = self.recessive_since.max(right.recessive_since);
        self.busy_until = self.busy_until.max(right.busy_until);
        self.free_from = self.free_from.max(right.free_from);
        self.suspended.append(&mut right.suspended);
        self.decision = [self.decision, right.decision].into_iter().flatten().min();
        self
    }

    fn is_busy(&self, at: Time) -> bool {
        self.flight.is_some() || self.busy_until > at
    }

    /// Foreign bits fall into whatever is here: an error frame follows one bit later.
    fn destroy(&mut self, at: Time, observed: &mut Observed, index: usize) {
        if self.flight.is_none() {
            return;
        }
        let flight = self.end_flight(at, Destruction::Merged, observed, index);
        let seen = at + self.bit;
        for node in flight.transmitters {
            self.plan_error(seen, node, Told::TransmitError(ErrorKind::BitRecessive));
        }
        for listener in flight.listeners {
            self.plan_error(seen, listener.node, Told::ReceiveError(ErrorKind::Stuff));
        }
        self.error_frame(seen, 2 * ERROR_FLAG_BITS);
        observed.counters.busy += self.free_from.since(flight.trace.start);
    }

    /// Moves what is to be told to some nodes here from the agenda of `from`.
    fn take_agenda(&mut self, from: &mut Segment, is_mine: impl Fn(NodeIndex) -> bool) {
        let mine = |&(_, action): &(Time, Action)| matches!(action, Action::Tell(node, _) if is_mine(node));
        let (taken, left) = from.agenda.drain(..).partition(mine);
        from.agenda = left;
        self.agenda = taken;
    }

    /// Losers of an arbitration that ends early get to know at once.
    fn tell_losers(&mut self, at: Time) {
        for (due, action) in &mut self.agenda {
            if matches!(action, Action::Tell(_, Told::Lost)) {
                *due = (*due).min(at);
            }
        }
        self.agenda.sort_by_key(|&(due, _)| due);
    }
}

impl Told {
    fn event(self) -> WireEvent {
        match self {
            Told::Lost => WireEvent::ArbitrationLost,
            Told::TransmitError(kind) => WireEvent::TransmitError(kind),
            Told::ReceiveError(kind) => WireEvent::ReceiveError(kind),
        }
    }
}

fn bits(bit: Time, count: u64) -> Time {
    Time(bit.0 * count)
}

/// First version of bit timing: up to 1 % of difference is bridged by resynchronisation.
fn understands(transmitter: Time, receiver: Time) -> bool {
    transmitter.0.abs_diff(receiver.0) * 100 <= transmitter.0
}
