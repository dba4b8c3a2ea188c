//! Others that send the master's heartbeat.

use crate::types::{Bus, Duration, Instant, PerBus};

/// When 701h of somebody else was last heard on each bus.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Rivals {
    last: PerBus<Option<Instant>>,
}

impl Rivals {
    /// A frame with the master's heartbeat COB-ID arrived. Returns `true` if it begins a collision on that bus.
    pub fn on_heartbeat(&mut self, bus: Bus, at: Instant) -> bool {
        self.last[bus].replace(at).is_none()
    }

    /// The next bus where none was heard for `silence`, once; call until `None`.
    pub fn poll(&mut self, now: Instant, silence: Duration) -> Option<Bus> {
        Bus::ALL.into_iter().find(|bus| self.last[*bus].take_if(|last| *last + silence <= now).is_some())
    }

    /// When to poll next.
    pub fn deadline(&self, silence: Duration) -> Option<Instant> {
        Bus::ALL.into_iter().filter_map(|bus| self.last[bus]).min().map(|last| last + silence)
    }

    /// Shifts the clock.
    #[cfg(feature = "model")]
    pub fn rebase(&mut self, to: &crate::types::Rebase, silence: Duration) {
        self.last = PerBus::from_fn(|bus| self.last[bus].map(|last| to.aged(last, silence)));
    }
}
