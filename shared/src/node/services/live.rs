//! Live objects: local time, quality of the clock, health of the buses. They are sampled when they are read or sent.

use easy_ext::ext;

use super::Services;
use super::mapped::is_local_time;
use super::time::TimeServices;
use crate::link::Stamp;
use crate::node::SpacecraftDevice;
use crate::node::index::{CLOCK_QUALITY, HEALTH_NOMINAL, HEALTH_REDUNDANT, HEARTBEAT_SENT};
use crate::pdo::PdoSlots;
use crate::types::{Bus, FineInstant, Frame, Instant, NodeId};

/// Returns whether an object is sampled when it is read: local time, quality of the clock, health of the buses.
pub fn is_live(index: u16) -> bool {
    is_local_time(index)
        || matches!(index, CLOCK_QUALITY | HEARTBEAT_SENT | HEALTH_NOMINAL | HEALTH_REDUNDANT)
}

#[ext(LiveServices)]
impl<D: SpacecraftDevice> Services<D> {
    /// Notes which PDOs carry the time or live values.
    pub fn note_live_values(&mut self) {
        let is_master = self.id() == NodeId::MASTER;
        let (objects, state) = self.objects_and_state();
        state.note_mappings(&objects.pdos, is_master);
        let notes_syncs = state.notes_syncs();
        self.watch_syncs(notes_syncs);
    }

    /// Samples the live objects for transmit PDOs.
    pub fn refresh(&mut self, at: FineInstant) {
        self.refresh_time(at);
        self.refresh_carried(at.instant());
    }

    /// Samples the live objects other than the time.
    pub fn refresh_carried(&mut self, now: Instant) {
        if self.state().carries_quality() {
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
        self.time_mut().on_sync(bus, stamp);
        if self.state().carries_live_value()
            && let Some(at) = self.last_sync()
        {
            self.refresh(at);
        }
    }

    /// Samples the live objects for transmit PDOs that are due by an event or a timer.
    pub fn sample_events(&mut self, until: Instant) {
        if self.state().carries_live_value() && self.tpdos().deadline().is_some_and(|due| due <= until) {
            self.refresh_time_of_events(until);
            self.refresh_carried(until);
        }
    }

    /// Triggers the transmit PDOs that carry the time.
    pub fn trigger_time(&mut self, now: Instant) {
        for number in 0..D::Pdos::TRANSMIT {
            if self.state().carries_time(number) {
                self.trigger(number, now);
            }
        }
    }
}
