//! CANopen device in a node: its object dictionary and the services that use it.
//!
//! It knows neither buses nor redundancy. The node passes it frames of the active bus and the NMT state, and sends
//! the frames that it returns.

mod dictionary;
mod events;
mod follow;
mod guarded;
mod over_budget;
mod pdos;
mod process_data;
mod redundancy;
mod rules;
mod sdo;
mod second_sdo;
mod sharing;
mod time;

use self::guarded::Guarded;
use self::second_sdo::SecondServer;
use super::buses::Buses;
use super::counters::BusCounters;
use super::turn::{Part, Timed, Wakes};
use super::{Device, Extension, NodeObjects, Spacecraft};
use crate::emcy::{ErrorCode, PostMortem};
use crate::heartbeat::{ConsumerSlots, Monitor, monitored};
use crate::link::Stamp;
use crate::link::port::{ErrorState, Health, LastError};
use crate::node::stored::Storage;
use crate::node::{BusHealth, index};
use crate::od::CobIdEntry;
use crate::pdo::{PdoSlots, Taken};
use crate::profile::Profile;
use crate::sdo::{SdoServers, Server};
use crate::store::ParameterStore;
use crate::sync;
use crate::types::{Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, Sealed, earliest};
pub use dictionary::Dictionary;
pub use events::NodeEvent;
pub use sdo::SdoStep;
pub use time::{MappedTime, carries_time};

/// Frames, sent and received on a bus, within which a node may have been the first one there.
const FIRST_FRAMES: u32 = 8;

/// First object whose changes are reported to the application. Objects below belong to the services.
pub const FIRST_REPORTED: u16 = index::REDUNDANCY;

/// Dictionary and services of a node. `E`: parts of the node beyond CANopen.
#[derive(Debug)]
pub struct Services<D: Device, E: Extension = Spacecraft> {
    id: NodeId,
    pub dictionary: Dictionary<D, E>,
    pub monitor: Timed<Monitor<D::Consumers>>,
    sync: sync::Consumer,
    sync_id: Sealed,
    /// COB-ID of requests to the SDO server.
    sdo_id: Sealed,
    server: Timed<Server>,
    /// Second SDO server, if the device has one.
    second_sdo: <D::Sdo as SdoServers>::Second<SecondServer>,
    pub time: E::Time,
    pub buses: Timed<Buses>,
    pub counters: BusCounters,
    pub lifetimes: Lifetimes,
    /// Second copies of its COB-IDs.
    guarded: Guarded<D::Pdos>,
    /// The time that each receive PDO carries (2010h, 2012h).
    mapped_time: <D::Pdos as PdoSlots>::Receive<MappedTime>,
    /// `true`: one of them carries the time of the last SYNC.
    is_time_by_sync: bool,
    /// Transmit PDOs that carry the local time (2011h, 2013h).
    carries_time: <D::Pdos as PdoSlots>::Transmit<bool>,
    /// `true`: a transmit PDO carries a live value: the local time, 2015h, 2020h, 2021h.
    carries_live_value: bool,
    /// `true`: a transmit PDO carries 2015h, which takes a thousand instructions.
    carries_quality: bool,
    /// `true`: the time of SYNCs is needed, for a live value or for a time that a PDO brings.
    notes_syncs: bool,
    /// Lifetime of a synchronous PDO.
    synchronous_lifetime: Duration,
    /// The last reset is reported when the boot-up message was sent.
    is_reset_due: bool,
    pub wakes: Wakes,
}

/// Lifetimes of frames that wait for their bus.
#[derive(Clone, Copy, Debug)]
pub struct Lifetimes {
    pub heartbeat: Duration,
    pub synchronous: Duration,
    pub event: Duration,
    pub sdo: Duration,
}

impl<D: Device, E: Extension> Services<D, E> {
    /// Makes the services. `objects` makes the dictionary in its place.
    #[inline(never)] // made in their place
    pub fn new(
        id: NodeId,
        objects: impl FnOnce() -> NodeObjects<D, E>,
        profile: &Profile,
        store: Option<&'static mut (dyn ParameterStore + Send)>,
    ) -> Self {
        Services {
            id,
            monitor: Timed::new(Monitor::new()),
            sync: sync::Consumer::new(0, 0),
            sync_id: Sealed::of(CobId::SYNC),
            sdo_id: Sealed::of(CobId::sdo_request(id)),
            server: Timed::new(Server::new(profile.sdo_timeout)),
            second_sdo: D::Sdo::second(|| SecondServer::new(profile.sdo_timeout)),
            time: E::new_time(profile),
            buses: Timed::new(Buses::new(profile.access(id), profile.bus_off)),
            counters: BusCounters::default(),
            lifetimes: Lifetimes {
                heartbeat: profile.heartbeat,
                synchronous: profile.sync.min(profile.heartbeat),
                event: profile.event,
                sdo: profile.sdo_timeout,
            },
            guarded: Guarded::new(),
            mapped_time: D::Pdos::receive(MappedTime::None),
            is_time_by_sync: false,
            carries_time: D::Pdos::transmit(false),
            carries_live_value: false,
            carries_quality: false,
            notes_syncs: false,
            synchronous_lifetime: profile.sync.min(profile.heartbeat),
            is_reset_due: false,
            wakes: Wakes::at_once(),
            // Last: then the compiler makes it in its place.
            dictionary: Dictionary::new(id, objects, store),
        }
    }

    /// Returns the COB-ID of an RPDO, if it is valid.
    pub fn rpdo_id(&self, number: usize) -> Option<CobId> {
        let pdo = self.dictionary.objects.pdos.rpdos().0.get(number)?;
        CobIdEntry::from_raw(pdo.cob_id).cob_id()
    }

    /// Returns the COB-IDs of all valid RPDOs.
    pub fn rpdo_ids(&self) -> impl Iterator<Item = CobId> {
        (0..D::Pdos::RECEIVE).filter_map(|number| self.rpdo_id(number))
    }

    /// Returns the number of entries of 1016h.
    pub fn consumers(&self) -> usize {
        self.dictionary.objects.consumers.entries().len()
    }

    /// Returns the COB-ID of the heartbeat that an entry of 1016h consumes, if the entry is in use.
    pub fn consumed(&self, entry: usize) -> Option<CobId> {
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
    fn set_error(&mut self, code: ErrorCode, source: u8, is_there: bool) -> bool {
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
    fn report_past(&mut self, code: ErrorCode, info: [u8; 5]) {
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
        } else if !is_acknowledged {
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
        self.dictionary.tpdos.change(&mut self.wakes).send_states(now);
    }

    /// Writes object 2032h. An emergency reports it after the boot-up message.
    pub fn set_post_mortem(&mut self, record: PostMortem) {
        if let Some(objects) = self.dictionary.objects.spacecraft.spacecraft() {
            objects.post_mortem.record = record;
            self.is_reset_due = true;
        }
    }

    /// Notes that a heartbeat or boot-up message was sent.
    pub fn on_heartbeat_sent(&mut self) {
        if core::mem::take(&mut self.is_reset_due) {
            self.report_reset();
        }
    }

    #[inline(never)] // once
    fn report_reset(&mut self) {
        let objects = self.dictionary.objects.spacecraft.spacecraft();
        if let Some((code, info)) = objects.and_then(|objects| objects.post_mortem.record.emergency()) {
            self.report_past(code, info);
        }
    }

    /// Updates objects 2020h and 2021h.
    pub fn refresh_health(&mut self) {
        let of = |bus| BusHealth::new(&self.buses.health[bus], &self.counters.all()[bus]);
        let health = (of(Bus::Nominal), of(Bus::Redundant));
        if let Some(objects) = self.dictionary.objects.spacecraft.spacecraft() {
            (objects.health_nominal, objects.health_redundant) = health;
        }
    }

    /// Takes a new NMT state. A transfer ends without an abort if SDO is not allowed in it.
    pub fn entered(&mut self, state: NmtState, now: Instant) {
        self.allow_emergencies();
        if !state.allows_sdo() {
            self.dictionary.stored.give_up();
            self.reset_servers();
        }
        if state.allows_pdo() {
            self.dictionary.tpdos.change(&mut self.wakes).start(now);
        } else {
            self.dictionary.tpdos.no_sooner().stop();
            self.dictionary.rpdos.no_sooner().stop();
            if let Some(time) = E::time(&mut self.time) {
                time.stop();
            }
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
        if E::HAS_TIME && counter.is_ok() && self.notes_syncs {
            self.note_sync(bus, stamp);
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

    /// Returns when to poll next, including the SDO servers.
    pub fn deadline(&self, state: NmtState) -> Option<Instant> {
        let Dictionary { emcy, rpdos, tpdos, .. } = &self.dictionary;
        let all = [emcy.deadline(state), rpdos.deadline(), tpdos.deadline(), self.server.deadline()];
        match self.second_sdo_deadline() {
            None => earliest(&all),
            second => earliest(&[second, earliest(&all)]),
        }
    }
}

impl<S: ConsumerSlots> Part for Monitor<S> {
    fn earliest(&self) -> Option<Instant> {
        self.deadline()
    }
}
