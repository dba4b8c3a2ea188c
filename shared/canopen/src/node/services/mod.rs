//! CANopen device in a node: its object dictionary and the services that use it.
//!
//! It knows no redundancy. The node passes it frames of the active bus and the NMT state, and sends the frames that it
//! returns.

mod cob_ids;
mod dictionary;
mod emergencies;
mod extension;
mod follow;
mod guarded;
mod objects;
mod process_data;
mod rules;
mod sdo;
mod second_sdo;

use self::guarded::Guarded;
use self::second_sdo::SecondServer;
use super::buses::{BusNews, Buses};
use super::turn::{Timed, Wakes};
use super::{Device, LinkEvent, Settings};
use crate::emcy::ErrorCode;
use crate::heartbeat::Monitor;
use crate::heartbeat::machine::Heard;
use crate::link::Stamp;

use crate::node::index;
use crate::pdo::Tpdos;
use crate::sdo::{SdoServers, Server};
use crate::sync;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, Sealed};
pub use dictionary::Dictionary;
pub use extension::{CanopenOnly, Extension};
pub use objects::{NodeObjects, assert_device, assert_objects};
pub use sdo::SdoStep;

/// First object whose changes are reported to the application. Objects below belong to the services.
pub const FIRST_REPORTED: u16 = index::LAST_COMMUNICATION + 1;

/// Dictionary and services of a node. `E`: parts of the node beyond CANopen.
#[derive(Debug)]
pub struct Services<D: Device, E: Extension<D>> {
    id: NodeId,
    /// Objects, and the services that a write changes at once.
    dictionary: Dictionary<D, E>,
    /// Consumer of heartbeats.
    monitor: Timed<Monitor<D::Consumers>>,
    sync: sync::Consumer,
    sync_id: Sealed,
    /// COB-ID of requests to the SDO server.
    sdo_id: Sealed,
    server: Timed<Server>,
    /// Second SDO server, if the device has one.
    second_sdo: <D::Sdo as SdoServers>::Second<SecondServer>,
    /// State of the parts beyond CANopen.
    state: E::State,
    buses: Timed<Buses>,
    lifetimes: Lifetimes,
    /// Second copies of its COB-IDs.
    guarded: Guarded<D::Pdos>,
}

/// Lifetimes of frames that wait for their bus.
#[derive(Clone, Copy, Debug)]
struct Lifetimes {
    heartbeat: Duration,
    /// SYNC, and the PDOs that follow it.
    synchronous: Duration,
    /// Synchronous PDOs, after the mappings were followed.
    synchronous_pdo: Duration,
    /// Event-driven PDOs.
    event: Duration,
    /// SDO requests and responses.
    sdo: Duration,
}

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Makes the services. `objects` makes the dictionary in its place.
    pub fn new(
        id: NodeId,
        objects: impl FnOnce() -> NodeObjects<D, E>,
        stored: E::Storage,
        settings: &Settings,
        state: impl FnOnce() -> E::State,
    ) -> Self {
        let synchronous = settings.sync.min(settings.heartbeats.producer);
        Services {
            id,
            monitor: Timed::new(Monitor::new()),
            sync: sync::Consumer::new(0, 0),
            sync_id: Sealed::of(CobId::SYNC),
            sdo_id: Sealed::of(CobId::sdo_request(id)),
            server: Timed::new(Server::new(settings.sdo_timeout)),
            second_sdo: D::Sdo::second(|| SecondServer::new(settings.sdo_timeout)),
            state: state(),
            buses: Timed::new(Buses::new(settings.access, settings.bus_off)),
            lifetimes: Lifetimes {
                heartbeat: settings.heartbeats.producer,
                synchronous,
                synchronous_pdo: synchronous,
                event: settings.event,
                sdo: settings.sdo_timeout,
            },
            guarded: Guarded::new(),
            // Last: then the compiler makes it in its place.
            dictionary: Dictionary::new(id, objects, stored),
        }
    }

    /// Returns the Node-ID.
    pub const fn id(&self) -> NodeId {
        self.id
    }

    /// Returns the objects of the node.
    pub fn objects(&self) -> &NodeObjects<D, E> {
        self.dictionary.objects()
    }

    /// Lends the objects of the node. No service follows a change.
    pub fn objects_mut(&mut self) -> &mut NodeObjects<D, E> {
        self.dictionary.objects_mut()
    }

    /// Returns the objects alone.
    pub fn into_objects(self) -> NodeObjects<D, E> {
        self.dictionary.into_objects()
    }

    /// Returns the state of the parts beyond CANopen.
    pub const fn state(&self) -> &E::State {
        &self.state
    }

    /// Lends the state of the parts beyond CANopen.
    pub const fn state_mut(&mut self) -> &mut E::State {
        &mut self.state
    }

    /// Lends the objects of the node and the state of the parts beyond CANopen.
    pub fn objects_and_state(&mut self) -> (&mut NodeObjects<D, E>, &mut E::State) {
        (self.dictionary.objects_mut(), &mut self.state)
    }

    /// Lends the parameter store.
    pub fn storage_mut(&mut self) -> &mut E::Storage {
        self.dictionary.storage_mut()
    }

    /// Returns the buses of the node.
    pub fn buses(&self) -> &Buses {
        &self.buses
    }

    /// Lends the buses for a change that makes nothing due earlier.
    pub fn buses_mut(&mut self) -> &mut Buses {
        self.buses.no_sooner()
    }

    /// Counts an event of a bus and follows the error state of its controller. Returns a change that the node has to report.
    pub fn on_link(&mut self, bus: Bus, event: &LinkEvent, now: Instant) -> Option<BusNews> {
        // Recoveries begin and end here.
        self.buses.step(self.dictionary.wakes_mut(), |buses| buses.on_link(bus, event, now))
    }

    /// Returns the transmit PDOs.
    pub fn tpdos(&self) -> &Tpdos<D::Pdos> {
        self.dictionary.tpdos()
    }

    /// Returns the lifetime of a heartbeat.
    pub const fn heartbeat_lifetime(&self) -> Duration {
        self.lifetimes.heartbeat
    }

    /// Returns the lifetime of an event-driven PDO.
    pub const fn event_lifetime(&self) -> Duration {
        self.lifetimes.event
    }

    /// Returns the lifetime of an SDO request or response.
    pub const fn sdo_lifetime(&self) -> Duration {
        self.lifetimes.sdo
    }

    /// Returns the instant before which nothing is due in the node.
    pub fn wakes(&self) -> &Wakes {
        self.dictionary.wakes()
    }

    /// Lends the instant before which nothing is due in the node, for a change of one of its other parts.
    pub fn wakes_mut(&mut self) -> &mut Wakes {
        self.dictionary.wakes_mut()
    }

    /// Returns the period of the heartbeat (1017h).
    pub fn heartbeat_period(&self) -> Duration {
        self.objects().communication.heartbeat.period()
    }

    /// Takes a heartbeat of another node. `None`: no entry of 1016h consumes it.
    #[inline(always)] // row `instructions.peer_heartbeat_consumed`
    pub fn on_peer_heartbeat(&mut self, node: NodeId, state: NmtState, at: Instant) -> Option<Heard> {
        let wakes = self.dictionary.wakes_mut();
        let heard = self.monitor.step(wakes, |monitor| monitor.on_heartbeat(node, state, at))?;
        if heard.resolved {
            self.clear(ErrorCode::HEARTBEAT, node.get());
        }
        Some(heard)
    }

    /// Raises the error of a node whose heartbeat is overdue at `until`, and returns the node. Call it until `None`.
    pub fn poll_monitor(&mut self, until: Instant) -> Option<NodeId> {
        let missed = self.monitor.no_sooner().poll(until)?;
        self.raise(ErrorCode::HEARTBEAT, [missed.node.get(), 0, 0, 0, 0]);
        Some(missed.node)
    }

    /// Takes a new NMT state. A transfer ends without an abort if SDO is not allowed in it.
    pub fn entered(&mut self, state: NmtState, now: Instant) {
        self.emcy_mut();
        if !state.allows_sdo() {
            self.end_transfers();
        }
        if state.allows_pdo() {
            self.dictionary.tpdos_mut().start_timers(now);
            self.send_states(now);
        } else {
            self.dictionary.stop_pdos();
            E::on_pdos_stopped(&mut self.state);
            self.sync.open();
        }
    }

    /// Handles a SYNC. Returns its counter, zero if it has none.
    pub fn on_sync(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp) -> Result<u8, sync::UnexpectedLength> {
        if self.sync.is_plain(frame) { Ok(0) } else { self.on_special_sync(bus, frame, stamp) }
    }

    fn on_special_sync(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
    ) -> Result<u8, sync::UnexpectedLength> {
        let was_wrong = self.sync.is_wrong();
        let counter = self.sync.on_sync(frame, stamp.at);
        if was_wrong || counter.is_err() {
            self.set_error(ErrorCode::SYNC_LENGTH, 0, counter.is_err());
        }
        if counter.is_ok() {
            E::on_sync(self, bus, stamp);
        }
        counter
    }

    /// Notes when to poll next, after a run of the node. `state` decides about emergencies.
    pub fn settle(&mut self, state: NmtState) {
        let second = self.second_sdo_deadline();
        self.dictionary.settle(state);
        let wakes = self.dictionary.wakes_mut();
        self.monitor.settle(wakes);
        self.server.settle(wakes);
        self.buses.settle(wakes);
        wakes.note(second);
    }
}
