//! The dictionary of a slave at work: SDO, SYNC and PDOs, and what a written object means to the node.

use super::{FIXED_FILTERS, Out, Slave, mark};
use crate::emcy::ErrorCode;
use crate::link::port::Filter;
use crate::link::{Bus, CobId, Frame};
use crate::nmt::NodeId;
use crate::node::device::PdoOutcome;
use crate::node::{NodeObjects, SlaveEvent};
use crate::od::communication::{Mapping, RpdoParameters};
use crate::od::spacecraft::SelfTest;
use crate::od::{Address, Objects};
use crate::redundancy::Parameters;
use crate::runner::{BusCommand, MAX_FILTERS};
use crate::store::Group;
use crate::time::{Duration, Instant, Stamp};

/// Local SCET set.
const SCET_SET: u16 = 0x2010;

impl<A: Objects + Default, const R: usize, const T: usize, M: Mapping> Slave<A, R, T, M> {
    /// The object dictionary.
    pub fn objects(&self) -> &NodeObjects<A, R, T, M> {
        &self.device.objects
    }

    /// The object dictionary, to be changed. PDOs of what was changed are sent by [`Slave::send_pdo`] and
    /// [`Slave::changed`].
    pub fn objects_mut(&mut self) -> &mut NodeObjects<A, R, T, M> {
        &mut self.device.objects
    }

    /// An event of the application: sends a transmit PDO (0 is the first) as its transmission type has it. Refused, and
    /// counted on the active bus, unless Operational.
    pub fn send_pdo(&mut self, number: usize, now: Instant) {
        if self.nmt.state().allows_pdo() {
            self.device.trigger(number, now);
            self.next = now;
        } else {
            self.buses.refused(self.selector.selected());
        }
    }

    /// The application changed a value: an event for all event-driven transmit PDOs that carry it.
    pub fn changed(&mut self, at: Address, now: Instant) {
        self.device.on_changed(at, now);
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
        let power_on = (self.power_on)(self.id);
        let before = core::mem::replace(&mut self.device.objects.communication, power_on);
        self.device.objects.set_heartbeats(&self.initial);
        self.device.load(Group::Communication);
        self.device.configure(now);
        let parameters = self.written_redundancy();
        self.selector.configure(parameters);
        self.heartbeat.set_period(parameters.producer, now);
        let changed =
            |(_, (old, new)): &(usize, (&RpdoParameters, &RpdoParameters))| old.cob_id != new.cob_id;
        let pdos = before.rpdos.iter().zip(&self.device.objects.communication.rpdos).enumerate();
        for (number, _) in pdos.filter(changed) {
            self.admit_rpdo(number, out);
        }
    }

    #[inline(always)] // called from one place
    pub(super) fn on_sdo(&mut self, bus: Bus, frame: &Frame, now: Instant, out: &mut Out) {
        if self.device.on_plain_segment(frame, now) {
            // Its deadline has moved away.
            return;
        }
        // Values of the moment that may be asked for.
        match frame.data() {
            [_, 0x11, 0x20, ..] => self.device.objects.spacecraft.scet_get = self.clock.at(now).into(),
            [_, 0x20 | 0x21, 0x20, ..] => self.refresh_health(),
            _ => {}
        }
        let lifetime = self.lifetimes.sdo;
        if !self.device.on_sdo(frame, now, &mut |frame| out.send_for(bus, frame, now, lifetime)) {
            self.buses.malformed(bus);
        }
        if let Some(at) = self.device.take_written() {
            self.on_written(at, now, out);
        }
        self.wake(self.device.sdo_deadline());
    }

    #[inline(always)] // called from one place
    pub(super) fn on_sync(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, now: Instant, out: &mut Out) {
        let Ok(counter) = self.device.on_sync(frame, stamp.at) else {
            self.buses.malformed(bus);
            self.next = now;
            return;
        };
        if self.nmt.state().allows_pdo() {
            // ECSS 7.2.3k: the local time at the end of the SYNC.
            self.device.objects.spacecraft.scet_get = self.clock.at(stamp.at).into();
            let lifetime = self.lifetimes.synchronous;
            self.device.sample(counter, &mut |frame| out.send_for(bus, frame, now, lifetime));
            self.device.actuate(&mut |number| out.event(SlaveEvent::Synchronised { number }));
        }
        out.event(SlaveEvent::Sync { bus, stamp });
    }

    #[inline(always)] // called from one place
    pub(super) fn on_pdo(&mut self, bus: Bus, frame: &Frame, stamp: Stamp, now: Instant, out: &mut Out) {
        let (clock, brings_time) = (&mut self.clock, &self.brings_time);
        let known = self.device.on_rpdo(frame, stamp.at, &mut |objects, number| {
            if brings_time.get(usize::from(number)) == Some(&true) {
                let scet = objects.spacecraft.scet_set.into();
                clock.set(scet, stamp.at);
                out.event(SlaveEvent::Time(scet));
            } else {
                out.event(SlaveEvent::Pdo { bus, number, data: frame.padded() });
            }
        });
        match known {
            PdoOutcome::Taken => {}
            PdoOutcome::Ignored => self.buses.ignored(bus),
            PdoOutcome::Told => self.next = now,
            PdoOutcome::Erroneous => {
                self.buses.malformed(bus);
                self.next = now;
            }
        }
        self.wake(self.device.rpdo_deadline());
    }

    /// An object was written over the bus: what depends on it follows.
    fn on_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        let objects = &self.device.objects;
        match at.index {
            0x1016 | 0x1017 | 0x2000 => self.on_redundancy_written(at, now),
            SCET_SET => {
                self.clock.set(objects.spacecraft.scet_set.into(), now);
                out.event(SlaveEvent::Time(self.clock.at(now)));
            }
            0x2030 => {
                self.device.objects.spacecraft.self_test =
                    SelfTest { progress: SelfTest::RUNNING, failures: 0 };
                out.event(SlaveEvent::SelfTest);
            }
            0x1005 => self.set_filter(1, self.device.written_sync_id(), out),
            0x1400..=0x15FF => {
                self.admit_rpdo(usize::from(at.index & 0x1FF), out);
            }
            _ => {}
        }
        if self.device.on_written(at) {
            self.set_marks();
            self.next = now;
        } else {
            let due = self.device.on_changed(at, now);
            self.wake(due);
            out.event(SlaveEvent::Written(at));
        }
    }

    /// Which frames are taken, and which bring the time.
    pub(super) fn set_marks(&mut self) {
        let mappings = &self.device.objects.communication.rpdo_mappings;
        for (brings_time, mapping) in self.brings_time.iter_mut().zip(mappings) {
            *brings_time = mapping.objects().iter().any(|object| object >> 16 == u32::from(SCET_SET));
        }
        let fixed = [
            CobId::NMT,
            self.device.sync_id(),
            CobId::sdo_request(self.id),
            CobId::heartbeat(NodeId::MASTER),
        ];
        let monitored = self.device.objects.communication.consumer_heartbeat.iter();
        let peers = monitored.filter_map(|entry| NodeId::new((entry >> 16) as u8)).map(CobId::heartbeat);
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
        let objects = &self.device.objects;
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

    fn admit_rpdo(&self, number: usize, out: &mut Out) {
        let id = self.device.rpdo_ids().nth(number).flatten();
        self.set_filter(FIXED_FILTERS + number, id.unwrap_or(CobId::NMT), out);
    }

    /// Admits other frames on both buses.
    fn set_filter(&self, number: usize, id: CobId, out: &mut Out) {
        if number < MAX_FILTERS - 1 {
            let command = BusCommand::Filter { number: number as u8, filter: Filter::exact(id) };
            Bus::ALL.into_iter().for_each(|bus| out.command(bus, command));
        }
    }

    pub(super) fn run_device(&mut self, until: Instant, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let (sdo, event) = (self.lifetimes.sdo, self.lifetimes.event);
        self.device.poll(until, self.nmt.state(), &mut |frame| {
            let lifetime = if frame.id().function() == CobId::SDO_RESPONSES { sdo } else { event };
            out.send_for(bus, frame, now, lifetime);
        });
    }
}
