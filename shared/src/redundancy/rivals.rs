//! Other nodes that send the heartbeat of the master.

use crate::types::{Bus, Canonical, Duration, Instant, PerBus};

/// Instants at which 701h of another node was last heard on each bus.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[canonical(context = Duration)] // silence that ends a collision
pub struct Rivals {
    #[canonical(age = *context)]
    last: PerBus<Option<Instant>>,
}

impl Rivals {
    /// Takes a frame of another node with the COB-ID of the master's heartbeat. Returns whether a collision
    /// begins on that bus.
    pub fn on_heartbeat(&mut self, bus: Bus, at: Instant) -> bool {
        self.last[bus].replace(at).is_none()
    }

    /// Returns the next bus without such a frame for `silence`, once. Call it until `None`.
    pub fn poll(&mut self, now: Instant, silence: Duration) -> Option<Bus> {
        Bus::ALL.into_iter().find(|bus| self.last[*bus].take_if(|last| *last + silence <= now).is_some())
    }

    /// Returns whether no collision is open on either bus.
    pub(crate) fn are_silent(&self) -> bool {
        Bus::ALL.into_iter().all(|bus| self.last[bus].is_none())
    }

    /// Returns when to poll next.
    pub fn deadline(&self, silence: Duration) -> Option<Instant> {
        Bus::ALL.into_iter().filter_map(|bus| self.last[bus]).min().map(|last| last + silence)
    }
}
