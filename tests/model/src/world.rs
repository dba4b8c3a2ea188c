//! Nodes on two buses.

mod crew;
mod fault;
mod report;

pub use crew::{Crew, Reporter};
use ecss_can::heartbeat;
use ecss_can::link::access::BusAccess;
use ecss_can::nmt::{NmtMessage, Target};
use ecss_can::types::{Bus, Canonical, CobId, Duration, Frame, Instant, Instants as _, NmtState, NodeId};
pub use fault::{Fault, Kind, Message};
pub use report::Report;

use crate::defect::{self, Defect};
use crate::master::Master;
use crate::profile::{PARALLEL, PARAMETERS, SELECTIVE, TICK};
use crate::slave::Slave;
use crate::station::Station;
use crate::what::What;

/// Largest number of nodes: the master, two slaves, and the second master.
pub const STATIONS: usize = 4;
/// Returns the number of reports of an error: it starts, ends, and starts again. With three faults it does not start
/// again, to limit the states.
const fn reports(faults: u8) -> u8 {
    if faults <= MOST_WITHOUT_ROUNDS { 3 } else { 2 }
}
/// Largest number of faults without rounds. With more faults a report may be lost unnoticed, and only a round finds it.
const MOST_WITHOUT_ROUNDS: u8 = 2;
/// Places of the slaves.
const SLAVES: [usize; 2] = [1, 2];
/// Places of the masters.
pub const MASTERS: [usize; 2] = [0, 3];

/// A spacecraft.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct World {
    /// The master, or the one strapped prime and the other one.
    pub masters: Vec<Master>,
    /// One slave with parallel access, one with selective access.
    pub slaves: [Slave; 2],
    /// A bit for each stub that is cut: four of the nominal bus, four of the redundant one.
    cut: u8,
    /// A bit for each node without power.
    off: u8,
    /// A bit for each node and kind of frame that is to be lost.
    losing: u8,
    /// Faults that may still happen.
    pub left: u8,
    /// Reports that may still be made.
    pub reports: u8,
    /// The reporting slave. The other one is absent.
    reporter: Option<Reporter>,
    /// Earliest repair of a master's stub that was cut last, with reports and without rounds.
    mended_at: Instant,
    /// Whether the master asks for errors, and the slave sends its value, at intervals too.
    has_rounds: bool,
    /// Whether equal frames of the same time merge.
    is_in_step: bool,
    /// Whether applications and budgets act, and controllers of the master go bus-off.
    is_in_use: bool,
    /// Whether no master loses its memory.
    is_memory_kept: bool,
    /// The broken rule.
    defect: Option<Defect>,
}

impl World {
    /// Makes a world with all nodes powered at the same instant. `defect`: a broken rule.
    pub fn new(crew: Crew, reporter: Option<Reporter>, faults: u8, defect: Option<Defect>) -> World {
        let slaves = [
            Slave::new(PARALLEL, BusAccess::Parallel, defect),
            Slave::new(SELECTIVE, BusAccess::Selective, defect),
        ];
        let absent = reporter.map_or(0, |reporter| 1 << reporter.absent());
        let node = |Reporter { place, .. }: Reporter| [PARALLEL, SELECTIVE][place - 1];
        let masters = crew.masters().into_iter().map(|master| match reporter {
            Some(reporter) => master.alone_with(node(reporter), reporter.what, defect),
            None => master,
        });
        let mut world = World {
            masters: masters.collect(),
            slaves: match reporter {
                Some(Reporter { what, .. }) => slaves.map(|slave| slave.reporting(what)),
                None => slaves,
            },
            cut: 0,
            off: absent,
            losing: 0,
            left: faults,
            reports: match reporter.map(|reporter| reporter.what) {
                Some(What::Error) => reports(faults),
                Some(What::Value) => 1,
                None => 0,
            },
            reporter,
            mended_at: Instant::ORIGIN,
            has_rounds: faults > MOST_WITHOUT_ROUNDS,
            is_in_step: matches!(crew, Crew::TwoMastersInStep | Crew::TwoMastersUnassigned),
            is_in_use: crew == Crew::OneMasterInUse,
            is_memory_kept: crew == Crew::OneMasterUnassigned,
            defect,
        };
        let now = Instant::ORIGIN;
        world.places().for_each(|place| world.station(place).start(now));
        world.settle(now, &mut |_| {});
        world.canonical(now, &());
        while !crew.is_assigned() && !world.are_known() {
            let now = world.tick_from(Instant::ORIGIN, &mut |_| {});
            world.canonical(now, &());
        }
        world
    }

    /// Returns whether the active master has identified both slaves.
    fn are_known(&self) -> bool {
        let knows = |master: &Master| {
            [PARALLEL, SELECTIVE].iter().all(|node| master.redundancy.peers().counts(*node))
        };
        self.masters.iter().any(|master| master.is_active() && knows(master))
    }

    fn station(&mut self, place: usize) -> &mut dyn Station {
        match MASTERS.iter().position(|master| *master == place) {
            Some(master) => &mut self.masters[master],
            None => &mut self.slaves[place - 1],
        }
    }

    fn seen(&self, place: usize) -> &dyn Station {
        match MASTERS.iter().position(|master| *master == place) {
            Some(master) => &self.masters[master],
            None => &self.slaves[place - 1],
        }
    }

    /// Returns the places of existing nodes.
    fn places(&self) -> impl Iterator<Item = usize> + use<> {
        let absent = self.reporter.map(Reporter::absent);
        (0..self.masters.len() + self.slaves.len()).filter(move |place| absent != Some(*place))
    }

    /// Returns whether this place has a node.
    pub fn is_there(&self, place: usize) -> bool {
        self.places().any(|other| other == place)
    }

    /// Returns whether a node is connected to the wire of a bus, regardless of its controller.
    pub fn is_connected(&self, bus: Bus, place: usize) -> bool {
        self.cut & stub(bus, place) == 0
    }

    /// Returns whether a node has power.
    pub fn is_powered(&self, place: usize) -> bool {
        self.off & 1 << place == 0
    }

    /// Returns whether a frame is still to be lost.
    pub fn is_losing(&self) -> bool {
        self.losing != 0
    }

    fn hears(&self, bus: Bus, place: usize) -> bool {
        self.is_powered(place) && self.is_connected(bus, place) && self.seen(place).is_joined(bus)
    }

    /// Returns whether a node sends and acknowledges.
    fn takes_part(&self, bus: Bus, place: usize) -> bool {
        self.hears(bus, place) && !self.seen(place).is_silent()
    }

    /// Applies a fault and its immediate consequences. `on_loss`: called when a frame is lost.
    pub fn suffer_at(&mut self, fault: Fault, now: Instant, on_loss: &mut dyn FnMut(&World)) {
        self.masters.iter_mut().for_each(Master::forget_news);
        match fault {
            Fault::Cut(bus, place) => {
                self.cut |= stub(bus, place);
                if self.reporter.is_some() && !self.has_rounds && MASTERS.contains(&place) {
                    self.mended_at = now + PARAMETERS.consumer;
                }
            }
            Fault::Restore(bus, place) => {
                self.cut &= !stub(bus, place);
                if place == MASTERS[0] && self.is_in_use {
                    self.report_bus_off(bus, false, now);
                }
            }
            Fault::BusOff(bus) => {
                self.cut |= stub(bus, MASTERS[0]);
                self.report_bus_off(bus, true, now);
            }
            Fault::Request(bus) => self.masters[0].request(bus, now),
            Fault::Hold(place) => self.masters[0].hold([PARALLEL, SELECTIVE][place - 1], now),
            Fault::Choose(bus, place) => self.slaves[place - 1].choose(bus, now),
            Fault::Silence(place) => self.slaves[place - 1].silence(now),
            Fault::Save(place) => self.slaves[place - 1].save(now),
            Fault::Reset(place) => self.station(place).start(now),
            Fault::Off(place) => {
                self.off |= 1 << place;
                self.losing &= !(loss(place, Kind::Heartbeat) | loss(place, Kind::Command));
                self.station(place).power_off();
            }
            Fault::On(place) => {
                self.off &= !(1 << place);
                self.station(place).start(now);
            }
            Fault::Lose(place, kind) => self.losing |= loss(place, kind),
            Fault::Foreign(bus, message) => {
                let frame = match message {
                    Message::Heartbeat => heartbeat::encode(NodeId::MASTER, NmtState::Operational),
                    Message::OfSlave | Message::OfSlaveLater => {
                        heartbeat::encode(PARALLEL, NmtState::Operational)
                    }
                    Message::Command(command) => NmtMessage { command, target: Target::All }.encode(),
                };
                let is_later = message == Message::OfSlaveLater;
                let at = if is_later { now + Duration::from_micros(TICK.as_micros() / 2) } else { now };
                self.deliver(bus, &frame, &[], at, on_loss);
            }
        }
        self.settle(now, on_loss);
        self.left -= 1;
    }

    fn report_bus_off(&mut self, bus: Bus, is_failed: bool, now: Instant) {
        let is_powered = self.is_powered(MASTERS[0]);
        self.masters[0].on_bus_off(bus, is_failed, is_powered, now);
    }

    /// Returns the ticks until the next due action.
    pub fn ticks_from(&self, now: Instant) -> u32 {
        let powered = self.places().filter(|place| self.is_powered(*place));
        let due = powered.filter_map(|place| self.seen(place).deadline()).min();
        let wait = due.map_or(TICK, |due| due.since(now)).max(TICK);
        wait.as_micros().div_ceil(TICK.as_micros()) as u32
    }

    /// Advances time to the next tick with a due action. Returns the new time. `on_loss`: called when a frame is lost.
    pub fn tick_from(&mut self, now: Instant, on_loss: &mut dyn FnMut(&World)) -> Instant {
        let now = now + TICK.times(self.ticks_from(now));
        self.masters.iter_mut().for_each(Master::forget_news);
        for place in self.places() {
            if !self.is_powered(place) {
                continue;
            }
            while let Some(waiting) = self.station(place).outgoing().take_expired(now) {
                self.station(place).on_expired(waiting.bus, &waiting.frame, now);
            }
            if MASTERS.contains(&place)
                && let Some((bus, frame)) = defect::imagined(self.defect, self.seen(place))
            {
                self.station(place).on_received(bus, &frame, now);
            }
            self.station(place).poll(now);
        }
        self.settle(now, on_loss);
        now
    }

    /// Sends all frames that can be sent, the lowest COB-ID first.
    fn settle(&mut self, now: Instant, on_loss: &mut dyn FnMut(&World)) {
        loop {
            let mut next: Option<(CobId, Bus, usize, Frame)> = None;
            for bus in Bus::ALL {
                for place in self.places() {
                    let Some(frame) = self.seen(place).waiting().next(bus) else { continue };
                    let senders = self.senders(bus, place, &frame);
                    let has_witness = self.reporter.is_some_and(|reporter| reporter.has_witness);
                    let is_other = |other: usize| !senders.contains(&other) && self.takes_part(bus, other);
                    let is_heard =
                        self.takes_part(bus, place) && (has_witness || self.places().any(is_other));
                    self.station(place).on_unacknowledged(bus, !is_heard, now);
                    if is_heard && next.is_none_or(|(id, ..)| frame.id() < id) {
                        next = Some((frame.id(), bus, place, frame));
                    }
                }
            }
            let Some((_, bus, place, frame)) = next else { return self.overhear(now, on_loss) };
            let senders = self.senders(bus, place, &frame);
            senders.iter().for_each(|sender| self.station(*sender).on_sent(bus, &frame, now));
            self.deliver(bus, &frame, &senders, now, on_loss);
        }
    }

    /// Returns the places of nodes that send this frame together, starting with `place`.
    fn senders(&self, bus: Bus, place: usize, frame: &Frame) -> Vec<usize> {
        let is_other = |other: &usize| {
            self.is_in_step
                && *other != place
                && self.takes_part(bus, *other)
                && self.seen(*other).waiting().next(bus) == Some(*frame)
        };
        std::iter::once(place).chain(self.places().filter(is_other)).collect()
    }

    /// Delivers unacknowledged frames, which are repeated, to nodes that only listen.
    fn overhear(&mut self, now: Instant, on_loss: &mut dyn FnMut(&World)) {
        for bus in Bus::ALL {
            for place in self.places().filter(|place| self.takes_part(bus, *place)).collect::<Vec<_>>() {
                if let Some(frame) = self.seen(place).waiting().next(bus) {
                    let senders = self.senders(bus, place, &frame);
                    self.deliver(bus, &frame, &senders, now, on_loss);
                }
            }
        }
    }

    fn deliver(
        &mut self,
        bus: Bus,
        frame: &Frame,
        senders: &[usize],
        now: Instant,
        on_loss: &mut dyn FnMut(&World),
    ) {
        let kind = match frame.id() {
            CobId::NMT => Some(Kind::Command),
            id if id.function() == CobId::heartbeat(NodeId::MASTER).function() => Some(Kind::Heartbeat),
            _ => None,
        };
        for place in self.places() {
            if senders.contains(&place) || !self.hears(bus, place) {
                continue;
            }
            let lost = kind.map_or(0, |kind| loss(place, kind));
            if self.losing & lost != 0 {
                self.losing &= !lost;
                self.station(place).on_overrun(bus, now);
                on_loss(self);
                continue;
            }
            let is_master = MASTERS.contains(&place);
            if let Some((bus, frame)) = defect::received(self.defect, self.seen(place), is_master, bus, frame)
            {
                self.station(place).on_received(bus, &frame, now);
            }
        }
    }
}

impl Canonical for World {
    type Context = ();

    fn canonical(&mut self, now: Instant, (): &()) {
        self.masters.iter_mut().for_each(|master| master.canonical(now, &()));
        self.slaves.canonical(now, &());
        self.mended_at.due(now);
    }
}

fn stub(bus: Bus, place: usize) -> u8 {
    1 << (usize::from(bus.bdefault()) * STATIONS + place)
}

fn loss(place: usize, kind: Kind) -> u8 {
    1 << (place * 2 + usize::from(kind == Kind::Command))
}
