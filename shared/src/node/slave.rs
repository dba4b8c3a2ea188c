//! A slave node.

mod budget;
mod bus_events;
mod clash;
#[cfg(test)]
mod flipped;
mod maintenance;
mod network;
mod objects;
mod retained;

use super::canopen::{Canopen, Out, is_heartbeat};
use super::{BusCause, Counters, Device, NodeObjects, ParallelAccess, SlaveEvent, Status};
use crate::link::Stamp;
use crate::link::budget::Budget;
use crate::link::port::Filter;
use crate::nmt::{ClashWatch, ResetGuard};
use crate::node::{Filters, LinkEvent, Node, TimeKeeper, Usual};
use crate::profile::Profile;
use crate::redundancy::{BusAccess, Parameters, Selector};
use crate::store::ParameterStore;
use crate::sync::is_sync_length;
use crate::time::LocalClock;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus, Scet, earliest};

/// Slave of a spacecraft: NMT slave, redundancy slave, consumer of SYNC and time, CANopen device.
#[doc(alias("NMT slave", "redundancy slave", "SYNC consumer", "time consumer"))]
#[derive(Debug)]
pub struct Slave<D: Device> {
    canopen: Canopen<D>,
    guard: ResetGuard,
    retained: retained::Memory,
    selector: Selector,
    clashes: ClashWatch,
    budget: Budget,
    /// Module control and heartbeats received; wraps.
    control_frames: PerBus<u32>,
    initial: Parameters,
    /// COB-IDs of [`Profile::stamped`].
    stamped: &'static [CobId],
    /// The bus that the application chose.
    wanted: Option<Bus>,
    /// An EMCY is on its way that goes before a change of the bus. Until then, at most.
    warning: Option<Instant>,
    /// Length of that time: [`Profile::grace`].
    warning_time: Duration,
}

impl<D: Device> Slave<D> {
    /// Makes a slave before power-on. `id` is 2 to 127.
    #[inline(never)] // places on a small stack are reached by short instructions
    pub fn new(id: NodeId, profile: &Profile, application: D) -> Self {
        let redundancy = profile.redundancy();
        Slave {
            canopen: Canopen::new(id, profile, NodeObjects::new(id, &redundancy, application)),
            guard: ResetGuard::default(),
            retained: retained::Memory::default(),
            selector: Selector::new(redundancy),
            clashes: ClashWatch::new(),
            budget: Budget::of_slave(&profile.budget),
            control_frames: PerBus::default(),
            initial: redundancy,
            stamped: profile.stamped,
            wanted: None,
            warning: None,
            warning_time: profile.grace,
        }
    }

    /// Adds the parameter store of a board that has one: objects 1010h and 1011h work, and the stored parameters apply from
    /// power-on. `None`: the slave saves nothing.
    #[must_use]
    pub fn with_store(mut self, store: Option<&'static mut (dyn ParameterStore + Send)>) -> Self {
        if let Some(store) = store {
            self.show_node_id(store);
            self.canopen.services.dictionary.stored.store = Some(store);
            self.load_all();
        }
        self
    }

    /// Sends some heartbeats late, by [`Profile::late_heartbeat`]. Each heartbeat takes the next bit of `pattern`
    /// and is late if the bit is set. The default is zero: no heartbeat is late.
    ///
    /// Give each chip another pattern, such as a CRC-32 of its unique ID. By it two boards with one Node-ID find
    /// each other when they boot together with equal clocks (EMCY 8150h).
    #[must_use]
    pub fn with_late_heartbeats(mut self, pattern: u32) -> Self {
        self.canopen.heartbeat.set_pattern(pattern);
        self
    }

    /// Boot-up on the bus selected, then Pre-operational (ECSS 8.3.2).
    fn boot(&mut self, now: Instant, out: &mut Out) {
        self.canopen.restore_communication(&self.initial, now);
        self.selector.configure(self.written_redundancy());
        self.canopen.boot(self.selector.selected(), now, out);
        self.selector.start(now);
        self.clashes.boot(now);
        self.guard.on_boot(now);
        self.canopen.services.next = now;
    }

    /// A frame that may be for this node. The frequent ones first; each handler ends with what has become due.
    #[inline(never)] // what is for others need not pay for it
    fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let (id, state) = (frame.id(), self.canopen.nmt.state());
        // Only the active bus is obeyed.
        if bus != self.selector.selected() {
            self.on_network(bus, frame, stamp, now, out);
        } else if self.canopen.services.is_sync(id) && state.allows_sync() {
            self.on_sync(frame, stamp, now, out);
        } else if self.canopen.services.is_sdo(id) && state.allows_sdo() {
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
        let is_heartbeat = is_heartbeat(id);
        if is_heartbeat || id == CobId::NMT {
            self.control_frames[bus] = self.control_frames[bus].wrapping_add(1);
        }
        if self.canopen.nmt.state() == NmtState::Initialising {
            // Reported again with every frame: if the event were lost in a full queue, the node would stay silent.
            out.event(SlaveEvent::ResetNode);
            self.canopen.services.buses.ignored(bus);
        } else if !self.canopen.services.buses.is_joined(bus, active) {
            self.canopen.services.buses.ignored(bus);
        } else if id == CobId::NMT {
            self.on_nmt(bus, frame, stamp, now, out);
        } else if id == CobId::heartbeat(NodeId::MASTER) {
            self.on_master_heartbeat(bus, frame, stamp, now, out);
        } else if id == CobId::heartbeat(self.canopen.id) {
            self.on_own_heartbeat(bus, frame, stamp, now, out);
        } else if bus == active && is_heartbeat {
            self.canopen.on_peer_heartbeat(bus, frame, stamp, out);
        } else {
            self.canopen.services.buses.ignored(bus);
        }
        self.run(now, now, out);
    }

    /// Does what was due at `until`, which may be before `now`: a frame is judged by its end.
    #[inline(always)]
    fn run(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if until >= self.canopen.services.next {
            self.run_due(until, now, out);
        }
    }

    #[inline(never)] // most frames find nothing due
    fn run_due(&mut self, until: Instant, now: Instant, out: &mut Out) {
        if self.canopen.nmt.state() == NmtState::Initialising {
            return;
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
        if self.clashes.is_known() && self.clashes.poll(until, self.selector.parameters().hold_off_time()) {
            self.on_clash_over(now, out);
        }
        if self.guard.is_counting() {
            self.open_guard(until);
        }
        self.run_budget(until, now, out);
        self.canopen.poll(self.selector.selected(), until, now, out);
        self.canopen.set_filters(&Bus::ALL, out);
        self.canopen.rest(self.due(), now);
    }

    fn due(&self) -> Option<Instant> {
        // Multiplications, seldom needed.
        let hold_off = || self.selector.parameters().hold_off_time();
        let own = [
            self.warning.or_else(|| self.selector.deadline()),
            if self.clashes.is_known() { self.clashes.deadline(hold_off()) } else { None },
            self.guard.deadline(self.pause()),
            self.budget.deadline(),
            self.canopen.due(),
        ];
        earliest(&own)
    }

    /// Returns the state of the node at `now`.
    pub fn status(&self, now: Instant) -> Status {
        Status {
            uptime: now.since(Instant::ZERO),
            scet: self.canopen.services.scet(now),
            state: self.canopen.nmt.state(),
            active: self.selector.selected(),
            redundancy: *self.selector.parameters(),
            counters: self.canopen.services.buses.counters,
            health: self.canopen.services.buses.health,
        }
    }

    /// Chooses the bus of a node with selective access (ECSS 8.2.3a). The node enters Pre-operational and searches
    /// the master, beginning on `bus` with Ctoggle zero. [`SlaveEvent::ActiveBus`] reports the choice.
    ///
    /// # Errors
    /// [`ParallelAccess`]: the master chooses the bus of a node with parallel access.
    pub fn select_bus(&mut self, bus: Bus) -> Result<(), ParallelAccess> {
        if self.canopen.services.buses.access() == BusAccess::Parallel {
            return Err(ParallelAccess);
        }
        (self.wanted, self.canopen.services.next) = (Some(bus), Instant::ZERO);
        Ok(())
    }

    /// Resets the counters of both buses to zero.
    pub fn reset_counters(&mut self) {
        self.canopen.services.buses.counters = PerBus::<Counters>::default();
    }

    /// Breaks a rule, for tests.
    #[cfg(feature = "model")]
    pub fn break_rule(&mut self, broken: Option<crate::redundancy::Broken>) {
        self.selector.break_rule(broken);
    }

    /// Returns the local spacecraft time.
    pub fn scet(&self, now: Instant) -> Scet {
        self.canopen.services.scet(now)
    }
}

impl<D: Device> Node for Slave<D> {
    type Event = SlaveEvent;
    type Request = core::convert::Infallible;
    type Depth = Usual;

    fn filters(&self) -> Filters {
        self.canopen.filters()
    }

    fn filter(&self, number: usize) -> Option<Filter> {
        self.canopen.wanted_filter(number)
    }

    fn start(&mut self, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        self.canopen.services.buses.join(bus, out);
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
        self.canopen.services.buses.received(bus);
        if now >= self.canopen.services.next {
            self.run(stamp.at.min(now), now, out);
        } else if !self.canopen.may_take(frame.id()) {
            return self.canopen.services.buses.ignored(bus);
        }
        self.on_frame(bus, frame, stamp, now, out);
    }

    fn on_request(&mut self, request: Self::Request, _now: Instant, _out: &mut Out) {
        match request {}
    }

    fn poll(&mut self, now: Instant, out: &mut Out) {
        self.run(now, now, out);
        if self.canopen.services.is_saving() {
            self.advance_save(now, out);
        }
    }

    fn deadline(&self) -> Option<Instant> {
        self.canopen.services.save_deadline().or_else(|| self.canopen.deadline())
    }

    #[inline(always)] // called from one place
    fn may_send(&mut self, frame: &Frame, now: Instant, out: &mut Out) -> bool {
        self.budget
            .take(frame.id(), now)
            .map(|over| self.on_over_budget(frame.id(), over, now, out))
            .is_none()
    }

    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool {
        let id = frame.id();
        let is_ranged = self.canopen.services.time.is_ranged() && id == CobId::heartbeat(self.canopen.id);
        (self.stamped.contains(&id) || is_ranged)
            && bus == self.selector.selected()
            && (!self.canopen.services.is_sync(id) || is_sync_length(frame))
    }
}

impl<D: Device> TimeKeeper for Slave<D> {
    fn spacecraft_clock(&self) -> &LocalClock {
        self.canopen.services.time.clock()
    }
}
