//! The CANopen device in a node: its object dictionary and the services that live on it.
//!
//! It knows neither buses nor redundancy: the node gives it frames of the active bus and the NMT state, and sends what it
//! hands out.

mod rules;
mod stored;
mod view;

use super::NodeObjects;
use crate::emcy::{self, ErrorCode};
use crate::heartbeat::Monitor;
use crate::link::{CobId, CobIdEntry, Frame};
use crate::nmt::{NmtState, NodeId};
use crate::od::communication::{Communication, Mapping};
use crate::od::{AbortCode, Address, Entry, Objects, Place};
use crate::pdo::{RpdoEvent, Rpdos, Tpdos};
use crate::store::Group;
use crate::time::{Duration, Instant};
use crate::{sdo, sync};
use stored::Stored;
use view::View;

/// Units of inhibit times, in microseconds.
const INHIBIT_UNIT: u64 = 100;

/// What a frame was to the RPDOs.
pub enum PdoOutcome {
    /// None of them, or one after the synchronous window.
    Ignored,
    /// One of them.
    Taken,
    /// One of them, and an emergency tells that something changed.
    Told,
    /// One of them, but not as it should be: told as an emergency.
    Erroneous,
}

/// What the SDO server is to do.
enum SdoStep<'a> {
    Request(&'a sdo::Payload),
    Abort(AbortCode),
    Poll,
}

/// Dictionary and services.
#[derive(Debug)]
pub struct Device<A: Objects + Default, const R: usize, const T: usize, M: Mapping> {
    id: NodeId,
    pub objects: NodeObjects<A, R, T, M>,
    pub emcy: emcy::Producer,
    pub monitor: Monitor,
    sync: sync::Consumer,
    sync_id: CobId,
    server: sdo::Server,
    rpdos: Rpdos<R>,
    tpdos: Tpdos<T>,
    pub stored: Stored,
    /// What was written last over the bus, and the node has not looked at yet.
    written: Option<Address>,
    /// Where the value is that was asked for last over the bus.
    found: Option<(Address, Place, &'static Entry)>,
}

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> Device<A, R, T, M> {
    pub fn new(id: NodeId, objects: NodeObjects<A, R, T, M>, sdo_timeout: Duration) -> Self {
        Device {
            id,
            objects,
            emcy: emcy::Producer::new(emcy::Config { id: None, inhibit: Duration::ZERO }),
            monitor: Monitor::new(),
            sync: sync::Consumer::new(0, 0),
            sync_id: CobId::SYNC,
            server: sdo::Server::new(sdo_timeout),
            rpdos: Rpdos::new(),
            tpdos: Tpdos::new(),
            stored: Stored(None),
            written: None,
            found: None,
        }
    }

    /// Takes all services' parameters from the dictionary, at power-on and when communication is reset.
    pub fn configure(&mut self, now: Instant) {
        let (server, mut view) = self.sdo(now);
        server.reset(&mut view);
        self.written = None;
        self.rpdos.stop();
        self.tpdos.stop();
        self.configure_sync();
        self.configure_emcy();
        for (sub, value) in (1..).zip(self.objects.communication.consumer_heartbeat) {
            self.monitor.set(sub, value);
        }
        let objects = &self.objects.communication;
        // What power-on makes of a PDO that cannot be: one that is not valid.
        for (number, (pdo, mapping)) in objects.rpdos.iter().zip(&objects.rpdo_mappings).enumerate() {
            let emcy = &mut self.emcy;
            let mut tell = |number, event| note(emcy, number, event);
            let mapping = mapping.objects();
            let _ = self.rpdos.configure::<NodeObjects<A, R, T, M>>(number, pdo, mapping, &mut tell);
        }
        for (number, (pdo, mapping)) in objects.tpdos.iter().zip(&objects.tpdo_mappings).enumerate() {
            let _ = self.tpdos.configure::<NodeObjects<A, R, T, M>>(number, pdo, mapping.objects(), now);
        }
        show(&self.emcy, &mut self.objects.communication);
    }

    /// The SDO server and what it sees.
    fn sdo(&mut self, now: Instant) -> (&mut sdo::Server, View<'_, A, R, T, M>) {
        let view = View {
            objects: &mut self.objects,
            rpdos: &mut self.rpdos,
            tpdos: &mut self.tpdos,
            emcy: &mut self.emcy,
            stored: &mut self.stored,
            id: self.id,
            written: &mut self.written,
            found: &mut self.found,
            now,
        };
        (&mut self.server, view)
    }

    /// Applies what is stored of a group; the services take it with [`Device::configure`].
    #[inline(never)] // of two callers, neither in a hurry
    pub fn load(&mut self, group: Group) {
        match self.stored.load(self.id, group, &mut self.objects) {
            Ok(_) => {}
            // Defaults hold, where nothing else was applied yet.
            Err(_) => self.raise(ErrorCode::DATA_SET, [0; 5]),
        }
    }

    fn configure_sync(&mut self) {
        let communication = &self.objects.communication;
        self.sync_id = CobIdEntry::from_raw(communication.sync_cob_id).id();
        self.sync.configure(communication.sync_overflow, communication.synchronous_window);
    }

    fn configure_emcy(&mut self) {
        let communication = &self.objects.communication;
        self.emcy.configure(emcy::Config {
            id: CobIdEntry::from_raw(communication.emcy_cob_id).cob_id(),
            inhibit: Duration::from_micros(u64::from(communication.emcy_inhibit) * INHIBIT_UNIT),
        });
    }

    /// COB-ID of each RPDO, valid or not.
    pub fn rpdo_ids(&self) -> impl Iterator<Item = Option<CobId>> {
        self.objects.communication.rpdos.iter().map(|pdo| CobIdEntry::from_raw(pdo.cob_id).cob_id())
    }

    /// COB-ID of SYNC.
    pub fn sync_id(&self) -> CobId {
        self.sync_id
    }

    /// COB-ID of SYNC as it was just written.
    pub fn written_sync_id(&self) -> CobId {
        CobIdEntry::from_raw(self.objects.communication.sync_cob_id).id()
    }

    /// An error appeared or is gone: history and register in the dictionary follow.
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) {
        if self.emcy.raise(code, info) {
            show(&self.emcy, &mut self.objects.communication);
        }
    }

    pub fn clear(&mut self, code: ErrorCode, source: u8) {
        if self.emcy.clear(code, source) {
            show(&self.emcy, &mut self.objects.communication);
        }
    }

    /// An SDO request. Whether it was of use.
    pub fn on_sdo(&mut self, frame: &Frame, now: Instant, send: &mut dyn FnMut(Frame)) -> bool {
        let Ok(payload) = <&sdo::Payload>::try_from(frame.data()) else { return false };
        self.serve(SdoStep::Request(payload), now, send)
    }

    /// A segment of a block download that needs no object. Whether it was one.
    #[inline]
    pub fn on_plain_segment(&mut self, frame: &Frame, now: Instant) -> bool {
        <&sdo::Payload>::try_from(frame.data())
            .is_ok_and(|payload| self.server.on_plain_segment(payload, now))
    }

    /// The one place where the server runs, so that images carry it once.
    fn serve(&mut self, step: SdoStep, now: Instant, send: &mut dyn FnMut(Frame)) -> bool {
        let response = CobId::sdo_response(self.id);
        let (server, mut view) = self.sdo(now);
        let mut send = |payload| send(Frame::of(response, payload));
        match step {
            SdoStep::Request(payload) => return server.on_request(payload, now, &mut view, &mut send),
            SdoStep::Abort(code) => server.abort(code, &mut view, &mut send),
            SdoStep::Poll => server.poll(now, &mut view, &mut send),
        }
        true
    }

    /// A response of the SDO server left, or failed to.
    pub fn on_sdo_sent(&mut self) {
        self.server.on_sent();
    }

    /// The bus that the client was heard on was left.
    pub fn abort_sdo(&mut self, code: AbortCode, now: Instant, send: &mut dyn FnMut(Frame)) {
        self.serve(SdoStep::Abort(code), now, send);
    }

    /// What was written last over the bus, once.
    pub fn take_written(&mut self) -> Option<Address> {
        self.written.take()
    }

    /// Follows what was written to an object of its services. Whether it was one.
    pub fn on_written(&mut self, at: Address) -> bool {
        if matches!(at.index, 0x1005..=0x1007 | 0x1014..=0x1017 | 0x1019 | 0x1029..=0x1BFF | 0x2000) {
            // CiA 301 7.5.2.18: it is no longer the configuration that was verified.
            self.objects.communication.configuration = [0; 2];
        }
        match at.index {
            0x1003 => {
                let _ = self.emcy.history_mut().write_len(0);
                show(&self.emcy, &mut self.objects.communication);
            }
            0x1005 | 0x1007 | 0x1019 => self.configure_sync(),
            0x1014 | 0x1015 => self.configure_emcy(),
            0x1016 => {
                let entry = usize::from(at.sub).wrapping_sub(1);
                let value = self.objects.communication.consumer_heartbeat.get(entry).copied();
                if let Some(missed) = self.monitor.set(at.sub, value.unwrap_or(0)) {
                    self.clear(ErrorCode::HEARTBEAT, missed.get());
                }
            }
            0x1000..=0x1FFF => {}
            _ => return false,
        }
        true
    }

    /// Another NMT state.
    pub fn entered(&mut self, state: NmtState, now: Instant) {
        if state.allows_pdo() {
            self.tpdos.start(now);
        } else {
            self.tpdos.stop();
            self.rpdos.stop();
        }
    }

    /// SYNC: its counter, zero when it has none.
    ///
    /// # Errors
    /// [`sync::UnexpectedLength`], which is told as an emergency.
    pub fn on_sync(&mut self, frame: &Frame, at: Instant) -> Result<u8, sync::UnexpectedLength> {
        let counter = self.sync.on_sync(frame, at);
        if counter.is_err() {
            self.raise(ErrorCode::SYNC_LENGTH, [0; 5]);
            self.clear(ErrorCode::SYNC_LENGTH, 0);
        }
        counter
    }

    /// Synchronous TPDOs at a SYNC, sampled before RPDOs take effect.
    #[inline(always)] // called from one place
    pub fn sample(&mut self, counter: u8, send: &mut impl FnMut(Frame)) {
        self.tpdos.on_sync(counter, &self.objects, &mut |_, frame| send(frame));
    }

    /// Synchronous RPDOs at a SYNC.
    #[inline(always)] // called from one place
    pub fn actuate(&mut self, applied: &mut impl FnMut(u16)) {
        let window_end = self.sync.window_end();
        let emcy = &mut self.emcy;
        self.rpdos.on_sync(window_end, &mut self.objects, &mut |objects, number, event| match event {
            RpdoEvent::Applied => applied(number as u16),
            event => tell(emcy, &mut objects.communication, number, event),
        });
    }

    /// A frame that may be an RPDO, in Operational.
    #[inline(always)] // called from one place
    pub fn on_rpdo(
        &mut self,
        frame: &Frame,
        at: Instant,
        applied: &mut impl FnMut(&NodeObjects<A, R, T, M>, u16),
    ) -> PdoOutcome {
        let emcy = &mut self.emcy;
        let mut outcome = PdoOutcome::Taken;
        let known =
            self.rpdos.on_frame(frame, at, &mut self.objects, &mut |objects, number, event| match event {
                RpdoEvent::Applied => applied(objects, number as u16),
                RpdoEvent::Rejected => outcome = PdoOutcome::Erroneous,
                RpdoEvent::OutsideWindow => outcome = PdoOutcome::Ignored,
                event => {
                    outcome = PdoOutcome::Told;
                    tell(emcy, &mut objects.communication, number, event);
                }
            });
        if known { outcome } else { PdoOutcome::Ignored }
    }

    /// When an RPDO is overdue.
    pub fn rpdo_deadline(&self) -> Option<Instant> {
        self.rpdos.deadline()
    }

    /// When the SDO server has something to do.
    pub fn sdo_deadline(&self) -> Option<Instant> {
        self.server.deadline()
    }

    /// An event of the application for a TPDO.
    pub fn trigger(&mut self, number: usize, now: Instant) {
        self.tpdos.trigger(number, now);
    }

    /// A value changed by a write over the bus: an event for all TPDOs that carry it. When one of them is due.
    pub fn on_changed(&mut self, at: Address, now: Instant) -> Option<Instant> {
        if let Some((_, place, _)) = self.found.filter(|(found, ..)| *found == at) {
            self.tpdos.on_changed(place, now);
        }
        self.tpdos.deadline()
    }

    /// What is due. Emergencies go first: their COB-ID wins.
    pub fn poll(&mut self, now: Instant, state: NmtState, send: &mut impl FnMut(Frame)) {
        let (emcy, communication) = (&mut self.emcy, &mut self.objects.communication);
        self.rpdos.poll(now, &mut |number, event| tell(emcy, communication, number, event));
        while let Some(frame) = self.emcy.poll(now, state) {
            send(frame);
        }
        self.tpdos.poll(now, &self.objects, &mut |_, frame| send(frame));
        if self.server.is_busy() {
            self.serve(SdoStep::Poll, now, send);
        }
    }

    /// When to poll next.
    pub fn deadline(&self, state: NmtState) -> Option<Instant> {
        let all =
            [self.emcy.deadline(state), self.rpdos.deadline(), self.tpdos.deadline(), self.server.deadline()];
        all.into_iter().flatten().min()
    }
}

/// An error of an RPDO appeared or is gone; it is known by the number of its PDO.
fn tell<const R: usize, const T: usize, M: Mapping>(
    emcy: &mut emcy::Producer,
    objects: &mut Communication<R, T, M>,
    number: usize,
    event: RpdoEvent,
) {
    note(emcy, number, event);
    show(emcy, objects);
}

/// As [`tell`], without the objects.
fn note(emcy: &mut emcy::Producer, number: usize, event: RpdoEvent) {
    let source = number as u8;
    match event {
        RpdoEvent::Error(error) => _ = emcy.raise(error.code(), [source, 0, 0, 0, 0]),
        RpdoEvent::Resolved(error) => _ = emcy.clear(error.code(), source),
        RpdoEvent::Applied | RpdoEvent::Rejected | RpdoEvent::OutsideWindow => {}
    }
}

/// Objects 1001h and 1003h follow.
fn show<const R: usize, const T: usize, M: Mapping>(
    emcy: &emcy::Producer,
    objects: &mut Communication<R, T, M>,
) {
    let history = emcy.history();
    objects.error_register = emcy.register().bits();
    objects.errors.count = history.len();
    for (slot, sub) in objects.errors.errors.iter_mut().zip(1..) {
        *slot = history.read(sub).unwrap_or(0);
    }
}
