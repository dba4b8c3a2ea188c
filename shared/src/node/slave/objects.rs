//! The dictionary of a slave at work: SDO, SYNC and PDOs, and what a written object means to the node.

use super::{FILTERS_OF_PEERS, Out, SYNC_FILTER, Slave};
use crate::emcy::ErrorCode;
use crate::heartbeat::ConsumerSlots;
use crate::link::Stamp;
use crate::node::index::{
    CONSUMER_HEARTBEAT, LAST_RPDO_MAPPING, PRODUCER_HEARTBEAT, REDUNDANCY, RESTORE, RPDO, SELF_TEST_START,
    STORE, SYNC_COB_ID,
};
use crate::node::services::SdoStep;
use crate::node::{Device, DeviceNode, NodeObjects, SelfTest, SlaveEvent};
use crate::redundancy::Parameters;
use crate::store::Group;
use crate::types::{AbortCode, Address, Bus, CobId, Duration, Frame, Instant, NodeId};

/// The last object that a node follows.
const LAST_OWN: u16 = SELF_TEST_START;

impl<D: Device> Slave<D> {
    /// The object dictionary.
    pub fn objects(&self) -> &NodeObjects<D> {
        &self.services.dictionary.objects
    }

    /// The object dictionary alone, for a data sheet.
    pub fn into_objects(self) -> NodeObjects<D> {
        self.services.dictionary.objects
    }

    /// An event of the application: sends a transmit PDO (0 is the first) as its transmission type has it. Refused, and
    /// counted on the active bus, unless Operational and the PDO is valid.
    pub fn send_pdo(&mut self, number: usize, now: Instant) {
        if self.nmt.state().allows_pdo() && self.services.dictionary.tpdos.is_valid(number) {
            self.services.dictionary.tpdos.trigger(number, now);
            self.services.next = now;
        } else {
            self.services.buses.refused(self.selector.selected());
        }
    }

    /// An error of the device appeared: tells it, with five bytes of which the first is its source (ECSS 6.4).
    pub fn raise(&mut self, code: ErrorCode, info: [u8; 5]) {
        self.services.raise(code, info);
        self.services.next = Instant::ZERO;
    }

    /// An error of the device is gone.
    pub fn clear(&mut self, code: ErrorCode, source: u8) {
        self.services.clear(code, source);
        self.services.next = Instant::ZERO;
    }

    /// The communication profile as at power-on.
    pub(super) fn restore_communication(&mut self, now: Instant) {
        let before = self.filters();
        let objects = &mut self.services.dictionary.objects;
        objects.restore_communication(self.id, &self.initial);
        objects.communication.nmt.startup = self.startup.raw();
        self.services.load(Group::Communication);
        self.services.configure(now);
        self.nmt.set_autostart(self.services.dictionary.objects.communication.nmt.startup().autostart());
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
        self.services.refresh_for(frame, now);
        if !self.serve(SdoStep::Request(frame), bus, now, out) {
            self.services.buses.malformed(bus);
        }
        if let Some(at) = self.services.take_written() {
            self.on_written(at, now, out);
        }
        self.services.wake(self.services.sdo_deadline());
        self.run(now, now, out);
    }

    /// The SDO server runs; what it sends goes to `bus`.
    #[inline(never)] // of three callers
    pub(super) fn serve(&mut self, step: SdoStep, bus: Bus, now: Instant, out: &mut Out) -> bool {
        let expires = now + self.services.lifetimes.sdo;
        self.services.serve(step, now, &mut move |frame| out.send_until(bus, frame, expires))
    }

    /// A SYNC on the active bus.
    #[inline(never)]
    pub(super) fn on_sync(&mut self, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let (counter, is_told) = self.services.on_sync(frame, stamp.at);
        if is_told {
            self.services.next = now;
        }
        if let Ok(counter) = counter {
            if self.nmt.state().allows_pdo() {
                self.services.exchange(bus, counter, stamp, now, out);
            }
            out.event(SlaveEvent::Sync { bus, stamp: *stamp });
        } else {
            self.services.buses.malformed(bus);
        }
        self.run(now, now, out);
    }

    /// A frame on the active bus, in Operational, that may be of RPDOs.
    #[inline(never)]
    pub(super) fn on_pdo(&mut self, frame: &Frame, stamp: &Stamp, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        if self.services.on_pdo(bus, frame, stamp, now, out) {
            self.run(now, now, out);
        } else {
            self.on_network(bus, frame, stamp, now, out);
        }
    }

    /// An object was written over the bus: what depends on it follows.
    fn on_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        if at.index <= LAST_OWN {
            self.on_own_written(at, now, out);
        }
        self.services.report_written(at, now, out);
    }

    /// An object was written that the node itself follows.
    #[inline(never)] // those of the application need not pay for it
    fn on_own_written(&mut self, at: Address, now: Instant, out: &mut Out) {
        self.services.on_own_written(at, now, out);
        self.follow(at, now);
        if matches!(at.index, STORE | RESTORE)
            && Group::from_sub(at.sub).is_some_and(|group| group.contains(REDUNDANCY))
        {
            self.on_stored(at.index == STORE);
        }
        self.set_marks();
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
            _ => {}
        }
    }

    /// Which frames are taken.
    pub(super) fn set_marks(&mut self) {
        let fixed = [
            CobId::NMT,
            self.services.sync_id(),
            CobId::sdo_request(self.id),
            CobId::heartbeat(NodeId::MASTER),
            CobId::heartbeat(self.id),
        ];
        let peers = (0..self.services.consumers()).filter_map(|entry| self.services.monitored(entry));
        let all = fixed.into_iter().chain(self.services.rpdo_ids().flatten()).chain(peers);
        self.marks = all.collect();
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
        let of_master = |entry: &&u32| **entry >> 16 == u32::from(NodeId::MASTER.get());
        let consumer = objects.consumers.entries().iter().find(of_master);
        let time = consumer.map_or(0, |entry| entry & 0xFFFF);
        let producer = Duration::from_millis(u64::from(objects.communication.heartbeat.time));
        let consumer = Duration::from_millis(u64::from(time));
        objects.spacecraft.redundancy.parameters.parameters(consumer, producer)
    }

    pub(super) fn run_device(&mut self, until: Instant, now: Instant, out: &mut Out) {
        let bus = self.selector.selected();
        let send = &mut |frame, expires, _| out.send_until(bus, frame, expires);
        self.services.poll(until, now, self.nmt.state(), send);
        if self.services.is_sdo_busy() {
            self.serve(SdoStep::Poll, bus, until, out);
        }
    }
}

impl<D: Device> DeviceNode for Slave<D> {
    type Device = D;

    fn change<R>(&mut self, now: Instant, change: impl FnOnce(&mut D) -> R) -> R {
        self.services.change(now, |objects| change(&mut objects.application))
    }

    fn write(&mut self, at: Address, value: &[u8], now: Instant, out: &mut Out) -> Result<(), AbortCode> {
        if let Some(at) = self.services.write(at, value, now)? {
            self.on_written(at, now, out);
        }
        self.run(now, now, out);
        Ok(())
    }

    fn report_self_test(&mut self, result: SelfTest, now: Instant) {
        self.services.change(now, |objects| objects.spacecraft.self_test = result);
    }
}
