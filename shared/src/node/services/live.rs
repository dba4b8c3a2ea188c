//! Live objects: local time, quality of the clock, health of the buses. They are sampled when they are read or sent.

use async_canopen::node::extend;
use easy_ext::ext;

use super::Services;
use super::mapped::{self, MappedTime, is_local_time};
use super::time::TimeServices;
use crate::link::Stamp;
use crate::node::index::{CLOCK_QUALITY, HEALTH_NOMINAL, HEALTH_REDUNDANT, HEARTBEAT_SENT};
use crate::node::{NodeObjects, SpacecraftDevice};
use crate::od::INVALID;
use crate::pdo::machine::rules::is_synchronous;
use crate::pdo::{Mapping, PdoSlots};
use crate::types::{Bus, FineInstant, Frame, Instant, NodeId};

/// Returns whether an object is sampled when it is read: local time, quality of the clock, health of the buses.
pub fn is_live(index: u16) -> bool {
    is_local_time(index)
        || matches!(index, CLOCK_QUALITY | HEARTBEAT_SENT | HEALTH_NOMINAL | HEALTH_REDUNDANT)
}

/// Returns whether a mapping has an object for which `is_it` holds.
fn has(mapping: &impl Mapping, is_it: impl Fn(u16) -> bool) -> bool {
    mapping.objects().iter().any(|object| is_it((object >> 16) as u16))
}

#[ext(LiveServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Notes which PDOs carry the time or live values.
    pub fn note_live_values(&mut self) {
        let is_master = self.id() == NodeId::MASTER;
        let (NodeObjects { pdos, .. }, state) = (&self.dictionary.objects, &mut self.state);
        (state.is_time_by_sync, state.notes_syncs) = (false, is_master);
        let (parameters, mappings) = pdos.rpdos();
        for ((mapped_time, pdo), mapping) in
            state.mapped_time.as_mut().iter_mut().zip(parameters).zip(mappings)
        {
            *mapped_time = MappedTime::of(mapping);
            state.is_time_by_sync |= *mapped_time != MappedTime::None
                && pdo.cob_id & INVALID == 0
                && is_synchronous(pdo.transmission);
        }
        for (carries_time, mapping) in state.carries_time.as_mut().iter_mut().zip(pdos.tpdos().1) {
            *carries_time = mapped::carries_time(mapping);
        }
        let mut carried = pdos.tpdos().1.iter();
        state.carries_live_value = carried.clone().any(|mapping| has(mapping, is_live));
        state.carries_quality = carried.any(|mapping| has(mapping, |index| index == CLOCK_QUALITY));
        state.notes_syncs |= state.carries_live_value || state.is_time_by_sync;
        let notes_syncs = state.notes_syncs;
        self.watch_syncs(notes_syncs);
    }

    /// Samples the live objects for transmit PDOs.
    pub fn refresh(&mut self, at: FineInstant) {
        self.refresh_time(at);
        self.refresh_carried(at.instant());
    }

    /// Those that are no time.
    pub fn refresh_carried(&mut self, now: Instant) {
        if self.state.carries_quality {
            self.refresh_quality(now);
        }
        self.refresh_health();
    }

    /// Samples the live objects if an SDO request is for one of them.
    #[inline] // row `instructions.sdo_upload`
    pub fn refresh_for(&mut self, request: &Frame, now: Instant) {
        if is_live((request.bits() >> 8) as u16) {
            self.refresh_time_for(request, now);
            self.refresh_health();
        }
    }

    /// Takes a SYNC on the active bus: its PDOs are sampled at its end (ECSS 7.2.3k).
    pub fn note_sync(&mut self, bus: Bus, stamp: &Stamp) {
        self.state.time.on_sync(bus, stamp);
        if self.state.carries_live_value
            && let Some(at) = self.last_sync()
        {
            self.refresh(at);
        }
    }

    /// Samples the live objects for transmit PDOs that are due by an event or a timer.
    pub fn sample_events(&mut self, until: Instant) {
        if self.state.carries_live_value && self.dictionary.tpdos.deadline().is_some_and(|due| due <= until) {
            self.refresh_time_of_events(until);
            self.refresh_carried(until);
        }
    }

    /// Triggers the transmit PDOs that carry the time.
    pub fn trigger_time(&mut self, now: Instant) {
        let extend::Services { dictionary, state, wakes, .. } = self;
        for (number, carries_time) in state.carries_time.as_ref().iter().enumerate() {
            if *carries_time {
                dictionary.tpdos.change(wakes).trigger(number, now);
            }
        }
    }
}
