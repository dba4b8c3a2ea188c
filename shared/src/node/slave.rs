//! A slave node.

mod bus_events;
mod identity;
mod marks;
mod network;
mod objects;
mod retained;

use super::services::Services;
use super::{BusCause, Counters, Device, NodeObjects, ParallelAccess, SlaveEvent, Status};
use crate::heartbeat;
use crate::link::Stamp;
use crate::link::port::Filter;
use crate::nmt::{Identity, NmtSlave, NmtStartup, ResetGuard};
use crate::node::{BusCommand, Filters, LinkEvent, MAX_FILTERS, Node, Outbox};
use crate::pdo::PdoSlots;
use crate::profile::Profile;
use crate::redundancy::{Access, Parameters, Selector};
use crate::store::ParameterStore;
use crate::sync::is_sync_length;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus, Scet, earliest};
use marks::Marks;

type Out = Outbox<SlaveEvent>;

/// Until there may be room for more filters.
const FILTER_PAUSE: Duration = Duration::from_millis(1);

/// Behind NMT. SDO and heartbeat of the master follow it.
const SYNC_FILTER: usize = 1;
/// The first of those that 1016h monitors.
const FILTERS_OF_PEERS: usize = 4;

/// NMT slave, redundancy slave, SYNC and time consumer, CANopen device.
#[derive(Debug)]
pub struct Slave<D: Device> {
    id: NodeId,
    nmt: NmtSlave,
    guard: ResetGuard,
    retained: retained::Memory,
    selector: Selector,
    heartbeat: heartbeat::Producer,
    identity: Identity,
    /// Module control and heartbeats received; wraps.
    control_frames: PerBus<u32>,
    services: Services<D>,
    initial: Parameters,
    startup: NmtStartup,
    /// COB-IDs of [`Profile::stamped`].
    stamped: &'static [CobId],
    /// COB-IDs that are taken; frames without a mark are for others.
    marks: Marks,
    /// A bit for each filter that its buses have not been told yet.
    changed_filters: u32,
    /// The bus that the application chose.
    wanted: Option<Bus>,
    /// An EMCY is on its way that goes before a change of the bus. Until then, at most.
    warning: Option<Instant>,
}

impl<D: Device> Slave<D> {
    /// A slave before power-on. `id` is one of 2..=127.
    #[inline(never)] // places on a small stack are reached by short instructions
    pub fn new(id: NodeId, profile: &Profile, application: D) -> Self {
        let redundancy = profile.redundancy();
        let mut objects = NodeObjects::new(id, &redundancy, application);
        objects.communication.nmt.startup = NmtStartup::of_slave(profile.autostart).raw();
        Slave {
            id,
            nmt: NmtSlave::new(profile.autostart),
            guard: ResetGuard::default(),
            retained: retained::Memory::default(),
            selector: Selector::new(redundancy),
            heartbeat: heartbeat::Producer::new(id, redundancy.producer),
            identity: Identity::new(),
            control_frames: PerBus::default(),
            services: Services::new(id, objects, profile, None),
            initial: redundancy,
            startup: NmtStartup::of_slave(profile.autostart),
            stamped: profile.stamped,
            marks: Marks::ALL,
            changed_filters: 0,
            wanted: None,
            warning: None,
        }
    }

    /// With a parameter store: objects 1010h and 1011h work, and power-on begins with what is stored.
    #[must_use]
    pub fn with_store(mut self, store: &'static mut (dyn ParameterStore + Send)) -> Self {
        self.services.dictionary.stored.store = Some(store);
        self.load_all();
        self
    }

    /// What it receives: exact COB-IDs only. A filter for each entry of 1016h and for each RPDO, valid or not, then one for
    /// heartbeats of another node with this Node-ID, as long as there are filters.
    pub fn filters(&self) -> Filters {
        let last = self.filters_of_rpdos() + D::Pdos::RECEIVE;
        let mut filters: Filters = (0..=last).take(MAX_FILTERS - 1).map(|n| self.filter(n)).collect();
        if last >= MAX_FILTERS - 1 {
            // More than the controllers can tell apart.
            let _ = filters.push(Filter { id: CobId::NMT, mask: 0 });
        }
        filters
    }

    /// The first filter of the RPDOs.
    fn filters_of_rpdos(&self) -> usize {
        FILTERS_OF_PEERS + self.services.consumers()
    }

    /// What a filter admits, by the dictionary; NMT again where there is nothing.
    fn filter(&self, number: usize) -> Filter {
        let id = match number {
            SYNC_FILTER => Some(self.services.written_sync_id()),
            2 => Some(self.services.sdo_id()),
            3 => Some(CobId::heartbeat(NodeId::MASTER)),
            0..FILTERS_OF_PEERS => None,
            _ => match number.checked_sub(self.filters_of_rpdos()) {
                None => self.services.monitored(number - FILTERS_OF_PEERS),
                // Behind the RPDOs: another node with this Node-ID.
                Some(pdo) if pdo == D::Pdos::RECEIVE => Some(CobId::heartbeat(self.id)),
                Some(pdo) => self.services.rpdo_ids().nth(pdo).flatten(),
            },
        };
        Filter::exact(id.unwrap_or(CobId::NMT))
    }

    /// A filter changed: both buses are told when the node runs next.
    fn admit(&mut self, number: usize) {
        if number < MAX_FILTERS - 1 {
            self.changed_filters |= 1 << number;
            self.services.next = Instant::ZERO;
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
        out.send_for(self.selector.selected(), frame, now, self.services.lifetimes.heartbeat);
        let state = self.nmt.boot();
        self.entered(state, now, out);
        self.heartbeat.restart(now);
        self.selector.start(now);
        self.identity.boot(now);
        self.guard.on_boot(now);
        self.set_marks();
        self.services.next = now;
    }

    /// A frame that may be for this node. The frequent ones first; each handler ends with what has become due.
    #[inline(never)] // what is for others need not pay for it
    fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let (id, state) = (frame.id(), self.nmt.state());
        // Only the active bus is obeyed.
        if bus != self.selector.selected() {
            self.on_network(bus, frame, stamp, now, out);
        } else if id == self.services.sync_id() && state.allows_sync() {
            self.on_sync(frame, stamp, now, out);
        } else if id == self.services.sdo_id() && state.allows_sdo() {
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
        let is_heartbeat = id.function() == CobId::heartbeat(NodeId::MASTER).function();
        if is_heartbeat || id == CobId::NMT {
            self.control_frames[bus] = self.control_frames[bus].wrapping_add(1);
        }
        if self.nmt.state() == NmtState::Initialising {
            // Told again with every frame: were it lost in a full channel, the node would stay silent for ever.
            out.event(SlaveEvent::ResetNode);
            self.services.buses.ignored(bus);
        } else if !self.services.buses.is_joined(bus, active) {
            self.services.buses.ignored(bus);
        } else if id == CobId::NMT {
            self.on_nmt(bus, frame, stamp, now, out);
        } else if id == CobId::heartbeat(NodeId::MASTER) {
            self.on_master_heartbeat(bus, frame, stamp, now, out);
        } else if id == CobId::heartbeat(self.id) {
            self.on_own_heartbeat(bus, frame, stamp, now, out);
        } else if bus == active && is_heartbeat {
            self.on_peer_heartbeat(bus, frame, stamp, out);
        } else {
            self.services.buses.ignored(bus);
        }
        self.run(now, now, out);
    }

    /// What was due at `until`, which may be before `now`: a frame is judged as of its end.
    #[inline(always)]
    fn run(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if until >= self.services.next {
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
        if let Some(bus) = self.wanted.take() {
            self.change_bus(bus, now, out);
        }
        self.warning.take_if(|end| *end <= until);
        while self.warning.is_none()
            && let Some(selection) = self.selector.poll(until)
        {
            self.apply(selection, now, out);
        }
        if self.identity.poll(until, self.selector.parameters().hold_off_time()) {
            self.on_clash_over(now, out);
        }
        self.open_guard(until);
        while let Some(missed) = self.services.monitor.poll(until) {
            self.on_peer_missed(missed.node, now, out);
        }
        if let Some(frame) = self.heartbeat.poll(until, self.nmt.state()) {
            out.send_for(self.selector.selected(), frame, now, self.services.lifetimes.heartbeat);
        }
        while let Some(bus) = self.services.buses.poll(until, out) {
            out.event(SlaveEvent::BusFailed { bus });
        }
        self.run_device(until, now, out);
        self.services.next = self.due().unwrap_or(Instant::NEVER);
        if self.changed_filters != 0 {
            self.services.next = self.services.next.min(now + FILTER_PAUSE);
        }
    }

    fn due(&self) -> Option<Instant> {
        let own = [
            self.warning.or_else(|| self.selector.deadline()),
            self.identity.deadline(self.selector.parameters().hold_off_time()),
            self.guard.deadline(self.pause()),
            self.heartbeat.deadline(),
            self.services.buses.deadline(),
            self.services.monitor.deadline(),
            self.services.deadline(self.nmt.state()),
        ];
        earliest(&own)
    }

    /// The node as it is at `now`.
    pub fn status(&self, now: Instant) -> Status {
        Status {
            uptime: now.since(Instant::ZERO),
            scet: self.services.clock.at(now),
            state: self.nmt.state(),
            active: self.selector.selected(),
            redundancy: *self.selector.parameters(),
            counters: self.services.buses.counters,
            health: self.services.buses.health,
        }
    }

    /// Chooses the bus, with selective access (ECSS 8.2.3a): the node goes to Pre-operational and searches the master,
    /// beginning on `bus`, Ctoggle zero. [`SlaveEvent::ActiveBus`] reports it.
    ///
    /// # Errors
    /// [`ParallelAccess`]: the master chooses the bus of a node with parallel access.
    pub fn select_bus(&mut self, bus: Bus) -> Result<(), ParallelAccess> {
        if self.services.buses.access() == Access::Parallel {
            return Err(ParallelAccess);
        }
        (self.wanted, self.services.next) = (Some(bus), Instant::ZERO);
        Ok(())
    }

    /// Zero the counters of both buses.
    pub fn reset_counters(&mut self) {
        self.services.buses.counters = PerBus::<Counters>::default();
    }

    /// Local spacecraft time.
    pub fn scet(&self, now: Instant) -> Scet {
        self.services.clock.at(now)
    }
}

impl<D: Device> Node for Slave<D> {
    type Event = SlaveEvent;
    type Request = core::convert::Infallible;

    fn filters(&self) -> Filters {
        self.filters()
    }

    fn start(&mut self, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        self.services.buses.join(bus, out);
        out.event(SlaveEvent::ActiveBus { bus, cause: BusCause::PowerOn });
        self.boot(now, out);
        self.run(now, now, out);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant, out: &mut Out) {
        if let LinkEvent::Received { frame, stamp } = event {
            return self.on_received(bus, frame, stamp, now, out);
        }
        self.on_bus_event(bus, event, now, out);
    }

    #[inline]
    fn on_received(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        self.services.buses.received(bus);
        if now >= self.services.next {
            self.run(stamp.at.min(now), now, out);
        } else if !self.marks.may_have(frame.id()) {
            return self.services.buses.ignored(bus);
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
        let silent = self.nmt.state() == NmtState::Initialising || self.services.next == Instant::NEVER;
        if silent { None } else { Some(self.services.next) }
    }

    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool {
        let is_on_list = bus == self.selector.selected() && self.stamped.contains(&frame.id());
        is_on_list && (frame.id() != self.services.sync_id() || is_sync_length(frame))
    }
}
