//! Live objects: local time, quality of the clock, health of the buses. They are sampled when they are read or sent.

use easy_ext::ext;

use super::Services;
use super::mapped::is_local_time;
use super::time::TimeServices;
use crate::node::SpacecraftDevice;
use crate::node::index::{CLOCK_QUALITY, HEALTH_NOMINAL, HEALTH_REDUNDANT, HEARTBEAT_SENT};
use crate::pdo::PdoSlots;
use crate::types::{Frame, Instant};

/// Returns whether an object is sampled when it is read: local time, quality of the clock, health of the buses.
pub fn is_live(index: u16) -> bool {
    is_local_time(index)
        || matches!(index, CLOCK_QUALITY | HEARTBEAT_SENT | HEALTH_NOMINAL | HEALTH_REDUNDANT)
}

#[ext(LiveServices)]
impl<D: SpacecraftDevice> Services<D> {
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

    /// Triggers the transmit PDOs that carry the time.
    pub fn trigger_time(&mut self, now: Instant) {
        for number in 0..D::Pdos::TRANSMIT {
            if self.state().carries_time(number) {
                self.trigger(number, now);
            }
        }
    }
}
