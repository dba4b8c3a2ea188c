//! CANopen part of a slave (CiA 301): NMT slave, heartbeat, services, and the frames that they take.
//!
//! Each call names the bus to use. A node with redundancy has its choice of the bus around this part.

mod cob_id_set;
mod device;
mod events;
mod filters;

use super::services::Services;
use super::{Device, Extension, NodeObjects, Outbox, SlaveEvent, Spacecraft};
use crate::emcy::ErrorCode;
use crate::heartbeat::{self, NodeControl};
use crate::link::Stamp;
use crate::nmt::{NmtStartup, Reaction};
use crate::od::INVALID;
use crate::profile::Profile;
use crate::redundancy::Parameters;
use crate::types::{Bus, Duration, Frame, Instant, NmtState, NodeId, earliest};
use cob_id_set::CobIdSet;
pub use filters::{FILTERS_OF_PEERS, SYNC_FILTER};

pub type Out = Outbox<SlaveEvent>;

/// NMT slave, SYNC consumer and CANopen device. `E`: parts of the node beyond CANopen.
#[derive(Debug)]
pub struct Canopen<D: Device, E: Extension = Spacecraft> {
    pub control: NodeControl,
    pub services: Services<D, E>,
    startup: NmtStartup,
    /// It receives SDO requests alone, and sends their answers alone.
    is_maintained: bool,
    /// COB-IDs that are taken; frames without a mark are for others.
    taken: CobIdSet,
    /// A bit for each filter that is to be sent to its buses.
    changed_filters: u32,
}

impl<D: Device, E: Extension> Canopen<D, E> {
    pub fn new(id: NodeId, profile: &Profile, mut objects: NodeObjects<D, E>) -> Self {
        let startup = NmtStartup::of_slave(profile.autostart);
        objects.communication.nmt.startup = startup.raw();
        Canopen {
            control: NodeControl::new(id, profile.heartbeat, profile.late_heartbeat, profile.autostart),
            services: Services::new(id, || objects, profile, None),
            startup,
            is_maintained: false,
            taken: CobIdSet::ALL,
            changed_filters: 0,
        }
    }

    /// Enters maintenance mode: SDO on one bus. Call it before power-on.
    pub fn maintain(&mut self) {
        self.is_maintained = true;
        self.startup = NmtStartup::of_slave(false);
        self.services.buses.keep_to_one();
    }

    /// Sends the boot-up message on `bus`, and enters Pre-operational (ECSS 8.3.2). The caller restores the
    /// communication profile of power-on before.
    pub fn boot(&mut self, bus: Bus, now: Instant, out: &mut Out) {
        let boot_up = self.control.boot(now);
        // A master that hears of a node starts it, and misses it later.
        if !self.is_maintained {
            out.send_for(bus, boot_up, now, self.services.lifetimes.heartbeat);
        }
        self.entered(self.control.state(), now, out);
        self.update_taken();
    }

    /// Notes that the node entered another NMT state.
    pub fn entered(&mut self, state: NmtState, now: Instant, out: &mut Out) {
        self.services.entered(state, now);
        self.services.next = now;
        out.event(SlaveEvent::State(state));
    }

    /// Sends nothing more until the chip is reset.
    pub fn wait_for_reset(&mut self, out: &mut Out) {
        self.taken = CobIdSet::ALL;
        self.services.next = Instant::NEVER;
        out.event(SlaveEvent::ResetNode);
    }

    /// Handles a heartbeat of another node that 1016h may name.
    #[inline(always)] // called from one place
    pub fn on_peer_heartbeat(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp, out: &mut Out) {
        let Some((state, node)) = heartbeat::decode(frame).zip(frame.id().node()) else {
            return self.services.buses.malformed(bus);
        };
        let Some(heard) = self.services.monitor.on_heartbeat(node, state, stamp.at) else {
            return self.services.buses.ignored(bus);
        };
        self.services.buses.taken(bus, frame);
        if heard.resolved {
            self.services.clear(ErrorCode::HEARTBEAT, node.get());
            self.services.next = stamp.at;
        }
        if heard.before != Some(state) {
            out.event(SlaveEvent::PeerState { node, state });
        }
        self.services.wake(self.services.monitor.deadline());
    }

    fn on_peer_missed(&mut self, node: NodeId, now: Instant, out: &mut Out) {
        self.services.raise(ErrorCode::HEARTBEAT, [node.get(), 0, 0, 0, 0]);
        out.event(SlaveEvent::PeerMissed { node });
        let behaviour = self.services.dictionary.objects.communication.nmt.error_behaviour();
        if let Reaction::Entered(state) = self.control.on_communication_error(behaviour) {
            self.entered(state, now, out);
        }
    }

    /// Does what was due at `until`, which may be before `now`. Frames go out on `bus`.
    pub fn poll(&mut self, bus: Bus, until: Instant, now: Instant, out: &mut Out) {
        while let Some(missed) = self.services.monitor.poll(until) {
            self.on_peer_missed(missed.node, now, out);
        }
        if E::IS_GUARDED && self.control.deadline().is_some_and(|due| due <= until) {
            self.check_node_id();
        }
        if let Some(frame) = self.control.poll(until) {
            let lifetime = self.services.lifetimes.heartbeat.min(self.control.period());
            out.send_for(bus, frame, now, lifetime);
        }
        while let Some(bus) = self.services.buses.poll(until, out) {
            out.event(SlaveEvent::BusFailed { bus });
        }
        self.run_device(bus, until, now, out);
    }

    /// Looks for flipped bits in the Node-ID, before a heartbeat has it and before a command of the master is obeyed
    /// (ECSS 6.10k).
    #[inline(never)] // between heartbeats nothing is to be looked for
    pub fn check_node_id(&mut self) {
        let mut id = self.control.id();
        self.services.compare_node_ids(&mut id);
        self.control.set_id(id);
    }

    /// Looks for flipped bits in COB-IDs, a few after each heartbeat (ECSS 6.10d): with it they would make a long
    /// step longer (row `rx.inside_look`).
    fn check_cob_ids(&mut self, now: Instant) {
        if self.services.compare_cob_ids(now) {
            // A bus may have taken its filter from the object that was wrong.
            self.note_all_filters();
        }
    }

    /// Sends all filters to the buses. A controller that has them already is not disturbed.
    fn note_all_filters(&mut self) {
        (0..self.wanted_filters()).for_each(|number| self.note_filter(number));
    }

    /// Returns when to poll next at the latest, without regard to filters.
    #[inline(never)] // smaller than in its callers
    pub fn due(&self) -> Option<Instant> {
        let own = [
            self.control.deadline(),
            self.services.buses.deadline(),
            self.services.monitor.deadline(),
            self.services.deadline(self.control.reporting_state()),
        ];
        earliest(&own)
    }

    /// Returns when to poll next. `None`: the node waits for its reset, or nothing will be due.
    pub fn deadline(&self) -> Option<Instant> {
        let silent = self.control.state() == NmtState::Initialising || self.services.next == Instant::NEVER;
        if silent { None } else { Some(self.services.next) }
    }

    /// Restores the communication profile of power-on, with the stored parameters.
    pub fn restore_communication(&mut self, initial: &Parameters, now: Instant) {
        let objects = &mut self.services.dictionary.objects;
        objects.restore_communication(self.control.id(), initial);
        objects.communication.nmt.startup = self.startup.raw();
        if self.is_maintained {
            objects.communication.emcy.cob_id |= INVALID;
        }
        self.services.load(crate::store::Group::Communication);
        self.services.configure(now);
        let communication = &self.services.dictionary.objects.communication;
        self.control.set_autostart(communication.nmt.startup().autostart());
        self.follow_heartbeat(now);
        self.note_all_filters();
    }

    /// Takes the new period of the heartbeat (1017h).
    pub fn follow_heartbeat(&mut self, now: Instant) {
        let time = self.services.dictionary.objects.communication.heartbeat.time;
        self.control.set_period(Duration::from_millis(u64::from(time)), now);
    }

    /// Sends a transmit PDO (0 is the first) by its transmission type. Refuses it, and counts that on `bus`,
    /// unless the node is Operational and the PDO is valid.
    pub fn send_pdo(&mut self, bus: Bus, number: usize, now: Instant) {
        if self.control.state().allows_pdo() && self.services.dictionary.tpdos.is_valid(number) {
            self.services.dictionary.tpdos.trigger(number, now);
            self.services.next = now;
        } else {
            self.services.buses.refused(bus);
        }
    }
}
