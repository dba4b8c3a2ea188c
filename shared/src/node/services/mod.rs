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
mod time;

use self::guarded::Guarded;
use super::buses::Buses;
use super::{Device, Extension, NodeObjects, Spacecraft};
use crate::emcy::{ErrorCode, PostMortem};
use crate::heartbeat::{ConsumerSlots, Monitor, monitored};
use crate::link::Stamp;
use crate::link::port::{ErrorState, Health, LastError};
use crate::node::save::SaveEnd;
use crate::node::stored::Storage;
use crate::node::{BusHealth, index};
use crate::od::CobIdEntry;
use crate::pdo::{PdoSlots, Taken};
use crate::profile::Profile;
use crate::store::ParameterStore;
use crate::types::{Address, Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, Sealed, earliest};
use crate::{sdo, sync};
pub use dictionary::Dictionary;
pub use events::NodeEvent;
pub use time::{MappedTime, carries_time};

/// Frames, sent and received on a bus, within which a node may have been the first one there.
const FIRST_FRAMES: u32 = 8;

/// First byte of a request that aborts a transfer.
const ABORT: u8 = 0x80;

/// First object whose changes are reported to the application. Objects below belong to the services.
pub const FIRST_REPORTED: u16 = index::REDUNDANCY;

/// Task of the SDO server.
pub enum SdoStep<'a> {
    /// Handle a frame for the server.
    Request(&'a Frame),
    /// End the transfer: the bus of its client was left.
    BusChanged,
    /// Check the deadline, or continue after one of its frames was sent.
    Poll,
}

/// Dictionary and services of a node. `E`: parts of the node beyond CANopen.
#[derive(Debug)]
pub struct Services<D: Device, E: Extension = Spacecraft> {
    id: NodeId,
    pub dictionary: Dictionary<D, E>,
    pub monitor: Monitor<D::Consumers>,
    sync: sync::Consumer,
    sync_id: Sealed,
    /// COB-ID of requests to the SDO server.
    sdo_id: Sealed,
    server: sdo::Server,
    pub time: E::Time,
    pub buses: Buses,
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
    /// Earliest instant at which something is due. It may be too early, never too late.
    pub next: Instant,
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
            monitor: Monitor::new(),
            sync: sync::Consumer::new(0, 0),
            sync_id: Sealed::of(CobId::SYNC),
            sdo_id: Sealed::of(CobId::sdo_request(id)),
            server: sdo::Server::new(profile.sdo_timeout),
            time: E::new_time(profile),
            buses: Buses::new(profile.access(id), profile.bus_off),
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
            next: Instant::ZERO,
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

    /// Returns whether this is the COB-ID of SDO requests.
    pub fn is_sdo(&self, id: CobId) -> bool {
        self.sdo_id.is(id)
    }

    /// Returns the COB-ID of SDO requests by the Node-ID.
    pub fn sdo_id(&self) -> CobId {
        CobId::sdo_request(self.id)
    }

    /// Returns the COB-ID of SYNC as it was just written.
    pub fn written_sync_id(&self) -> CobId {
        self.dictionary.objects.communication.sync.id()
    }

    /// Takes an error that appeared: history and register in the dictionary follow. Returns `false` if the error
    /// is active already.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) -> bool {
        let Dictionary { objects, emcy, .. } = &mut self.dictionary;
        let is_news = emcy.raise(code, info);
        if is_news {
            emcy.show(&mut objects.communication.emcy);
        }
        is_news
    }

    /// Notes that an error is gone.
    pub fn clear(&mut self, code: ErrorCode, source: u8) {
        self.clear_error(code, source);
    }

    /// An error is gone. Returns whether it was there.
    fn clear_error(&mut self, code: ErrorCode, source: u8) -> bool {
        let Dictionary { objects, emcy, .. } = &mut self.dictionary;
        let is_news = emcy.clear(code, source);
        if is_news {
            emcy.show(&mut objects.communication.emcy);
        }
        is_news
    }

    /// An error is there or not, with its source alone. Returns whether it has just appeared.
    fn set_error(&mut self, code: ErrorCode, source: u8, is_there: bool) -> bool {
        let is_news =
            if is_there { self.raise(code, [source, 0, 0, 0, 0]) } else { self.clear_error(code, source) };
        if is_news {
            self.next = Instant::ZERO;
        }
        is_news && is_there
    }

    /// Register and history in the dictionary follow.
    fn show_errors(&mut self) {
        let Dictionary { objects, emcy, .. } = &mut self.dictionary;
        emcy.show(&mut objects.communication.emcy);
    }

    /// Takes the error state and the counters of a controller.
    pub fn on_health(&mut self, bus: Bus, health: &Health) {
        let source = bus.bdefault();
        match health.state {
            ErrorState::Active => self.clear(ErrorCode::CAN_PASSIVE, source),
            ErrorState::Passive if self.is_first(bus, health) => {}
            ErrorState::Passive => {
                self.raise(ErrorCode::CAN_PASSIVE, [source, 0, 0, 0, 0]);
            }
            ErrorState::BusOff => {}
        }
        if self.buses.note_state(bus, health.state) {
            self.occurred(ErrorCode::BUS_OFF_RECOVERED, bus);
        }
    }

    /// Returns whether this node is error passive because it is the first one on its bus. That is no error: no
    /// other node was there yet to acknowledge its frames. The first frames that were acknowledged may be handled
    /// before the state that preceded them, and end its last error.
    fn is_first(&self, bus: Bus, health: &Health) -> bool {
        let counters = &self.buses.counters[bus];
        matches!(health.last_error, LastError::Ack | LastError::None)
            && counters.received.saturating_add(counters.sent) < FIRST_FRAMES
    }

    /// Reports an error of a bus that has already ended.
    pub fn occurred(&mut self, code: ErrorCode, bus: Bus) {
        self.report_past(code, [bus.bdefault(), 0, 0, 0, 0]);
    }

    /// Reports an error that has already ended.
    #[inline(never)] // of several callers, neither in a hurry
    fn report_past(&mut self, code: ErrorCode, info: [u8; 5]) {
        if self.dictionary.emcy.report(code, info) {
            self.show_errors();
            self.next = Instant::ZERO;
        }
    }

    /// Returns whether this is the COB-ID of the emergencies of this node.
    pub fn is_emergency(&self, id: CobId) -> bool {
        self.dictionary.emcy.id().is(id)
    }

    /// Takes the end of a frame of this node on its active bus: a node acknowledged it, or it was not sent. Then an
    /// emergency or a state is due again.
    pub fn on_frame_end(&mut self, frame: &Frame, is_acknowledged: bool, now: Instant) {
        let is_emergency = self.is_emergency(frame.id());
        if is_emergency || !is_acknowledged {
            let Dictionary { emcy, tpdos, .. } = &mut self.dictionary;
            if is_emergency {
                emcy.on_end(frame, is_acknowledged, now);
            } else {
                tpdos.on_failed(frame.id(), now);
            }
            self.next = now;
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
        self.dictionary.emcy.on_bus_changed();
        self.dictionary.tpdos.send_states(now);
        self.next = now;
    }

    /// Writes object 2032h. An emergency reports it after the boot-up message.
    pub fn set_post_mortem(&mut self, record: PostMortem) {
        if let Some(objects) = self.dictionary.objects.spacecraft.spacecraft() {
            objects.post_mortem.record = record;
            self.is_reset_due = true;
        }
    }

    /// Notes that a heartbeat or boot-up message was sent.
    #[inline]
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
        let of = |bus| BusHealth::new(&self.buses.health[bus], &self.buses.counters[bus]);
        let health = (of(Bus::Nominal), of(Bus::Redundant));
        if let Some(objects) = self.dictionary.objects.spacecraft.spacecraft() {
            (objects.health_nominal, objects.health_redundant) = health;
        }
    }

    /// Handles a segment of a block download that needs no object. Returns whether it was one.
    #[inline]
    pub fn on_plain_segment(&mut self, frame: &Frame, now: Instant) -> bool {
        let Self { dictionary, server, .. } = self;
        frame.full().is_some_and(|payload| server.on_plain_segment(payload, now, dictionary))
    }

    /// Runs the SDO server. Returns whether a frame was of use. Call it from one place, so that an image has its
    /// code once.
    #[inline(always)]
    pub fn serve(&mut self, step: SdoStep, now: Instant, send: &mut impl FnMut(Frame)) -> bool {
        let Some(response) = self.sdo_id.id().map(CobId::sdo_answer) else { return false };
        let Self { dictionary, server, .. } = self;
        dictionary.now = now;
        let mut send = move |payload| send(Frame::of(response, payload));
        match step {
            SdoStep::Request(frame) => {
                let Some(payload) = frame.full() else { return false };
                if payload[0] == ABORT
                    && let Some(save) = dictionary.stored.running()
                {
                    save.drop_answer();
                }
                return server.on_request(payload, now, dictionary, &mut send);
            }
            SdoStep::BusChanged => server.on_bus_changed(now, dictionary, &mut send),
            SdoStep::Poll => server.poll(now, dictionary, &mut send),
        }
        true
    }

    /// Returns the earlier one of `deadline` and the next slice of a running save, which a received frame does not run.
    pub fn with_save(&self, deadline: Option<Instant>) -> Option<Instant> {
        match self.dictionary.stored.deadline() {
            // Nearly always.
            None => deadline,
            slice => earliest(&[slice, deadline]),
        }
    }

    /// Continues a running save if that is due. At its end, returns the frame for the client that waits for it, and
    /// the object that was written if the save succeeded.
    pub fn advance_save(&mut self, now: Instant) -> Option<(Option<Frame>, Option<Address>)> {
        let SaveEnd { at, result, answer } = self.dictionary.advance_save(now)?;
        self.next = Instant::ZERO;
        let answer = answer.map(|answer| result.map_or_else(|code| sdo::abort(at, code), |()| answer));
        let id = self.sdo_id.id().map(CobId::sdo_answer);
        let frame = id.zip(answer).map(|(id, answer)| Frame::of(id, answer));
        Some((frame, result.is_ok().then_some(at)))
    }

    /// Returns whether the SDO server has a transfer.
    pub fn is_sdo_busy(&self) -> bool {
        self.server.is_busy()
    }

    /// Notes that a response of the SDO server was sent, or failed.
    pub fn on_sdo_sent(&mut self) {
        self.server.on_sent();
    }

    /// Takes a new NMT state. A transfer ends without an abort if SDO is not allowed in it.
    pub fn entered(&mut self, state: NmtState, now: Instant) {
        if !state.allows_sdo() {
            self.dictionary.stored.give_up();
            let Self { dictionary, server, .. } = self;
            server.reset(dictionary);
        }
        if state.allows_pdo() {
            self.dictionary.tpdos.start(now);
        } else {
            self.dictionary.tpdos.stop();
            self.dictionary.rpdos.stop();
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
        if counter.is_err() {
            self.raise(ErrorCode::SYNC_LENGTH, [0; 5]);
        } else if was_wrong {
            self.clear(ErrorCode::SYNC_LENGTH, 0);
        }
        if E::HAS_TIME && counter.is_ok() && self.notes_syncs {
            self.note_sync(bus, stamp);
        }
        if was_wrong || counter.is_err() {
            // An emergency is to go.
            self.next = Instant::ZERO;
        }
        counter
    }

    /// Synchronous TPDOs at a SYNC, sampled before RPDOs take effect.
    #[inline(always)] // called from one place
    fn sample(&mut self, counter: u8, send: &mut impl FnMut(Frame, bool) -> bool) {
        let Dictionary { objects, tpdos, .. } = &mut self.dictionary;
        tpdos.on_sync(counter, objects, &mut |_, frame, may_wait| send(frame, may_wait));
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
        rpdos.on_plain_frame(number, frame, objects)
    }

    /// A frame of an RPDO, in Operational. What becomes of it, and whether an emergency reports it.
    #[inline(always)] // called from one place
    fn on_rpdo(&mut self, number: usize, frame: &Frame, at: Instant) -> (Taken, bool) {
        let Dictionary { objects, rpdos, .. } = &mut self.dictionary;
        let taken = rpdos.on_frame(number, frame, at, self.sync.window_end(), objects);
        let is_told = rpdos.has_events();
        if is_told {
            self.dictionary.report_rpdos();
        }
        (taken, is_told)
    }

    /// Returns when the SDO server has something to do.
    pub fn sdo_deadline(&self) -> Option<Instant> {
        self.server.deadline()
    }

    /// Makes sure that the node runs at `deadline` at the latest.
    #[inline]
    pub fn wake(&mut self, deadline: Option<Instant>) {
        if let Some(deadline) = deadline {
            self.next = self.next.min(deadline);
        }
    }

    /// Returns when to poll next, including the SDO server.
    pub fn deadline(&self, state: NmtState) -> Option<Instant> {
        let Dictionary { emcy, rpdos, tpdos, .. } = &self.dictionary;
        let all = [emcy.deadline(state), rpdos.deadline(), tpdos.deadline(), self.server.deadline()];
        earliest(&all)
    }
}
