//! CANopen part of a slave (CiA 301): NMT slave, heartbeat, services, and the frames that they take.
//!
//! Each call names the bus to use. A node with redundancy has its choice of the bus around this part.

mod cob_id_set;
mod device;
mod filters;

use super::buses::Buses;
use super::changed_filters::ChangedFilters;
use super::events::SlaveEvents;
use super::services::Services;
use super::turn::{Timed, Turn, Wakes};
use super::{Device, Settings};
use crate::heartbeat::{self, HeartbeatTimes, NodeControl};
use crate::link::Stamp;
use crate::nmt::{NmtStartup, Reaction};
use crate::node::services::{Extension, NodeObjects};
use crate::od::INVALID;
use crate::types::{Bus, CobId, Frame, Instant, NmtState, NodeId};
use cob_id_set::CobIdSet;
pub use filters::{FILTERS_OF_PEERS, SYNC_FILTER};

/// NMT slave, SYNC consumer and CANopen device. `E`: parts of the node beyond CANopen.
#[derive(Debug)]
pub struct SlaveCore<D: Device, E: Extension<D>> {
    /// NMT state and heartbeat of the node.
    control: Timed<NodeControl>,
    services: Services<D, E>,
    startup: NmtStartup,
    /// It receives SDO requests alone, and sends their answers alone.
    is_maintained: bool,
    /// COB-IDs that are taken; frames without a mark are for others.
    taken: CobIdSet,
    changed_filters: Timed<ChangedFilters>,
}

impl<D: Device, E: Extension<D>> SlaveCore<D, E> {
    /// Makes the part before power-on.
    pub fn new(
        id: NodeId,
        settings: &Settings,
        mut objects: NodeObjects<D, E>,
        state: impl FnOnce() -> E::State,
    ) -> Self {
        let startup = NmtStartup::of_slave(settings.autostart);
        objects.communication.nmt.startup = startup.raw();
        SlaveCore {
            control: Timed::new(NodeControl::new(
                id,
                settings.heartbeats.producer,
                settings.late_heartbeat,
                settings.autostart,
            )),
            services: Services::new(id, || objects, E::Storage::default(), settings, state),
            startup,
            is_maintained: false,
            taken: CobIdSet::ALL,
            changed_filters: Timed::new(ChangedFilters::default()),
        }
    }

    /// Returns dictionary and services.
    pub const fn services(&self) -> &Services<D, E> {
        &self.services
    }

    /// Lends dictionary and services.
    pub const fn services_mut(&mut self) -> &mut Services<D, E> {
        &mut self.services
    }

    /// Lends the instant before which nothing is due in the node, for a change of another part of it.
    pub fn wakes_mut(&mut self) -> &mut Wakes {
        self.services.wakes_mut()
    }

    /// Returns the dictionary alone.
    pub fn into_objects(self) -> NodeObjects<D, E> {
        self.services.into_objects()
    }

    /// Lends the buses for a change that makes nothing due earlier.
    pub fn buses_mut(&mut self) -> &mut Buses {
        self.services.buses_mut()
    }

    /// Returns NMT state and heartbeat of the node.
    pub fn control(&self) -> &NodeControl {
        &self.control
    }

    /// Lends NMT state and heartbeat for a change. The node runs at the end of its step.
    pub fn control_mut(&mut self) -> &mut NodeControl {
        self.control.change(self.services.wakes_mut())
    }

    /// Returns the NMT state of the node.
    pub fn state(&self) -> NmtState {
        self.control.state()
    }

    /// Returns whether a frame is a SYNC that the node takes in its NMT state.
    pub fn takes_sync(&self, id: CobId) -> bool {
        self.services.is_sync(id) && self.state().allows_sync()
    }

    /// Returns whether a frame is an SDO request that the node answers in its NMT state.
    pub fn takes_sdo(&self, id: CobId) -> bool {
        self.services.is_sdo(id) && self.control.reporting_state().allows_sdo()
    }

    /// Enters maintenance mode: SDO on one bus. Call it before power-on.
    pub fn maintain(&mut self) {
        self.is_maintained = true;
        self.startup = NmtStartup::of_slave(false);
        self.services.buses_mut().keep_to_one();
    }

    fn is_maintained(&self) -> bool {
        E::HAS_TWO_BUSES && self.is_maintained
    }

    /// Sends the boot-up message on `bus`, and enters Pre-operational. The caller restores the
    /// communication profile of power-on before.
    pub fn boot(&mut self, bus: Bus, turn: &mut Turn<'_, E::SlaveEvent>) {
        let boot_up = self.control_mut().boot(turn.now);
        // A master that hears of a node starts it, and misses it later.
        if !self.is_maintained() {
            turn.out.send_for(bus, boot_up, turn.now, self.services.heartbeat_lifetime());
        }
        self.entered(self.control.state(), turn);
        self.update_taken();
    }

    /// Changes the NMT state. Returns whether the caller has to boot the node up again.
    pub fn change_state(
        &mut self,
        turn: &mut Turn<'_, E::SlaveEvent>,
        change: impl FnOnce(&mut NodeControl) -> Reaction,
    ) -> bool {
        match change(self.control_mut()) {
            Reaction::Unchanged => {}
            Reaction::Entered(state) => self.entered(state, turn),
            Reaction::ResetNode => self.wait_for_reset(turn),
            Reaction::ResetCommunication => return true,
        }
        false
    }

    /// Notes that the node entered another NMT state.
    fn entered(&mut self, state: NmtState, turn: &mut Turn<'_, E::SlaveEvent>) {
        self.services.entered(state, turn.now);
        turn.out.event(E::SlaveEvent::state(state));
    }

    /// Sends nothing more until the chip is reset.
    pub fn wait_for_reset(&mut self, turn: &mut Turn<'_, E::SlaveEvent>) {
        self.taken = CobIdSet::ALL;
        turn.out.event(E::SlaveEvent::reset_node());
    }

    /// Handles a heartbeat of another node that 1016h may name.
    #[inline(always)] // row `instructions.peer_heartbeat_consumed`: 21 more without it
    pub fn on_peer_heartbeat(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        turn: &mut Turn<'_, E::SlaveEvent>,
    ) {
        let Some((state, node)) = heartbeat::decode(frame).zip(frame.id().node()) else {
            return self.services.buses_mut().count_malformed(bus);
        };
        let Some(heard) = self.services.on_peer_heartbeat(node, state, stamp.at) else {
            return self.services.buses_mut().count_ignored(bus);
        };
        self.services.buses_mut().count_heartbeat(bus, frame);
        if heard.before != Some(state) {
            turn.out.event(E::SlaveEvent::peer_state(node, state));
        }
    }

    fn on_peer_missed(&mut self, node: NodeId, turn: &mut Turn<'_, E::SlaveEvent>) {
        turn.out.event(E::SlaveEvent::peer_missed(node));
        let behaviour = self.services.objects().communication.nmt.error_behaviour();
        // Neither behaviour is a reset.
        _ = self.change_state(turn, |control| control.on_communication_error(behaviour));
    }

    /// Does what was due at `until`, which may be before `now`. Frames go out on `bus`.
    pub fn poll(&mut self, bus: Bus, turn: &mut Turn<'_, E::SlaveEvent>) {
        while let Some(missed) = self.services.poll_monitor(turn.until) {
            self.on_peer_missed(missed, turn);
        }
        if E::IS_GUARDED && self.control.deadline().is_some_and(|due| due <= turn.until) {
            self.check_node_id();
        }
        let control = self.control.no_sooner();
        let heartbeat =
            if E::HAS_TWO_BUSES { control.poll(turn.until) } else { control.poll_on_time(turn.until) };
        if let Some(frame) = heartbeat {
            let lifetime = self.services.heartbeat_lifetime().min(self.control.period());
            turn.out.send_for(bus, frame, turn.now, lifetime);
        }
        while let Some(bus) = self.services.buses_mut().poll(turn) {
            turn.out.event(E::SlaveEvent::bus_failed(bus));
        }
        self.run_device(bus, turn);
    }

    /// Looks for flipped bits in the Node-ID, before a heartbeat has it and before a command of the master is obeyed.
    pub fn check_node_id(&mut self) {
        let mut id = self.control.id();
        self.services.compare_node_ids(&mut id);
        self.control.no_sooner().set_id(id);
    }

    /// Looks for flipped bits in COB-IDs, a few after each heartbeat: with it they would make a long
    /// step longer (row `rx.inside_look`).
    fn check_cob_ids(&mut self, now: Instant) {
        self.services.refresh_derived(self.control.state(), now);
        if self.control.period() != self.services.heartbeat_period() {
            self.follow_heartbeat(now);
        }
        self.update_taken();
        if self.services.compare_cob_ids(now) {
            // A bus may have taken its filter from the object that was wrong.
            self.note_all_filters();
        }
    }

    /// Notes when to poll next, after a run of the node, which may have moved every deadline.
    pub fn settle(&mut self) {
        self.services.settle(self.control.reporting_state());
        let wakes = self.services.wakes_mut();
        self.control.settle(wakes);
        self.changed_filters.settle(wakes);
    }

    /// Returns whether something is due in the node at `until`.
    pub fn is_due(&self, until: Instant) -> bool {
        self.services.wakes().is_due(until)
    }

    /// Returns when to poll next. `None`: the node waits for its reset, or nothing will be due.
    pub fn deadline(&self) -> Option<Instant> {
        if self.state() == NmtState::Initialising { None } else { self.services.wakes().deadline() }
    }

    /// Restores the communication profile of power-on, with the stored parameters.
    pub fn restore_communication(&mut self, initial: HeartbeatTimes, now: Instant) {
        let is_maintained = self.is_maintained();
        let objects = self.services.objects_mut();
        objects.restore_communication(self.control.id(), initial);
        objects.communication.nmt.startup = self.startup.raw();
        if is_maintained {
            objects.communication.emcy.cob_id |= INVALID;
        }
        self.services.load(crate::store::Group::Communication);
        self.services.configure(now);
        let startup = self.services.objects().communication.nmt.startup();
        self.control.no_sooner().set_autostart(startup.autostart());
        self.follow_heartbeat(now);
        self.note_all_filters();
    }

    /// Takes the new period of the heartbeat (1017h).
    pub(crate) fn follow_heartbeat(&mut self, now: Instant) {
        let period = self.services.heartbeat_period();
        self.control_mut().set_period(period, now);
    }

    /// Sends a transmit PDO (0 is the first) by its transmission type. Refuses it, and counts that on `bus`,
    /// unless the node is Operational and the PDO is valid.
    pub fn send_pdo(&mut self, bus: Bus, number: usize, now: Instant) {
        if self.state().allows_pdo() && self.services.tpdos().is_valid(number) {
            self.services.trigger(number, now);
        } else {
            self.services.buses_mut().count_refused(bus);
        }
    }
}
