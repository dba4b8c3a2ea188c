//! One bus: controllers along a cable, in virtual time.
//!
//! The caller runs what stands behind the controllers for a quantum (at most 20 µs, never beyond
//! [`Wire::next_event`]) and then calls [`Wire::advance`]. Requests carry their own times, so a frame may start inside
//! the quantum that has just passed; its [`Started`](crate::controller::WireEvent::Started) is told late by up to a
//! quantum and a bit. Everything later is told exactly at its time, because the caller stops there; only an arbitration
//! lost, or a collision, within the quantum of the start is told late, with its true time. What happens does not depend
//! on the length of the quantum, except that who joins or leaves the bus does so at the advance that first sees it.
//!
//! # What is modelled
//!
//! * Arbitration: the earliest request makes the SOF, and everybody whose own SOF would begin within that bit
//!   contends. Frames with equal arbitration fields but different rest destroy each other (bit errors, an error frame);
//!   frames equal in every bit are one frame, and all its transmitters succeed.
//! * Intermission of 3 bits; 8 more for an error-passive transmitter after its own frame.
//! * ACK by any other controller on the same piece of cable whose bit time matches within 1 % and which was on the bus
//!   since the start of the frame. Others understand nothing: they see a form error at the ACK slot, but their error
//!   flags do not disturb the frame.
//! * A transmitter that leaves the bus before the ACK slot has passed leaves a stuff error to the others.
//! * Cuts: every piece is a bus of its own. A healed cut leaves a frame on one side alone in peace; frames on both
//!   sides are destroyed.
//! * Propagation: 5 ns/m by default, for receivers and for those who join an arbitration. Cables so long that a bit
//!   does not fit are not.
//!
//! Single corrupted bits, error flags of receivers, overload frames and dominant-stuck lines are not modelled.

use crate::controller::{Controller, NodeIndex};
use crate::fault::Fault;
use crate::record::{Counters, Record};
use crate::segment::{Observed, Segment, Surroundings};
use crate::time::Time;

/// The controllers of one wire, by index of attachment.
pub trait Controllers {
    /// The controller that was attached as `node`.
    fn controller(&mut self, node: NodeIndex) -> &mut dyn Controller;
}

/// Properties of the cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireConfig {
    /// Propagation delay, nanoseconds per metre.
    pub ns_per_m: u32,
}

impl Default for WireConfig {
    /// Twisted pair: 5 ns/m.
    fn default() -> Self {
        WireConfig { ns_per_m: 5 }
    }
}

/// One bus.
#[derive(Debug)]
pub struct Wire {
    config: WireConfig,
    now: Time,
    positions: Vec<f64>,
    /// Propagation delay of each node from the left end.
    offsets: Vec<Time>,
    /// Ascending, without doubles; `cuts[n]` lies between `segments[n]` and `segments[n + 1]`.
    cuts: Vec<f64>,
    segments: Vec<Segment>,
    /// In the order of time.
    faults: Vec<(Time, Fault)>,
    observed: Observed,
}

impl Wire {
    /// A cable without nodes, at time zero.
    pub fn new(config: WireConfig) -> Self {
        Wire {
            config,
            now: Time::ZERO,
            positions: Vec::new(),
            offsets: Vec::new(),
            cuts: Vec::new(),
            segments: vec![Segment::default()],
            faults: Vec::new(),
            observed: Observed::default(),
        }
    }

    /// Attaches a controller `position_m` metres from the left end; in any order of positions.
    ///
    /// # Panics
    /// When the position is negative or not finite.
    pub fn attach(&mut self, position_m: f64) -> NodeIndex {
        assert!(position_m.is_finite() && position_m >= 0.0, "no place on a cable: {position_m} m");
        let node = self.positions.len();
        self.positions.push(position_m);
        self.offsets.push(Time::from_ns((position_m * f64::from(self.config.ns_per_m)).round() as u64));
        let segment = self.segment_of(node);
        self.segments[segment].members.push(node);
        node
    }

    /// Propagation delay between two nodes, whether or not the cable between them is whole.
    pub fn delay(&self, from: NodeIndex, to: NodeIndex) -> Time {
        Time(self.offsets[from].0.abs_diff(self.offsets[to].0))
    }

    /// Until when the wire has been advanced.
    pub fn now(&self) -> Time {
        self.now
    }

    /// The next instant at which the wire itself does something, as known at the last [`Wire::advance`]: an event for a
    /// controller, the decision of an arbitration, the end of an intermission, a scheduled fault. `None`: nothing,
    /// unless a controller asks.
    pub fn next_event(&self) -> Option<Time> {
        let fault = self.faults.first().map(|&(at, _)| at.max(self.now));
        self.segments.iter().filter_map(|segment| segment.next_event(self.now)).chain(fault).min()
    }

    /// Since when the line at `node` is recessive outside of a frame: the end of the last dominant bit, so that the
    /// recessive end of a frame and the intermission count. `None` while it is busy.
    pub fn idle_since(&self, node: NodeIndex) -> Option<Time> {
        self.segments[self.segment_of(node)].idle_since(self.now)
    }

    /// Advances to `until`, telling the controllers what happened on the way.
    ///
    /// # Panics
    /// When `until` lies before [`Wire::now`].
    pub fn advance(&mut self, until: Time, controllers: &mut dyn Controllers) {
        assert!(until >= self.now, "a wire does not run backwards");
        for index in 0..self.segments.len() {
            let (segment, mut around) = self.step_into(index, controllers);
            segment.drop_absent(until, &mut around);
        }
        loop {
            let mut next: Option<(Time, usize)> = None;
            for index in 0..self.segments.len() {
                let (segment, mut around) = self.step_into(index, controllers);
                if let Some(at) = segment.due(&mut around)
                    && next.is_none_or(|(earliest, _)| at < earliest)
                {
                    next = Some((at, index));
                }
            }
            let fault = self.faults.first().map(|&(at, _)| at.max(self.now));
            match (next, fault) {
                // What ends at the instant of a fault has ended before it.
                (Some((at, index)), _) if at <= until && fault.is_none_or(|fault| at <= fault) => {
                    let (segment, mut around) = self.step_into(index, controllers);
                    segment.step(at, &mut around);
                }
                (_, Some(at)) if at <= until => {
                    let (_, fault) = self.faults.remove(0);
                    self.apply(at, fault);
                }
                _ => break,
            }
        }
        self.now = until;
    }

    /// Breaks the cable now, [`Fault::Cut`].
    pub fn cut(&mut self, position_m: f64) {
        self.apply(self.now, Fault::Cut { position_m });
    }

    /// Heals one break now, [`Fault::Restore`].
    pub fn restore(&mut self, position_m: f64) {
        self.apply(self.now, Fault::Restore { position_m });
    }

    /// Heals every break now, [`Fault::RestoreAll`].
    pub fn restore_all(&mut self) {
        self.apply(self.now, Fault::RestoreAll);
    }

    /// Lets a fault happen at `at`, or with the next [`Wire::advance`] when that has passed.
    pub fn schedule(&mut self, at: Time, fault: Fault) {
        let index = self.faults.partition_point(|&(due, _)| due <= at);
        self.faults.insert(index, (at, fault));
    }

    /// What happened since the last call, in the order of time. Without calls the records pile up.
    pub fn take_records(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.observed.records)
    }

    /// Totals since the start.
    pub fn counters(&self) -> Counters {
        self.observed.counters
    }

    fn segment_of(&self, node: NodeIndex) -> usize {
        self.cuts.partition_point(|&cut| cut <= self.positions[node])
    }

    fn step_into<'a>(
        &'a mut self,
        index: usize,
        controllers: &'a mut dyn Controllers,
    ) -> (&'a mut Segment, Surroundings<'a>) {
        let around =
            Surroundings { controllers, offsets: &self.offsets, observed: &mut self.observed, index };
        (&mut self.segments[index], around)
    }

    fn apply(&mut self, at: Time, fault: Fault) {
        self.observed.records.push(Record::Fault { at, fault });
        match fault {
            Fault::Cut { position_m } => {
                let index = self.cuts.partition_point(|&cut| cut < position_m);
                if self.cuts.get(index).is_some_and(|&cut| cut == position_m) {
                    return;
                }
                self.cuts.insert(index, position_m);
                let positions = &self.positions;
                let whole = std::mem::take(&mut self.segments[index]);
                let (left, right) = whole.split(at, |node| positions[node] >= position_m);
                self.segments[index] = left;
                self.segments.insert(index + 1, right);
            }
            Fault::Restore { position_m } => {
                if let Some(index) = self.cuts.iter().position(|&cut| cut == position_m) {
                    self.heal(at, index);
                }
            }
            Fault::RestoreAll => {
                while !self.cuts.is_empty() {
                    self.heal(at, 0);
                }
            }
        }
    }

    fn heal(&mut self, at: Time, index: usize) {
        self.cuts.remove(index);
        let right = self.segments.remove(index + 1);
        let left = std::mem::take(&mut self.segments[index]);
        self.segments[index] = left.merge(right, at, &mut self.observed, index);
    }
}
