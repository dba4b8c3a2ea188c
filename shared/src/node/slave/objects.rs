//! The dictionary of a slave at work: SDO, SYNC and PDOs, and what a written object means to the node.

use super::{FILTERS_OF_PEERS, Out, SYNC_FILTER, Slave, mark};
use crate::emcy::ErrorCode;
use crate::heartbeat::ConsumerSlots;
use crate::link::Stamp;
use crate::nmt::NmtStartup;
use crate::node::index::{
    CONSUMER_HEARTBEAT, HEALTH_NOMINAL, HEALTH_REDUNDANT, LAST_RPDO_MAPPING, PRODUCER_HEARTBEAT, REDUNDANCY,
    RESTORE, RPDO, SCET_GET, SCET_SET, SELF_TEST_START, STORE, SYNC_COB_ID,
};
use crate::node::services::{FIRST_TOLD, SdoStep};
use crate::node::{Device, NodeObjects, SelfTest, SlaveEvent};
use crate::pdo::{Mapping, PdoSlots, Taken};
use crate::redundancy::Parameters;
use crate::store::Group;
use crate::types::{Address, Bus, CobId, Duration, Frame, Instant, NodeId};

/// The last object that a node follows.
const LAST_OWN: u16 = SELF_TEST_START;

/// Whether an object has a value of the moment: local time, health of the buses.
fn is_of_the_moment(index: u16) -> bool {
    matches!(index, SCET_GET | HEALTH_NOMINAL | HEALTH_REDUNDANT)
}

impl<D: Device> Slave<D> {
    /// The object dictionary.
    pub fn objects(&self) -> &NodeObjects<D> {
        &self.services.dictionary.objects
    }

    /// The object dictionary alone, for a data sheet.
    pub fn into_objects(self) -> NodeObjects<D> {
        self.services.dictionary.objects
    }

    /// The object dictionary, to be changed; tell by [`Slave::changed`] what was.
    pub fn objects_mut(&mut self) -> &mut NodeObjects<D> {
        &mut self.services.dictionary.objects
    }

    /// An event of the application: sends a transmit PDO (0 is the first) as its transmission type has it. Refused, and
    /// counted on the active bus, unless Operational and the PDO is valid.
    pub fn send_pdo(&mut self, number: usize, now: Instant) {
        if self.nmt.state().allows_pdo() && self.services.dictionary.tpdos.is_valid(number) {
            self.services.dictionary.tpdos.trigger(number, now);
            self.next = now;
        } else {
            self.buses.refused(self.selector.selected());
        }
    }

    /// The application changed a value: an event for all event-driven transmit PDOs that carry it. What the node itself
    /// follows (services, redundancy, clock) takes effect as if it had been written over the bus; its rules are for
    /// clients, not for the application. But a PDO that cannot be gets bit 31 of its COB-ID set (not valid) and an emergency
    /// (6300h); mend it, clear the bit, and report that change.
    pub fn changed(&mut self, at: Address, now: Instant) {
        if at.index <= LAST_OWN {
            self.follow(at, now);
        }
        if at.index < FIRST_TOLD || at.index == REDUNDANCY {
            self.services.follow(at, now);
            self.set_marks();
        }
        self.services.dictionary.on_changed(at, now);
        self.next = now;
    }

    /// An error of the device appeared: tells it, with five bytes of which the first is its source (ECSS 6.4).
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) {
        self.services.raise(code, info);
        self.next = Instant::ZERO;
    }

    /// An error of the device is gone.
    pub fn clear(&mut self, code: ErrorCode, source: u8) {
        self.services.clear(code, source);
        self.next = Instant::ZERO;
    }

    /// The communication profile as at power-on.
    pub(super) fn restore_communication(&mut self, now: Instant) {
        let before = self.filters();
        let objects = &mut self.services.dictionary.objects;
        objects.restore_communication(self.id, &self.initial);
        objects.communication.nmt_startup = self.startup.raw();
        self.services.load(Group::Communication);
        self.services.configure(now);
        let startup = NmtStartup::from_raw(self.services.dictionary.objects.communication.nmt_startup);
        self.nmt.set_autostart(startup.autostart());
        let parameters = self.written_redundancy();
        self.selector.configure(parameters);
        self.heartbeat.set_period(parameters.producer, now);
        for (number, filter) in before.into_iter().enumerate() {
            if self.filter(number) != filter {
                self.admit(number);
            }
        }
    }

    /// An SDO request on the active bus.
    #[inline(never)]
    pub(super) fn on_sdo(&mut self, frame: &Frame, now: Instant, out: &mut Out) {
        if !self.services.on_plain_segment(frame, now) {
            return self.on_request(frame, now, out);
        }
        // Its deadline has only moved away.
        self.run(now, now, out);
    }

    #[inline(never)] // a segment need not pay for it
    fn on_request(&mut self, frame: &Frame, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        if is_of_the_moment((frame.bits() >> 8) as u16) {
            self.refresh(now);
        }
        if !self.serve(SdoStep::Request(frame), bus, now, out) {
            self.buses.malformed(bus);
        }
        if let Some(at) = self.services.take_written() {
            self.on_written(at, now, out);
        }
        self.wake(self.services.sdo_deadline());
        self.run(now, now, out);
    }

    /// The SDO server runs; what it sends goes to `bus`.
    #[inline(never)] // of three callers
    pub(super) fn serve(&mut self, step: SdoStep, bus: Bus, now: Instant, out: &mut Out) -> bool {
        let expires = now + self.lifetimes.sdo;
        self.services.serve(step, now, &mut move |frame| out.send_until(bus, frame, expires))
    }

    /// A SYNC on the active bus.
    #[inline(never)]
    pub(super) fn on_sync(&mut self, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let (counter, is_told) = self.services.on_sync(frame, stamp.at);
        if is_told {
            self.next = now;
        }
        if let Ok(counter) = counter {
            if self.nmt.state().allows_pdo() {
                self.exchange(counter, stamp, now, out);
            }
            out.event(SlaveEvent::Sync { bus, stamp: *stamp });
        } else {
            self.buses.malformed(bus);
        }
        self.run(now, now, out);
    }

    /// Synchronous PDOs.
    #[inline(always)] // called from one place
    fn exchange(&mut self, counter: u8, stamp: &Stamp, now: Instant, out: &mut Out) {
        if self.tells_moment {
            // ECSS 7.2.3k: the local time at the end of the SYNC.
            self.refresh(stamp.at);
        }
        // CiA 301 7.5.2.7: what has not left at the end of the window is discarded.
        let expires = (now + self.lifetimes.synchronous).min(self.services.window_end());
        let bus = self.selector.selected();
        self.services.sample(counter, &mut |frame| out.send_until(bus, frame, expires));
        if self.services.is_rpdo_waiting() {
            self.actuate(stamp, now, out);
        }
    }

    #[inline(never)] // few SYNCs find any
    fn actuate(&mut self, stamp: &Stamp, now: Instant, out: &mut Out) {
        let (brings_time, mut brought) = (&self.brings_time, false);
        let (buses, bus) = (&mut self.buses, self.selector.selected());
        let ended = &mut |number, all: bool| match brings_time.as_ref().get(number) {
            _ if !all => buses.malformed(bus),
            Some(true) => brought = true,
            _ => out.event(SlaveEvent::Synchronised { number: number as u16 }),
        };
        if self.services.actuate(ended) {
            self.next = now;
        }
        if brought {
            self.take_time(stamp, out);
        }
    }

    /// The time that a PDO brought holds from the end of the frame on that put it into the dictionary.
    fn take_time(&mut self, stamp: &Stamp, out: &mut Out) {
        let scet = self.services.dictionary.objects.spacecraft.scet_set.into();
        self.clock.set(scet, stamp.at);
        out.event(SlaveEvent::Time(scet));
    }

    /// A frame on the active bus, in Operational, that may be of RPDOs.
    #[inline(never)]
    pub(super) fn on_pdo(&mut self, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let mut number = self.services.rpdo(frame.id());
        if number.is_none() {
            return self.on_network(bus, frame, stamp, now, out);
        }
        while let Some(found) = number {
            if self.services.on_plain_rpdo(found, frame)
                && self.brings_time.as_ref().get(found) == Some(&false)
            {
                out.event(SlaveEvent::Pdo { bus, number: found as u16, data: frame.padded() });
            } else {
                self.on_special_pdo(found, frame, stamp, now, out);
            }
            number = self.services.next_rpdo(frame.id(), found);
        }
        self.run(now, now, out);
    }

    /// A frame of an RPDO that is synchronous, has a deadline, brings the time, or is not as it should be.
    #[inline(never)]
    fn on_special_pdo(&mut self, number: usize, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let (taken, is_told) = self.services.on_rpdo(number, frame, stamp.at);
        match taken {
            Taken::Applied if self.brings_time.as_ref().get(number) == Some(&true) => {
                self.take_time(stamp, out)
            }
            Taken::Applied => {
                out.event(SlaveEvent::Pdo { bus, number: number as u16, data: frame.padded() });
            }
            Taken::Held => {}
            Taken::OutsideWindow => self.buses.ignored(bus),
            Taken::Rejected | Taken::Refused => self.buses.malformed(bus),
        }
        if is_told {
            self.next = now;
        }
        self.wake(self.services.rpdo_deadline());
    }

    /// An object was written over the bus: what depends on it follows.
    fn on_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        if at.index <= LAST_OWN {
            self.on_own_written(at, now, out);
        }
        if at.index >= FIRST_TOLD {
            if self.services.dictionary.tpdos.has_events() {
                self.services.dictionary.on_changed(at, now);
                self.wake(self.services.dictionary.tpdos.deadline());
            }
            out.event(SlaveEvent::Written(at));
        }
    }

    /// An object was written that the node itself follows.
    #[inline(never)] // those of the application need not pay for it
    fn on_own_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        self.follow(at, now);
        if at.index == SCET_SET {
            out.event(SlaveEvent::Time(self.clock.at(now)));
        } else if matches!(at.index, STORE | RESTORE)
            && Group::from_sub(at.sub).is_some_and(|group| group.contains(REDUNDANCY))
        {
            self.on_stored(at.index == STORE);
        } else if at.index == SELF_TEST_START {
            self.services.dictionary.objects.spacecraft.self_test =
                SelfTest { progress: SelfTest::RUNNING, failures: 0 };
            out.event(SlaveEvent::SelfTest);
        }
        if at.index < FIRST_TOLD || at.index == REDUNDANCY {
            self.services.on_written(at);
            self.set_marks();
            self.next = now;
        }
    }

    /// An object that the node follows has another value.
    fn follow(&mut self, at: Address, now: Instant) {
        match at.index {
            SYNC_COB_ID => self.admit(SYNC_FILTER),
            CONSUMER_HEARTBEAT => {
                self.follow_redundancy(at, now);
                self.admit(FILTERS_OF_PEERS + usize::from(at.sub.saturating_sub(1)));
            }
            PRODUCER_HEARTBEAT | REDUNDANCY => self.follow_redundancy(at, now),
            RPDO..=LAST_RPDO_MAPPING => self.admit(self.filters_of_rpdos() + usize::from(at.index & 0x1FF)),
            SCET_SET => self.clock.set(self.services.dictionary.objects.spacecraft.scet_set.into(), now),
            _ => {}
        }
    }

    /// Which frames are taken, and which bring the time.
    pub(super) fn set_marks(&mut self) {
        let pdos = &self.services.dictionary.objects.pdos;
        for (brings_time, mapping) in self.brings_time.as_mut().iter_mut().zip(pdos.rpdos().1) {
            *brings_time = mapping.objects().iter().any(|object| object >> 16 == u32::from(SCET_SET));
        }
        let of_the_moment = |mapping: &<D::Pdos as PdoSlots>::Mapping| {
            mapping.objects().iter().any(|object| is_of_the_moment((object >> 16) as u16))
        };
        self.tells_moment = pdos.tpdos().1.iter().any(of_the_moment);
        let fixed = [
            CobId::NMT,
            self.services.sync_id(),
            CobId::sdo_request(self.id),
            CobId::heartbeat(NodeId::MASTER),
            CobId::heartbeat(self.id),
        ];
        let peers = (0..self.services.consumers()).filter_map(|entry| self.services.monitored(entry));
        let all = fixed.into_iter().chain(self.services.rpdo_ids().flatten()).chain(peers);
        self.marks = all.fold(0, |marks, id| marks | mark(id));
    }

    /// Objects 1016h, 1017h and 2000h (ECSS Tables 8-1, 8-2).
    fn follow_redundancy(&mut self, at: Address, now: Instant) {
        let parameters = self.written_redundancy();
        self.selector.configure(parameters);
        if at.index == PRODUCER_HEARTBEAT {
            self.heartbeat.set_period(parameters.producer, now);
        }
    }

    /// The redundancy parameters as the dictionary has them.
    pub(super) fn written_redundancy(&self) -> Parameters {
        let objects = &self.services.dictionary.objects;
        let written = &objects.spacecraft.redundancy;
        let of_master = |entry: &&u32| **entry >> 16 == u32::from(NodeId::MASTER.get());
        let consumer = objects.consumers.entries().iter().find(of_master);
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
        if self.tells_moment && self.services.is_tpdo_due(until) {
            self.refresh(until);
        }
        self.services.poll(until, self.nmt.state(), &mut |frame| out.send_for(bus, frame, now, lifetime));
        if self.services.is_sdo_busy() {
            self.serve(SdoStep::Poll, bus, until, out);
        }
    }
}
