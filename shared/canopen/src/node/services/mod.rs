//! CANopen device in a node: its object dictionary and the services that use it.
//!
//! It knows neither buses nor redundancy. The node passes it frames of the active bus and the NMT state, and sends
//! the frames that it returns.

mod dictionary;
mod extension;
mod follow;
mod guarded;
mod objects;
mod pdos;
mod process_data;
mod rules;
mod sdo;
mod second_sdo;
mod sharing;

use self::guarded::Guarded;
use self::second_sdo::SecondServer;
use super::buses::Buses;
use super::counters::BusCounters;
use super::device::has_states;
use super::turn::{Timed, Wakes};
use super::{Device, Settings};
use crate::emcy::ErrorCode;
use crate::heartbeat::{ConsumerSlots, Monitor, monitored};
use crate::link::Stamp;
use crate::link::port::{ErrorState, Health, LastError};
use crate::node::index;
use crate::node::storage::Storage;
use crate::od::CobIdEntry;
use crate::pdo::{PdoSlots, Taken};
use crate::sdo::{SdoServers, Server};
use crate::sync;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, Sealed};
pub use dictionary::Dictionary;
pub use extension::{CanopenOnly, Extension};
pub use objects::{NodeObjects, assert_device, assert_objects};
pub use sdo::SdoStep;

/// Frames, sent and received on a bus, within which a node may have been the first one there.
const FIRST_FRAMES: u32 = 8;

/// First object whose changes are reported to the application. Objects below belong to the services.
pub const FIRST_REPORTED: u16 = index::LAST_COMMUNICATION + 1;

/// Dictionary and services of a node. `E`: parts of the node beyond CANopen.
#[derive(Debug)]
pub struct Services<D: Device, E: Extension<D>> {
    id: NodeId,
    /// Objects, and the services that a write changes at once.
    pub dictionary: Dictionary<D, E>,
    /// Consumer of heartbeats.
    pub monitor: Timed<Monitor<D::Consumers>>,
    sync: sync::Consumer,
    sync_id: Sealed,
    /// COB-ID of requests to the SDO server.
    sdo_id: Sealed,
    server: Timed<Server>,
    /// Second SDO server, if the device has one.
    second_sdo: <D::Sdo as SdoServers>::Second<SecondServer>,
    /// State of the parts beyond CANopen.
    pub state: E::State,
    /// Buses of the node.
    pub buses: Timed<Buses>,
    /// Counters of the frames of each bus.
    pub counters: BusCounters,
    /// Lifetimes of frames that wait for their bus.
    pub lifetimes: Lifetimes,
    /// Second copies of its COB-IDs.
    guarded: Guarded<D::Pdos>,
    /// Lifetime of a synchronous PDO.
    synchronous_lifetime: Duration,
    /// Instant before which nothing is due.
    pub wakes: Wakes,
}

/// Lifetimes of frames that wait for their bus.
#[derive(Clone, Copy, Debug)]
pub struct Lifetimes {
    /// Lifetime of a heartbeat.
    pub heartbeat: Duration,
    /// Lifetime of SYNC and of the PDOs that follow it.
    pub(crate) synchronous: Duration,
    /// Lifetime of an event-driven PDO.
    pub event: Duration,
    /// Lifetime of an SDO response.
    pub sdo: Duration,
}

impl<D: Device, E: Extension<D>> Services<D, E> {
    /// Makes the services. `objects` makes the dictionary in its place.
    #[inline(never)] // made in their place
    pub fn new(
        id: NodeId,
        objects: impl FnOnce() -> NodeObjects<D, E>,
        stored: E::Storage,
        settings: &Settings,
        state: impl FnOnce() -> E::State,
    ) -> Self {
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
            counters: BusCounters::default(),
            lifetimes: Lifetimes {
                heartbeat: settings.heartbeats.producer,
                synchronous: settings.sync.min(settings.heartbeats.producer),
                event: settings.event,
                sdo: settings.sdo_timeout,
            },
            guarded: Guarded::new(),
            synchronous_lifetime: settings.sync.min(settings.heartbeats.producer),
            wakes: Wakes::at_once(),
            // Last: then the compiler makes it in its place.
            dictionary: Dictionary::new(id, objects, stored),
        }
    }

    /// Returns the Node-ID.
    pub const fn id(&self) -> NodeId {
        self.id
    }

    /// Returns the COB-ID of an RPDO, if it is valid.
    pub(crate) fn rpdo_id(&self, number: usize) -> Option<CobId> {
        let pdo = self.dictionary.objects.pdos.rpdos().0.get(number)?;
        CobIdEntry::from_raw(pdo.cob_id).cob_id()
    }

    /// Returns the COB-IDs of all valid RPDOs.
    pub fn rpdo_ids(&self) -> impl Iterator<Item = CobId> {
        (0..D::Pdos::RECEIVE).filter_map(|number| self.rpdo_id(number))
    }

    /// Returns the number of entries of 1016h.
    pub(crate) fn consumers(&self) -> usize {
        self.dictionary.objects.consumers.entries().len()
    }

    /// Returns the COB-ID of the heartbeat that an entry of 1016h consumes, if the entry is in use.
    pub(crate) fn consumed(&self, entry: usize) -> Option<CobId> {
        let entry = self.dictionary.objects.consumers.entries().get(entry)?;
        monitored(*entry).map(CobId::heartbeat)
    }

    /// Returns whether this is the COB-ID of SYNC.
    pub fn is_sync(&self, id: CobId) -> bool {
        self.sync_id.is(id)
    }

    /// Returns the COB-ID of SYNC as it was just written.
    pub fn written_sync_id(&self) -> CobId {
        self.dictionary.objects.communication.sync.id()
    }

    /// Takes an error that appeared: history and register in the dictionary follow. Returns `false` if the error
    /// is active already.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) -> bool {
        let is_news = self.dictionary.emcy.step(&mut self.wakes, |emcy| emcy.raise(code, info));
        if is_news {
            self.dictionary.show_errors();
        }
        is_news
    }

    /// Notes that an error is gone. Returns whether it was there.
    pub fn clear(&mut self, code: ErrorCode, source: u8) -> bool {
        self.dictionary.clear(code, source, &mut self.wakes)
    }

    /// An error is there or not, with its source alone. Returns whether it has just appeared.
    pub fn set_error(&mut self, code: ErrorCode, source: u8, is_there: bool) -> bool {
        if !is_there {
            self.clear(code, source);
            return false;
        }
        self.raise(code, [source, 0, 0, 0, 0])
    }

    /// The NMT state may allow emergencies from now on.
    pub fn allow_emergencies(&mut self) {
        self.dictionary.emcy.change(&mut self.wakes);
    }

    /// Takes the error state and the counters of a controller.
    pub fn on_health(&mut self, bus: Bus, health: &Health) {
        let is_passive = match health.state {
            ErrorState::Active => Some(false),
            ErrorState::Passive => (!self.is_first(bus, health)).then_some(true),
            ErrorState::BusOff => None,
        };
        if let Some(is_passive) = is_passive {
            self.set_error(ErrorCode::CAN_PASSIVE, bus.bdefault(), is_passive);
        }
        if self.buses.no_sooner().note_state(bus, health.state) {
            self.occurred(ErrorCode::BUS_OFF_RECOVERED, bus);
        }
    }

    /// Returns whether this node is error passive because it is the first one on its bus. That is no error: no
    /// other node was there yet to acknowledge its frames. The first frames that were acknowledged may be handled
    /// before the state that preceded them, and end its last error.
    fn is_first(&self, bus: Bus, health: &Health) -> bool {
        let counters = &self.counters.all()[bus];
        matches!(health.last_error, LastError::Ack | LastError::None)
            && counters.received.saturating_add(counters.sent) < FIRST_FRAMES
    }

    /// Reports an error of a bus that has already ended.
    pub fn occurred(&mut self, code: ErrorCode, bus: Bus) {
        self.report_past(code, [bus.bdefault(), 0, 0, 0, 0]);
    }

    /// Reports an error that has already ended.
    #[inline(never)] // row `size.pyboard-v11.slave.flash`
    pub fn report_past(&mut self, code: ErrorCode, info: [u8; 5]) {
        if self.dictionary.emcy.step(&mut self.wakes, |emcy| emcy.report(code, info)) {
            self.dictionary.show_errors();
        }
    }

    /// Returns whether this is the COB-ID of the emergencies of this node.
    pub fn is_emergency(&self, id: CobId) -> bool {
        self.dictionary.emcy.id().is(id)
    }

    /// Takes the end of a frame of this node on its active bus: a node acknowledged it, or it was not sent. Then an
    /// emergency or a state is due again.
    pub fn on_frame_end(&mut self, frame: &Frame, is_acknowledged: bool, now: Instant) {
        let Dictionary { emcy, tpdos, .. } = &mut self.dictionary;
        if emcy.id().is(frame.id()) {
            emcy.change(&mut self.wakes).on_end(frame, is_acknowledged, now);
        } else if const { has_states::<D>() } && !is_acknowledged {
            tpdos.change(&mut self.wakes).on_failed(frame.id(), now);
        }
    }

    /// Returns whether a transmit PDO has this COB-ID.
    pub fn is_tpdo(&self, id: CobId) -> bool {
        self.dictionary.tpdos.has(id)
    }

    /// Returns whether a frame that was not sent is an event which no later frame replaces.
    pub fn is_lost_event(&self, frame: &Frame) -> bool {
        self.dictionary.tpdos.is_event(frame.id())
    }

    /// The active bus changed, or another master is there: what may not have been heard is announced again.
    #[inline(never)] // seldom
    pub fn announce(&mut self, now: Instant) {
        self.dictionary.emcy.change(&mut self.wakes).on_bus_changed();
        self.send_states(now);
    }

    /// Shows error states and counters of the buses, where objects have them.
    pub fn refresh_health(&mut self) {
        self.dictionary.objects.extension.show_health(&self.buses.health, self.counters.all());
    }

    /// Takes a new NMT state. A transfer ends without an abort if SDO is not allowed in it.
    pub fn entered(&mut self, state: NmtState, now: Instant) {
        self.allow_emergencies();
        if !state.allows_sdo() {
            self.dictionary.stored.give_up();
            self.reset_servers();
        }
        if state.allows_pdo() {
            self.dictionary.tpdos.change(&mut self.wakes).start_timers(now);
            self.send_states(now);
        } else {
            self.dictionary.tpdos.no_sooner().stop();
            self.dictionary.rpdos.no_sooner().stop();
            E::on_pdos_stopped(&mut self.state);
            self.sync.open();
        }
    }

    /// Handles a SYNC. Returns its counter, zero if it has none.
    #[inline(always)] // called from one place
    pub fn on_sync(&mut self, bus: Bus, frame: &Frame, stamp: &Stamp) -> Result<u8, sync::UnexpectedLength> {
        if self.sync.is_plain(frame) { Ok(0) } else { self.on_special_sync(bus, frame, stamp) }
    }

    #[inline(never)]
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

    /// Synchronous TPDOs at a SYNC, sampled before RPDOs take effect.
    #[inline(always)] // called from one place
    fn sample(&mut self, counter: u8, send: &mut impl FnMut(Frame, bool) -> bool) {
        let Dictionary { objects, tpdos, .. } = &mut self.dictionary;
        tpdos.no_sooner().on_sync(counter, objects, &mut |_, frame, may_wait| send(frame, may_wait));
    }

    /// Returns whether RPDOs wait for a SYNC.
    fn is_rpdo_waiting(&self) -> bool {
        self.dictionary.rpdos.is_waiting()
    }

    /// Until when synchronous PDOs of the last SYNC may go out or come in.
    fn window_end(&self) -> Instant {
        self.sync.window_end()
    }

    /// A frame of an RPDO as nearly all are, in Operational: it takes effect at once and is as it should be. Whether it
    /// was one; if not, [`Services::on_rpdo`] takes it.
    #[inline(always)] // called from one place
    fn on_plain_rpdo(&mut self, number: usize, frame: &Frame) -> bool {
        let Dictionary { objects, rpdos, .. } = &mut self.dictionary;
        rpdos.no_sooner().on_plain_frame(number, frame, objects)
    }

    /// A frame of an RPDO, in Operational. What becomes of it.
    #[inline(always)] // called from one place
    fn on_rpdo(&mut self, number: usize, frame: &Frame, at: Instant) -> Taken {
        let Dictionary { objects, rpdos, .. } = &mut self.dictionary;
        let end = self.sync.window_end();
        let taken = rpdos.step(&mut self.wakes, |rpdos| rpdos.on_frame(number, frame, at, end, objects));
        if rpdos.has_events() {
            self.dictionary.report_rpdos(&mut self.wakes);
        }
        taken
    }

    /// Notes when to poll next, including the SDO servers.
    pub fn settle(&self, state: NmtState, wakes: &mut Wakes) {
        let Dictionary { emcy, rpdos, tpdos, .. } = &self.dictionary;
        wakes.note(emcy.deadline(state));
        rpdos.settle(wakes);
        tpdos.settle(wakes);
        self.monitor.settle(wakes);
        self.server.settle(wakes);
        wakes.note(self.second_sdo_deadline());
    }
}
