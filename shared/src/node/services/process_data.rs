//! Process data of a node: received frames, SYNC, events and timers, and values that are sampled for
//! transmission.

use super::time::{self, MappedTime, is_local_time};
use super::{Dictionary, NodeEvent, Services};
use crate::link::Stamp;
use crate::node::index::{CLOCK_QUALITY, HEALTH_NOMINAL, HEALTH_REDUNDANT, HEARTBEAT_SENT};
use crate::node::turn::Turn;
use crate::node::{Device, Extension, NodeObjects};
use crate::od::INVALID;
use crate::pdo::rules::is_synchronous;
use crate::pdo::{Mapping, PdoSlots, Taken};
use crate::types::{Bus, CobId, Duration, FineInstant, Frame, Instant, NmtState, NodeId};

/// Lifetime of a frame with the time: a receiver's clock is late by what it waits.
const TIME_LIFETIME: Duration = Duration::from_millis(5);

/// Returns whether an object is sampled when it is read: local time, quality of the clock, health of the buses.
fn is_live(index: u16) -> bool {
    is_local_time(index)
        || matches!(index, CLOCK_QUALITY | HEARTBEAT_SENT | HEALTH_NOMINAL | HEALTH_REDUNDANT)
}

/// Returns whether a mapping has an object for which `is_it` holds.
fn has(mapping: &impl Mapping, is_it: impl Fn(u16) -> bool) -> bool {
    mapping.objects().iter().any(|object| is_it((object >> 16) as u16))
}

impl<D: Device, E: Extension> Services<D, E> {
    /// Notes which PDOs carry the time or live values, and how long those of a SYNC live. Call after each change of a
    /// PDO or of 1006h.
    pub(super) fn note_mappings(&mut self) {
        if self.dictionary.objects.spacecraft.spacecraft().is_some() {
            self.note_live_values();
        }
        self.synchronous_lifetime = self.synchronous_lifetime();
    }

    fn note_live_values(&mut self) {
        let NodeObjects { pdos, .. } = &self.dictionary.objects;
        (self.is_time_by_sync, self.notes_syncs) = (false, self.id == NodeId::MASTER);
        let (parameters, mappings) = pdos.rpdos();
        for ((mapped_time, pdo), mapping) in
            self.mapped_time.as_mut().iter_mut().zip(parameters).zip(mappings)
        {
            *mapped_time = MappedTime::of(mapping);
            self.is_time_by_sync |= *mapped_time != MappedTime::None
                && pdo.cob_id & INVALID == 0
                && is_synchronous(pdo.transmission);
        }
        for (carries_time, mapping) in self.carries_time.as_mut().iter_mut().zip(pdos.tpdos().1) {
            *carries_time = time::carries_time(mapping);
        }
        let mut carried = pdos.tpdos().1.iter();
        self.carries_live_value = carried.clone().any(|mapping| has(mapping, is_live));
        self.carries_quality = carried.any(|mapping| has(mapping, |index| index == CLOCK_QUALITY));
        self.notes_syncs |= self.carries_live_value || self.is_time_by_sync;
        self.sync.watch(self.notes_syncs);
    }

    /// Samples the live objects for transmit PDOs.
    pub(super) fn refresh(&mut self, at: FineInstant) {
        self.refresh_time(at);
        self.refresh_carried(at.instant());
    }

    /// Those that are no time.
    fn refresh_carried(&mut self, now: Instant) {
        if self.carries_quality {
            self.refresh_quality(now);
        }
        self.refresh_health();
    }

    /// Samples the live objects if an SDO request is for one of them.
    #[inline] // row `instructions.sdo_upload`
    pub fn refresh_for(&mut self, request: &Frame, now: Instant) {
        if self.dictionary.objects.spacecraft.spacecraft().is_some() && is_live((request.bits() >> 8) as u16)
        {
            self.refresh_time_for(request, now);
            self.refresh_health();
        }
    }

    /// Handles a SYNC with this counter in Operational. Synchronous TPDOs are sampled before RPDOs take effect.
    /// `withheld`: COB-ID of a PDO that is not sent.
    #[inline(always)] // called from one place
    pub fn exchange<V: NodeEvent>(
        &mut self,
        bus: Bus,
        counter: u8,
        withheld: Option<CobId>,
        turn: &mut Turn<V>,
    ) {
        // CiA 301 7.5.2.7: what has not left at the end of the window is discarded.
        let expires = (turn.now + self.synchronous_lifetime).min(self.window_end());
        self.sample(counter, &mut |frame, may_wait| {
            if may_wait {
                return turn.out.offer(bus, frame, expires);
            }
            if withheld != Some(frame.id()) {
                turn.out.send_until(bus, frame, expires);
            }
            true
        });
        if self.is_rpdo_waiting() {
            self.end_sync(bus, turn);
        }
    }

    /// Receive PDOs that waited for the SYNC.
    #[inline(never)] // few SYNCs find any
    fn end_sync<V: NodeEvent>(&mut self, bus: Bus, turn: &mut Turn<V>) {
        let Self { dictionary, counters, wakes, .. } = self;
        let ended = &mut |number, all: bool| {
            if all { turn.out.event(V::synchronised(number as u16)) } else { counters.malformed(bus) }
        };
        let Dictionary { objects, rpdos, .. } = dictionary;
        rpdos.no_sooner().on_sync(objects, ended);
        if rpdos.has_events() {
            dictionary.report_rpdos(wakes);
        }
    }

    /// Handles a frame on the active bus in Operational. Returns whether its COB-ID is that of an RPDO.
    #[inline(always)] // called from one place
    pub fn on_pdo<V: NodeEvent>(
        &mut self,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        turn: &mut Turn<V>,
    ) -> bool {
        let Some(mut number) = self.dictionary.rpdos.first(frame.id()) else { return false };
        loop {
            if self.on_plain_rpdo(number, frame) && !self.mapped_time(number) {
                turn.out.event(V::pdo(bus, number as u16, frame.padded()));
            } else {
                self.on_special_pdo(number, bus, frame, stamp, turn);
            }
            match self.dictionary.rpdos.next(frame.id(), number) {
                Some(next) => number = next,
                None => return true,
            }
        }
    }

    fn mapped_time(&self, number: usize) -> bool {
        E::HAS_TIME && self.mapped_time.as_ref().get(number).is_some_and(|time| *time != MappedTime::None)
    }

    /// A frame of an RPDO that is synchronous, has a deadline, carries the time, or is not as it should be.
    #[inline(never)]
    fn on_special_pdo<V: NodeEvent>(
        &mut self,
        number: usize,
        bus: Bus,
        frame: &Frame,
        stamp: &Stamp,
        turn: &mut Turn<V>,
    ) {
        match self.on_rpdo(number, frame, stamp.at) {
            Taken::Applied if self.mapped_time(number) => self.take_time(number, bus, stamp, turn),
            Taken::Applied => turn.out.event(V::pdo(bus, number as u16, frame.padded())),
            Taken::Held => {}
            Taken::OutsideWindow => self.counters.ignored(bus),
            Taken::Rejected | Taken::Refused => self.counters.malformed(bus),
        }
    }

    /// Sends what is due, except SDO responses. Each frame has the end of its lifetime and a flag: it carries the
    /// time. `send` returns `false` if there is no room: the frame then waits. Emergencies go first because their COB-IDs
    /// have the higher priority.
    pub fn poll(
        &mut self,
        until: Instant,
        now: Instant,
        state: NmtState,
        send: &mut impl FnMut(Frame, Instant, bool) -> bool,
    ) {
        if self.carries_live_value && self.dictionary.tpdos.deadline().is_some_and(|due| due <= until) {
            self.refresh_time_of_events(until);
            self.refresh_carried(until);
        }
        let expires = now + self.lifetimes.event;
        self.dictionary.poll(until, &mut self.wakes, state, &mut |frame| send(frame, expires, false));
        let Self { dictionary, carries_time, .. } = self;
        dictionary.tpdos.no_sooner().poll(
            until,
            &dictionary.objects,
            &mut |number, frame| match carries_time.as_ref().get(number) {
                Some(true) => send(frame, expires.min(now + TIME_LIFETIME), true),
                _ => send(frame, expires, false),
            },
        );
    }

    /// Triggers the transmit PDOs that carry the time.
    pub fn trigger_time(&mut self, now: Instant) {
        for (number, carries_time) in self.carries_time.as_ref().iter().enumerate() {
            if *carries_time {
                self.dictionary.tpdos.change(&mut self.wakes).trigger(number, now);
            }
        }
    }
}
