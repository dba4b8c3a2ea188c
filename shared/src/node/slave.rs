//! A slave node.

mod builder;
#[cfg(test)]
mod flipped;
mod objects;
mod redundancy;
mod retained;

pub use builder::SlaveBuilder;

use async_canopen::node::extend::{Part, SlaveCore, Timed};

use super::services::State;
use super::settings;
use super::upsets::Upsets;
use super::{ParallelAccess, SlaveEvent, Spacecraft, SpacecraftDevice, Status, objects as own_objects};
use crate::link::Stamp;
use crate::link::budget::{Budget, BudgetStep, Over};
use crate::link::port::Filter;
use crate::node::services::{SpacecraftServices, TimeServices, UpsetServices};
use crate::node::{Filters, FullDepth, LinkEvent, Node, TimeKeeper};
use crate::profile::Profile;
use crate::redundancy::{BusCause, Parameters, Retained, SlaveRedundancy};
use crate::sync::is_sync_length;
use crate::time::LocalClock;
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId, Scet};

/// CANopen part of a slave of a spacecraft.
type Core<D> = SlaveCore<D, Spacecraft>;
type Turn<'a> = super::Turn<'a, SlaveEvent>;

/// Slave of a spacecraft: NMT slave, redundancy slave, consumer of SYNC and time, CANopen device.
#[doc(alias("NMT slave", "redundancy slave", "SYNC consumer", "time consumer"))]
#[derive(Debug)]
pub struct Slave<D: SpacecraftDevice> {
    canopen: Core<D>,
    redundancy: Timed<SlaveRedundancy>,
    memory: retained::Memory,
    budget: Timed<Budget>,
    initial: Parameters,
    /// COB-IDs of [`Profile::stamped`].
    stamped: &'static [CobId],
}

impl<D: SpacecraftDevice> Slave<D> {
    #[inline(never)] // row `size.pyboard-v11.slave.flash.runner`: 2 282 bytes more without it
    fn new(id: NodeId, profile: &Profile, application: D, upsets: Option<&'static Upsets>) -> Self {
        let redundancy = profile.redundancy();
        Slave {
            canopen: SlaveCore::new(
                id,
                &settings::of_profile(profile, id),
                own_objects::at_power_on(id, &redundancy, application),
                || State::new(profile, upsets),
            ),
            redundancy: Timed::new(SlaveRedundancy::new(
                profile.access(id),
                redundancy,
                Retained::default(),
                profile.grace,
            )),
            memory: retained::Memory::default(),
            budget: Timed::new(Budget::of_slave(&profile.budget)),
            initial: redundancy,
            stamped: profile.stamped,
        }
    }

    /// Dispatches a frame that may be for this node, the most frequent kinds first. Each handler ends with a run of the node.
    #[inline(never)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    fn on_frame(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        let (id, state) = (frame.id(), self.canopen.state());
        // Only the active bus is obeyed.
        if bus != self.redundancy.selected() {
            self.on_network(bus, frame, stamp, turn);
        } else if self.canopen.takes_sync(id) {
            self.on_sync(frame, stamp, turn);
        } else if self.canopen.takes_sdo(id) {
            self.on_sdo(frame, turn);
        } else if id < CobId::heartbeat(NodeId::MASTER) && state.allows_pdo() {
            self.on_pdo(frame, stamp, turn);
        } else {
            self.on_network(bus, frame, stamp, turn);
        }
    }

    /// Does what is due.
    #[inline(always)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    fn run(&mut self, turn: &mut Turn) {
        if self.canopen.is_due(turn.until) {
            self.run_due(turn);
        }
    }

    #[inline(never)] // row `rx.interrupt_to_dictionary_median`: 60 more without the eight that name it
    fn run_due(&mut self, turn: &mut Turn) {
        if self.canopen.state() == NmtState::Initialising {
            return;
        }
        let until = turn.until;
        if self.canopen.control().deadline().is_some_and(|due| due <= until) {
            self.refresh(turn.now);
        }
        while self.decide_in_run(turn, |redundancy, step| redundancy.poll(until, step)) {}
        self.run_budget(turn);
        self.canopen.poll(self.redundancy.selected(), turn);
        self.canopen.set_filters(&Bus::ALL, turn);
        self.canopen.settle();
        self.redundancy.settle(self.canopen.wakes_mut());
        self.budget.settle(self.canopen.wakes_mut());
        turn.out.note_done(until);
    }

    /// Corrects what the redundancy and the budget keep for long, before each heartbeat.
    fn refresh(&mut self, now: Instant) {
        let written = self.canopen.services().written_redundancy();
        self.budget.no_sooner().confine(now);
        let redundancy = self.redundancy.no_sooner();
        if redundancy.is_silenced() && !self.budget.is_silent() {
            redundancy.resume();
        }
        if redundancy.refresh(written, now) {
            self.canopen.services_mut().report_flipped();
        }
    }

    /// Returns the state of the node at `now`.
    pub fn status(&self, now: Instant) -> Status {
        Status {
            uptime: now.since(Instant::ZERO),
            scet: self.canopen.services().scet(now),
            state: self.canopen.state(),
            active: self.redundancy.selected(),
            redundancy: *self.redundancy.parameters(),
            counters: *self.canopen.services().buses().counters(),
            health: *self.canopen.services().buses().health(),
        }
    }

    /// Chooses the bus of a node with selective access (ECSS 8.2.3a). The node enters Pre-operational and searches
    /// the master, beginning on `bus` with Ctoggle zero. [`SlaveEvent::ActiveBus`] reports the choice.
    ///
    /// # Errors
    /// [`ParallelAccess`]: the master chooses the bus of a node with parallel access.
    pub fn select_bus(&mut self, bus: Bus) -> Result<(), ParallelAccess> {
        if self.redundancy.change(self.canopen.wakes_mut()).choose(bus) {
            Ok(())
        } else {
            Err(ParallelAccess)
        }
    }

    /// Resets the counters of both buses to zero.
    pub fn reset_counters(&mut self) {
        self.canopen.buses_mut().reset_counters();
    }

    /// Returns the local spacecraft time.
    pub fn scet(&self, now: Instant) -> Scet {
        self.canopen.services().scet(now)
    }

    fn on_bus_event(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn) {
        self.canopen.on_bus_event(bus, bus == self.redundancy.selected(), event, turn);
        match event {
            LinkEvent::Transmitted { frame, stamp } => {
                let id = self.canopen.control().id();
                if frame.id() == CobId::heartbeat(id) {
                    let services = self.canopen.services_mut();
                    services.note_heartbeat(stamp);
                    services.on_heartbeat_sent();
                    services.report_upsets();
                }
                let wakes = self.canopen.wakes_mut();
                self.redundancy.step(wakes, |redundancy| redundancy.on_sent(frame, stamp.at, id));
            }
            LinkEvent::Failed { frame, .. } => {
                let wakes = self.canopen.wakes_mut();
                self.redundancy.step(wakes, |redundancy| redundancy.on_end(frame));
            }
            _ => {}
        }
        self.run(turn);
    }

    /// Reports a frame that the budget refused.
    fn on_over_budget(&mut self, id: CobId, over: Over, turn: &mut Turn) {
        self.budget.settle(self.canopen.wakes_mut());
        if self.canopen.services_mut().over_budget(id, over) {
            turn.out.event(SlaveEvent::OverBudget { id });
        }
        if over == Over::Node {
            self.decide(turn, |redundancy, step| redundancy.silence(step));
        }
    }

    fn run_budget(&mut self, turn: &mut Turn) {
        match self.budget.no_sooner().poll(turn.until) {
            Some(BudgetStep::Resume) => {
                self.redundancy.no_sooner().resume();
                // ECSS 6.10k: the boot-up message has the Node-ID.
                self.canopen.check_node_id();
                self.boot(turn);
            }
            Some(BudgetStep::Calm) => self.canopen.services_mut().within_budget(),
            None => {}
        }
    }
}

impl<D: SpacecraftDevice> Node for Slave<D> {
    type Event = SlaveEvent;
    type Request = core::convert::Infallible;
    type Depth = FullDepth;

    fn filters(&self) -> Filters {
        self.canopen.filters()
    }

    fn filter(&self, number: usize) -> Option<Filter> {
        self.canopen.wanted_filter(number)
    }

    fn start(&mut self, turn: &mut Turn) {
        let bus = self.redundancy.selected();
        self.canopen.buses_mut().join(bus, turn.out);
        turn.out.event(SlaveEvent::ActiveBus { bus, cause: BusCause::PowerOn });
        self.boot(turn);
        self.run(turn);
    }

    fn on_link(&mut self, bus: Bus, event: &LinkEvent, turn: &mut Turn) {
        match event {
            LinkEvent::Received { frame, stamp } => self.on_received(bus, frame, stamp, turn),
            _ => self.on_bus_event(bus, event, turn),
        }
    }

    fn on_received(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, turn: &mut Turn) {
        self.canopen.buses_mut().count_received(bus);
        if !self.canopen.is_due(turn.now) {
            if !self.canopen.may_take(frame.id()) {
                return self.canopen.buses_mut().count_ignored(bus);
            }
            return self.on_frame(bus, frame, stamp, turn);
        }
        // A frame is judged by its end.
        turn.until = stamp.at.min(turn.now);
        self.run(turn);
        turn.until = turn.now;
        self.on_frame(bus, frame, stamp, turn);
    }

    fn on_request(&mut self, request: Self::Request, _turn: &mut Turn) {
        match request {}
    }

    fn poll(&mut self, turn: &mut Turn) {
        self.run_due(turn);
        self.advance_save(turn);
    }

    fn deadline(&self) -> Option<Instant> {
        self.canopen.services().with_save(self.canopen.deadline())
    }

    fn is_on_schedule(&self, now: Instant) -> bool {
        self.canopen.control().is_on_schedule(now)
    }

    fn charge(&mut self, frame: &Frame, turn: &mut Turn) -> bool {
        // Its client limits it, as that of the default server.
        if self.canopen.services().is_second_sdo_answer(frame.id()) {
            return true;
        }
        let over = self.budget.no_sooner().take(frame.id(), turn.now);
        over.map(|over| self.on_over_budget(frame.id(), over, turn)).is_none()
    }

    fn is_stamped(&self, bus: Bus, frame: &Frame) -> bool {
        let id = frame.id();
        let services = self.canopen.services();
        let is_measured = if services.is_sync(id) {
            is_sync_length(frame)
        } else {
            let is_ranged =
                services.time().is_ranged() && id == CobId::heartbeat(self.canopen.control().id());
            is_ranged || self.stamped.contains(&id)
        };
        is_measured && bus == self.redundancy.selected()
    }
}

impl<D: SpacecraftDevice> TimeKeeper for Slave<D> {
    fn spacecraft_clock(&self) -> &LocalClock {
        self.canopen.services().time().clock()
    }
}

impl Part for SlaveRedundancy {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}
