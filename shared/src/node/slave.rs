//! A slave node.

mod bus_events;
mod objects;

use super::buses::Buses;
use super::device::{Device, Dictionary, SdoStep};
use super::{BusCause, Counters, NodeObjects, SlaveEvent, Status};
use crate::emcy::ErrorCode;
use crate::heartbeat::{self, MONITORED};
use crate::link::port::Filter;
use crate::link::{Bus, CobId, Frame, PerBus};
use crate::nmt::{ErrorBehaviour, NmtMessage, NmtSlave, NmtStartup, NmtState, NodeId, Reaction};
use crate::od::communication::{Communication, Mapping, PdoMapping};
use crate::od::{Address, Objects};
use crate::profile::Profile;
use crate::redundancy::{MasterMessage, Parameters, Selection, Selector};
use crate::runner::{BusCommand, Filters, LinkEvent, MAX_FILTERS, Node, Outbox};
use crate::store::{Group, ParameterStore};
use crate::time::{Duration, Instant, LocalClock, Scet, Stamp, earliest};

type Out = Outbox<SlaveEvent>;

/// Until there may be room for more filters.
const FILTER_PAUSE: Duration = Duration::from_millis(1);

/// Behind NMT. SDO and heartbeat of the master follow it.
const SYNC_FILTER: usize = 1;
/// The first of those that 1016h monitors.
const FILTERS_OF_PEERS: usize = 4;
/// The first of the RPDOs.
const FILTERS_OF_RPDOS: usize = FILTERS_OF_PEERS + MONITORED;

/// NMT slave, redundancy slave, SYNC and time consumer, CANopen device.
///
/// `A` are the objects of its application, `R` and `T` its receive and transmit PDOs, `M` how these are mapped.
#[derive(Debug)]
pub struct Slave<A: Objects + Default, const R: usize = 8, const T: usize = 8, M: Mapping = PdoMapping> {
    id: NodeId,
    nmt: NmtSlave,
    selector: Selector,
    heartbeat: heartbeat::Producer,
    clock: LocalClock,
    buses: Buses,
    device: Device<A, R, T, M>,
    power_on: fn(NodeId) -> Communication<R, T, M>,
    initial: Parameters,
    startup: NmtStartup,
    lifetimes: Lifetimes,
    /// A bit for each COB-ID that is taken, [`mark`]: frames without are for others.
    marks: u64,
    /// Which receive PDOs carry the spacecraft time.
    brings_time: [bool; R],
    /// Whether a transmit PDO carries a value of the moment: objects 2011h, 2020h, 2021h.
    tells_moment: bool,
    /// A bit for each filter that its buses have not been told yet.
    changed_filters: u32,
    /// Nothing is due before. May be early, never late.
    next: Instant,
}

/// How long frames may wait for their bus.
#[derive(Clone, Copy, Debug)]
struct Lifetimes {
    heartbeat: Duration,
    synchronous: Duration,
    event: Duration,
    sdo: Duration,
}

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> Slave<A, R, T, M> {
    /// A slave before power-on. `id` is one of 2..=127; `communication` makes the communication profile, to which
    /// power-on and reset communication return.
    pub fn new(
        id: NodeId,
        profile: &Profile,
        application: A,
        communication: fn(NodeId) -> Communication<R, T, M>,
    ) -> Self {
        let redundancy = profile.redundancy();
        let mut objects = NodeObjects::new(id, &redundancy, application, communication(id));
        objects.communication.nmt_startup = NmtStartup::of_slave(profile.autostart).raw();
        Slave {
            id,
            nmt: NmtSlave::new(profile.autostart),
            selector: Selector::new(redundancy),
            heartbeat: heartbeat::Producer::new(id, redundancy.producer),
            clock: LocalClock::default(),
            buses: Buses::new(profile.access(id), profile.bus_off),
            device: Device::new(id, objects, profile.sdo_timeout),
            power_on: communication,
            initial: redundancy,
            startup: NmtStartup::of_slave(profile.autostart),
            lifetimes: Lifetimes {
                heartbeat: profile.heartbeat,
                synchronous: profile.sync.min(profile.heartbeat),
                event: profile.telemetry,
                sdo: profile.sdo_timeout,
            },
            marks: u64::MAX,
            brings_time: [false; R],
            tells_moment: false,
            changed_filters: 0,
            next: Instant::ZERO,
        }
    }

    /// With a parameter store: objects 1010h and 1011h work, and power-on begins with what is stored.
    #[must_use]
    pub fn with_store(mut self, store: &'static mut (dyn ParameterStore + Send)) -> Self {
        self.device.dictionary.stored.0 = Some(store);
        self.device.load(Group::All);
        self.selector = Selector::new(self.written_redundancy());
        self
    }

    /// What it receives: exact COB-IDs only. A filter for each entry of 1016h and for each RPDO, valid or not, as long as
    /// there are filters.
    pub fn filters(&self) -> Filters {
        let mut filters: Filters =
            (0..FILTERS_OF_RPDOS + R).take(MAX_FILTERS - 1).map(|n| self.filter(n)).collect();
        if FILTERS_OF_RPDOS + R >= MAX_FILTERS {
            // More than the controllers can tell apart.
            let _ = filters.push(Filter { id: CobId::NMT, mask: 0 });
        }
        filters
    }

    /// What a filter admits, by the dictionary; NMT again where there is nothing.
    fn filter(&self, number: usize) -> Filter {
        let id = match number {
            SYNC_FILTER => Some(self.device.written_sync_id()),
            2 => Some(self.device.sdo_id()),
            3 => Some(CobId::heartbeat(NodeId::MASTER)),
            FILTERS_OF_PEERS..FILTERS_OF_RPDOS => self.device.monitored(number - FILTERS_OF_PEERS),
            _ => {
                number.checked_sub(FILTERS_OF_RPDOS).and_then(|pdo| self.device.rpdo_ids().nth(pdo).flatten())
            }
        };
        Filter::exact(id.unwrap_or(CobId::NMT))
    }

    /// A filter changed: both buses are told when the node runs next.
    fn admit(&mut self, number: usize) {
        if number < MAX_FILTERS - 1 {
            self.changed_filters |= 1 << number;
            self.next = Instant::ZERO;
        }
    }

    /// As many as there is room for beside the frames; the others a little later.
    fn set_filters(&mut self, out: &mut Out) {
        while self.changed_filters != 0 && out.has_room() {
            let number = self.changed_filters.trailing_zeros();
            self.changed_filters &= !(1 << number);
            let command = BusCommand::Filter { number: number as u8, filter: self.filter(number as usize) };
            Bus::ALL.into_iter().for_each(|bus| out.command(bus, command));
        }
    }

    /// Boot-up on the bus selected, then Pre-operational (ECSS 8.3.2).
    fn boot(&mut self, now: Instant, out: &mut Out) {
        self.restore_communication(now);
        let frame = heartbeat::encode(self.id, NmtState::Initialising);
        out.send_for(self.selector.selected(), frame, now, self.lifetimes.heartbeat);
        let state = self.nmt.boot();
        self.entered(state, now, out);
        self.heartbeat.restart(now);
        self.selector.start(now);
        self.set_marks();
        self.next = now;
    }

    /// A frame that may be for this node. The frequent ones first; each handler ends with what has become due.
    #[inline(never)] // what is for others need not pay for it
    fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let (id, state) = (frame.id(), self.nmt.state());
        // Only the active bus is obeyed.
        if bus != self.selector.selected() {
            self.on_network(bus, frame, stamp, now, out);
        } else if id == self.device.sync_id() && state.allows_sync() {
            self.on_sync(frame, stamp, now, out);
        } else if id == self.device.sdo_id() && state.allows_sdo() {
            self.on_sdo(frame, now, out);
        } else if id < CobId::heartbeat(NodeId::MASTER) && state.allows_pdo() {
            self.on_pdo(frame, stamp, now, out);
        } else {
            self.on_network(bus, frame, stamp, now, out);
        }
    }

    /// NMT and heartbeats; the master's are heard on both buses.
    #[inline(never)]
    fn on_network(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let (id, active) = (frame.id(), self.selector.selected());
        if self.nmt.state() == NmtState::Initialising {
            // Told again with every frame: were it lost in a full channel, the node would stay silent for ever.
            out.event(SlaveEvent::ResetNode);
            self.buses.ignored(bus);
        } else if !self.buses.is_joined(bus, active) {
            self.buses.ignored(bus);
        } else if id == CobId::NMT {
            self.on_nmt(bus, frame, stamp, now, out);
        } else if id == CobId::heartbeat(NodeId::MASTER) {
            self.on_master_heartbeat(bus, frame, stamp, now, out);
        } else if bus == active && id.function() == CobId::heartbeat(NodeId::MASTER).function() {
            self.on_peer_heartbeat(bus, frame, stamp, out);
        } else {
            self.buses.ignored(bus);
        }
        self.run(now, now, out);
    }

    fn on_nmt(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let Some(message) = NmtMessage::decode(frame) else { return self.buses.malformed(bus) };
        // ECSS 8.3.3g before the command itself: it decides where the answer goes.
        self.on_master(bus, MasterMessage::Command, stamp.at, now, out);
        if !message.target.includes(self.id) {
            return;
        }
        match self.nmt.on_command(message.command) {
            Reaction::Unchanged => {}
            Reaction::Entered(state) => {
                self.entered(state, now, out);
                // The master learns of it now, not a period later.
                self.heartbeat.announce(now);
                self.next = now;
            }
            Reaction::ResetNode => {
                self.heartbeat.stop();
                self.marks = u64::MAX;
                self.next = Instant::NEVER;
                out.event(SlaveEvent::ResetNode);
            }
            Reaction::ResetCommunication => self.boot(now, out),
        }
    }

    fn entered(&mut self, state: NmtState, now: Instant, out: &mut Out) {
        self.device.entered(state, now);
        self.next = now;
        out.event(SlaveEvent::State(state));
    }

    fn on_master_heartbeat(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        if heartbeat::decode(frame).is_none() {
            return self.buses.malformed(bus);
        }
        self.on_master(bus, MasterMessage::Heartbeat, stamp.at, now, out);
        out.event(SlaveEvent::Heartbeat { bus });
    }

    fn on_master(&mut self, bus: Bus, message: MasterMessage, at: Instant, now: Instant, out: &mut Out) {
        if let Some(selection) = self.selector.on_master(bus, message, at) {
            self.apply(selection, now, out);
        }
        self.wake(self.selector.deadline());
    }

    /// A heartbeat of another slave that 1016h names.
    fn on_peer_heartbeat(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, out: &mut Out) {
        let Some((state, node)) = heartbeat::decode(frame).zip(frame.id().node()) else {
            return self.buses.malformed(bus);
        };
        let Some(heard) = self.device.monitor.on_heartbeat(node, state, stamp.at) else {
            return self.buses.ignored(bus);
        };
        if heard.resolved {
            self.device.clear(ErrorCode::HEARTBEAT, node.get());
            self.next = stamp.at;
        }
        if heard.before != Some(state) {
            out.event(SlaveEvent::PeerState { node, state });
        }
        self.wake(self.device.monitor.deadline());
    }

    fn apply(&mut self, selection: Selection, now: Instant, out: &mut Out) {
        self.next = now;
        match selection {
            Selection::Missed { bus } => {
                out.event(SlaveEvent::MasterMissed { bus });
                // ECSS 8.3.3e, note 2.
                self.device.raise(ErrorCode::HEARTBEAT, [NodeId::MASTER.get(), 0, 0, 0, 0]);
                self.enter_pre_operational(now, out);
            }
            Selection::Toggled { to } => {
                self.enter_pre_operational(now, out);
                self.move_to(to, BusCause::Toggled, now, out);
            }
            Selection::GaveUp { bus } => out.event(SlaveEvent::GaveUp { bus }),
            Selection::Found { bus, moved } => {
                self.device.clear(ErrorCode::HEARTBEAT, NodeId::MASTER.get());
                if moved {
                    self.move_to(bus, BusCause::Found, now, out);
                } else {
                    out.event(SlaveEvent::ActiveBus { bus, cause: BusCause::Found });
                }
            }
            Selection::Followed { to } => self.move_to(to, BusCause::Followed, now, out),
        }
        self.show_redundancy(now);
    }

    /// Object 2000h; what the node changes itself of it is an event for the TPDOs that carry it.
    fn show_redundancy(&mut self, now: Instant) {
        let Dictionary { objects, .. } = &mut self.device.dictionary;
        let before = objects.spacecraft.redundancy;
        objects.set_redundancy(self.selector.parameters());
        let after = objects.spacecraft.redundancy;
        for (sub, has_changed) in
            [(1, before.bdefault != after.bdefault), (4, before.ctoggle != after.ctoggle)]
        {
            if has_changed {
                self.device.dictionary.on_changed(Address::new(0x2000, sub), now);
            }
        }
    }

    fn enter_pre_operational(&mut self, now: Instant, out: &mut Out) {
        if let Reaction::Entered(state) = self.nmt.on_master_missed() {
            self.entered(state, now, out);
        }
    }

    /// The heartbeat goes on on the new bus at once (ECSS 8.3.3d, h).
    fn move_to(&mut self, bus: Bus, cause: BusCause, now: Instant, out: &mut Out) {
        self.buses.change(bus.other(), bus, out);
        // What was on its way is lost, and the client is told so where it is now.
        self.serve(SdoStep::BusChanged, bus, now, out);
        self.heartbeat.announce(now);
        self.next = now;
        out.event(SlaveEvent::ActiveBus { bus, cause });
    }

    /// Something is due then, at the latest.
    fn wake(&mut self, deadline: Option<Instant>) {
        if let Some(deadline) = deadline {
            self.next = self.next.min(deadline);
        }
    }

    /// What was due at `until`, which may be before `now`: a frame is judged as of its end.
    #[inline(always)]
    fn run(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if until >= self.next {
            self.run_due(until, now, out);
        }
    }

    #[inline(never)] // most frames find nothing due
    fn run_due(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if self.nmt.state() == NmtState::Initialising {
            return;
        }
        if self.changed_filters != 0 {
            self.set_filters(out);
        }
        while let Some(selection) = self.selector.poll(until) {
            self.apply(selection, now, out);
        }
        while let Some(missed) = self.device.monitor.poll(until) {
            self.on_peer_missed(missed.node, now, out);
        }
        if let Some(frame) = self.heartbeat.poll(until, self.nmt.state()) {
            out.send_for(self.selector.selected(), frame, now, self.lifetimes.heartbeat);
        }
        while let Some(bus) = self.buses.poll(until, out) {
            out.event(SlaveEvent::BusFailed { bus });
        }
        self.run_device(until, now, out);
        self.next = self.due().unwrap_or(Instant::NEVER);
        if self.changed_filters != 0 {
            self.next = self.next.min(now + FILTER_PAUSE);
        }
    }

    fn on_peer_missed(&mut self, node: NodeId, now: Instant, out: &mut Out) {
        self.device.raise(ErrorCode::HEARTBEAT, [node.get(), 0, 0, 0, 0]);
        out.event(SlaveEvent::PeerMissed { node });
        let [behaviour] = self.device.dictionary.objects.communication.error_behaviour;
        let behaviour = ErrorBehaviour::from_byte(behaviour).unwrap_or_default();
        if let Reaction::Entered(state) = self.nmt.on_communication_error(behaviour) {
            self.entered(state, now, out);
        }
    }

    fn due(&self) -> Option<Instant> {
        let own = [
            self.selector.deadline(),
            self.heartbeat.deadline(),
            self.buses.deadline(),
            self.device.monitor.deadline(),
            self.device.deadline(self.nmt.state()),
        ];
        earliest(&own)
    }

    /// The node as it is at `now`.
    pub fn status(&self, now: Instant) -> Status {
        Status {
            uptime: now.since(Instant::ZERO),
            scet: self.clock.at(now),
            state: self.nmt.state(),
            active: self.selector.selected(),
            redundancy: *self.selector.parameters(),
            counters: self.buses.counters,
            health: self.buses.health,
        }
    }

    /// Zero the counters of both buses.
    pub fn reset_counters(&mut self) {
        self.buses.counters = PerBus::<Counters>::default();
    }

    /// Local spacecraft time.
    pub fn scet(&self, now: Instant) -> Scet {
        self.clock.at(now)
    }
}

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> Node for Slave<A, R, T, M> {
    type Event = SlaveEvent;
    type Request = core::convert::Infallible;

    fn start(&mut self, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        self.buses.join(bus, out);
        out.event(SlaveEvent::ActiveBus { bus, cause: BusCause::PowerOn });
        self.boot(now, out);
        self.run(now, now, out);
    }

    #[inline]
    fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        let LinkEvent::Received { frame, stamp } = event else {
            self.on_bus_event(bus, event, now, out);
            return self.run(now, now, out);
        };
        self.buses.received(bus);
        if now >= self.next {
            self.run(stamp.at.min(now), now, out);
        } else if self.marks & mark(frame.id()) == 0 {
            return self.buses.ignored(bus);
        }
        self.on_frame(bus, frame, stamp, now, out);
    }

    fn on_request(&mut self, request: Self::Request, _now: Instant, _out: &mut Out) {
        match request {}
    }

    fn poll(&mut self, now: Instant, out: &mut Out) {
        self.run(now, now, out);
    }

    fn deadline(&self) -> Option<Instant> {
        let silent = self.nmt.state() == NmtState::Initialising || self.next == Instant::NEVER;
        if silent { None } else { Some(self.next) }
    }
}

/// A bit for a COB-ID; some share one.
fn mark(id: CobId) -> u64 {
    1 << ((id.raw() ^ id.raw() >> 5) & 0x3F)
}
