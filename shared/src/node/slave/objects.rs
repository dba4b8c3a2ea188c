//! The dictionary of a slave at work: SDO, SYNC and PDOs, and what a written object means to the node.

use super::{FILTERS_OF_PEERS, FILTERS_OF_RPDOS, Out, SYNC_FILTER, Slave, mark};
use crate::emcy::ErrorCode;
use crate::heartbeat::MONITORED;
use crate::link::{Bus, CobId, Frame};
use crate::nmt::NodeId;
use crate::node::device::{FIRST_TOLD, SdoStep};
use crate::node::{NodeObjects, SlaveEvent};
use crate::od::communication::Mapping;
use crate::od::spacecraft::SelfTest;
use crate::od::{Address, Objects};
use crate::pdo::Taken;
use crate::redundancy::Parameters;
use crate::store::Group;
use crate::time::{Duration, Instant, Stamp};

/// Local SCET set.
const SCET_SET: u16 = 0x2010;
/// Local SCET get.
const SCET_GET: u16 = 0x2011;

/// The last object that a node follows.
const LAST_OWN: u16 = 0x2030;

/// Whether a request asks for a value of the moment: objects 2011h, 2020h and 2021h.
fn is_of_the_moment(frame: &Frame) -> bool {
    let index = (frame.bits() >> 8) as u16;
    matches!(index, SCET_GET | 0x2020 | 0x2021)
}

/// Whether a PDO carries an object, or a part of it.
fn maps(mapping: &impl Mapping, index: u16) -> bool {
    mapping.objects().iter().any(|object| object >> 16 == u32::from(index))
}

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> Slave<A, R, T, M> {
    /// The object dictionary.
    pub fn objects(&self) -> &NodeObjects<A, R, T, M> {
        &self.device.dictionary.objects
    }

    /// The object dictionary, to be changed. PDOs of what was changed are sent by [`Slave::send_pdo`] and
    /// [`Slave::changed`].
    pub fn objects_mut(&mut self) -> &mut NodeObjects<A, R, T, M> {
        &mut self.device.dictionary.objects
    }

    /// An event of the application: sends a transmit PDO (0 is the first) as its transmission type has it. Refused, and
    /// counted on the active bus, unless Operational.
    pub fn send_pdo(&mut self, number: usize, now: Instant) {
        if self.nmt.state().allows_pdo() {
            self.device.dictionary.tpdos.trigger(number, now);
            self.next = now;
        } else {
            self.buses.refused(self.selector.selected());
        }
    }

    /// The application changed a value: an event for all event-driven transmit PDOs that carry it.
    pub fn changed(&mut self, at: Address, now: Instant) {
        self.device.dictionary.on_changed(at, now);
        self.next = now;
    }

    /// An error of the device appeared: tells it, with five bytes of which the first is its source (ECSS 6.4).
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) {
        self.device.raise(code, info);
        self.next = Instant::ZERO;
    }

    /// An error of the device is gone.
    pub fn clear(&mut self, code: ErrorCode, source: u8) {
        self.device.clear(code, source);
        self.next = Instant::ZERO;
    }

    /// The communication profile as at power-on.
    pub(super) fn restore_communication(&mut self, now: Instant, out: &mut Out) {
        let before = self.filters();
        self.device.dictionary.objects.communication = (self.power_on)(self.id);
        self.device.dictionary.objects.set_heartbeats(&self.initial);
        self.device.load(Group::Communication);
        self.device.configure(now);
        let parameters = self.written_redundancy();
        self.selector.configure(parameters);
        self.heartbeat.set_period(parameters.producer, now);
        for (number, filter) in before.into_iter().enumerate() {
            self.admit(number, Some(filter), out);
        }
    }

    /// An SDO request on the active bus.
    #[inline(never)]
    pub(super) fn on_sdo(&mut self, frame: &Frame, now: Instant, out: &mut Out) {
        if !self.device.on_plain_segment(frame, now) {
            return self.on_request(frame, now, out);
        }
        // Its deadline has only moved away.
        self.run(now, now, out);
    }

    #[inline(never)] // a segment need not pay for it
    fn on_request(&mut self, frame: &Frame, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        if is_of_the_moment(frame) {
            self.refresh(now);
        }
        if !self.serve(SdoStep::Request(frame), bus, now, out) {
            self.buses.malformed(bus);
        }
        if let Some(at) = self.device.take_written() {
            self.on_written(at, now, out);
        }
        self.wake(self.device.sdo_deadline());
        self.run(now, now, out);
    }

    /// The SDO server runs; what it sends goes to `bus`.
    #[inline(never)] // of three callers
    pub(super) fn serve(&mut self, step: SdoStep, bus: Bus, now: Instant, out: &mut Out) -> bool {
        let expires = now + self.lifetimes.sdo;
        self.device.serve(step, now, &mut move |frame| out.send_until(bus, frame, expires))
    }

    /// A SYNC on the active bus.
    #[inline(never)]
    pub(super) fn on_sync(&mut self, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        if let Ok(counter) = self.device.on_sync(frame, stamp.at) {
            if self.nmt.state().allows_pdo() {
                self.exchange(counter, stamp, now, out);
            }
            out.event(SlaveEvent::Sync { bus, stamp: *stamp });
        } else {
            self.buses.malformed(bus);
            self.next = now;
        }
        self.run(now, now, out);
    }

    /// Synchronous PDOs.
    #[inline(always)] // called from one place
    fn exchange(&mut self, counter: u8, stamp: &Stamp, now: Instant, out: &mut Out) {
        if self.tells_time {
            // ECSS 7.2.3k: the local time at the end of the SYNC.
            self.device.dictionary.objects.spacecraft.scet_get = self.clock.at(stamp.at).into();
        }
        // CiA 301 7.5.2.6: what has not left at the end of the window is discarded.
        let expires = (now + self.lifetimes.synchronous).min(self.device.window_end());
        let bus = self.selector.selected();
        self.device.sample(counter, &mut |frame| out.send_until(bus, frame, expires));
        if self.device.is_rpdo_waiting() {
            self.actuate(now, out);
        }
    }

    #[inline(never)] // few SYNCs find any
    fn actuate(&mut self, now: Instant, out: &mut Out) {
        let applied = &mut |number| out.event(SlaveEvent::Synchronised { number: number as u16 });
        if self.device.actuate(applied) {
            self.next = now;
        }
    }

    /// A frame on the active bus, in Operational, that may be of RPDOs.
    #[inline(never)]
    pub(super) fn on_pdo(&mut self, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let mut number = self.device.rpdo(frame.id());
        if number.is_none() {
            return self.on_network(bus, frame, stamp, now, out);
        }
        while let Some(found) = number {
            if self.device.on_plain_rpdo(found, frame) && self.brings_time.get(found) == Some(&false) {
                out.event(SlaveEvent::Pdo { bus, number: found as u16, data: frame.padded() });
            } else {
                self.on_special_pdo(found, frame, stamp, now, out);
            }
            number = self.device.next_rpdo(frame.id(), found);
        }
        self.run(now, now, out);
    }

    /// A frame of an RPDO that is synchronous, has a deadline, brings the time, or is not as it should be.
    #[inline(never)]
    fn on_special_pdo(&mut self, number: usize, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let (taken, is_told) = self.device.on_rpdo(number, frame, stamp.at);
        match taken {
            Taken::Applied if self.brings_time.get(number) == Some(&true) => {
                let scet = self.device.dictionary.objects.spacecraft.scet_set.into();
                self.clock.set(scet, stamp.at);
                out.event(SlaveEvent::Time(scet));
            }
            Taken::Applied => {
                out.event(SlaveEvent::Pdo { bus, number: number as u16, data: frame.padded() });
            }
            Taken::Held => {}
            Taken::OutsideWindow => self.buses.ignored(bus),
            Taken::Rejected => self.buses.malformed(bus),
        }
        if is_told {
            self.next = now;
        }
        self.wake(self.device.rpdo_deadline());
    }

    /// An object was written over the bus: what depends on it follows.
    fn on_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        if at.index <= LAST_OWN {
            self.on_own_written(at, now, out);
        }
        if at.index >= FIRST_TOLD {
            if self.device.dictionary.tpdos.has_events() {
                self.device.dictionary.on_changed(at, now);
                self.wake(self.device.dictionary.tpdos.deadline());
            }
            out.event(SlaveEvent::Written(at));
        }
    }

    /// An object was written that the node itself follows.
    #[inline(never)] // those of the application need not pay for it
    fn on_own_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        let objects = &self.device.dictionary.objects;
        match at.index {
            0x1016 => {
                self.on_redundancy_written(at, now);
                self.admit(FILTERS_OF_PEERS + usize::from(at.sub.saturating_sub(1)), None, out);
            }
            0x1017 | 0x2000 => self.on_redundancy_written(at, now),
            SCET_SET => {
                self.clock.set(objects.spacecraft.scet_set.into(), now);
                out.event(SlaveEvent::Time(self.clock.at(now)));
            }
            0x2030 => {
                self.device.dictionary.objects.spacecraft.self_test =
                    SelfTest { progress: SelfTest::RUNNING, failures: 0 };
                out.event(SlaveEvent::SelfTest);
            }
            0x1005 => self.admit(SYNC_FILTER, None, out),
            0x1400..=0x15FF => self.admit(FILTERS_OF_RPDOS + usize::from(at.index & 0x1FF), None, out),
            _ => {}
        }
        if at.index < FIRST_TOLD || at.index == 0x2000 {
            self.device.on_written(at);
            self.set_marks();
            self.next = now;
        }
    }

    /// Which frames are taken, and which bring the time.
    pub(super) fn set_marks(&mut self) {
        let mappings = &self.device.dictionary.objects.communication.rpdo_mappings;
        for (brings_time, mapping) in self.brings_time.iter_mut().zip(mappings) {
            *brings_time = maps(mapping, SCET_SET);
        }
        let mappings = &self.device.dictionary.objects.communication.tpdo_mappings;
        self.tells_time = mappings.iter().any(|mapping| maps(mapping, SCET_GET));
        let fixed = [
            CobId::NMT,
            self.device.sync_id(),
            CobId::sdo_request(self.id),
            CobId::heartbeat(NodeId::MASTER),
        ];
        let peers = (0..MONITORED).filter_map(|entry| self.device.monitored(entry));
        let all = fixed.into_iter().chain(self.device.rpdo_ids().flatten()).chain(peers);
        self.marks = all.fold(0, |marks, id| marks | mark(id));
    }

    /// Objects 1016h, 1017h and 2000h (ECSS Tables 8-1, 8-2).
    fn on_redundancy_written(&mut self, at: Address, now: Instant) {
        let parameters = self.written_redundancy();
        self.selector.configure(parameters);
        if at.index == 0x1017 {
            self.heartbeat.set_period(parameters.producer, now);
        }
    }

    /// The redundancy parameters as the dictionary has them.
    pub(super) fn written_redundancy(&self) -> Parameters {
        let objects = &self.device.dictionary.objects;
        let written = &objects.spacecraft.redundancy;
        let of_master = |entry: &&u32| **entry >> 16 == u32::from(NodeId::MASTER.get());
        let consumer = objects.communication.consumer_heartbeat.iter().find(of_master);
        Parameters {
            consumer: consumer
                .map_or(Duration::ZERO, |entry| Duration::from_millis(u64::from(entry & 0xFFFF))),
            producer: Duration::from_millis(u64::from(objects.communication.producer_heartbeat)),
            bdefault: Bus::from_bdefault(written.bdefault).unwrap_or(Bus::Nominal),
            ttoggle: written.ttoggle,
            ntoggle: written.ntoggle,
            ctoggle: written.ctoggle,
        }
    }

    pub(super) fn run_device(&mut self, until: Instant, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let lifetime = self.lifetimes.event;
        self.device.poll(until, self.nmt.state(), &mut |frame| out.send_for(bus, frame, now, lifetime));
        if self.device.is_sdo_busy() {
            self.serve(SdoStep::Poll, bus, until, out);
        }
    }
}
