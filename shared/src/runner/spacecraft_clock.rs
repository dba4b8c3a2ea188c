//! The spacecraft time, for an application.

use super::resources::{Core, Platform};
use crate::node::TimeKeeper;
use crate::time::{Clock, Quality};
use crate::types::{Duration, FineInstant, Instant, Scet};

/// While somebody waits for a time, the clock is looked at as often, in case it was set meanwhile.
const LOOK: Duration = Duration::from_millis(100);

/// The clock of a node that keeps the spacecraft time.
pub struct SpacecraftClock<B: Platform, N: TimeKeeper> {
    core: &'static Core<B, N>,
}

impl<B: Platform, N: TimeKeeper> Clone for SpacecraftClock<B, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: Platform, N: TimeKeeper> Copy for SpacecraftClock<B, N> {}

impl<B: Platform, N: TimeKeeper> SpacecraftClock<B, N> {
    pub(super) const fn new(core: &'static Core<B, N>) -> Self {
        SpacecraftClock { core }
    }

    /// The spacecraft time at the present microsecond.
    ///
    /// # Panics
    /// As all that is here, when called from within [`Handle::with`](super::Handle::with).
    pub fn now(&self) -> Scet {
        let now = self.core.clock.now();
        self.core.lock(|shared| shared.node.spacecraft_clock().at(now.into()).scet())
    }

    /// How good it is.
    pub fn quality(&self) -> Quality {
        let now = self.core.clock.now();
        self.core.lock(|shared| shared.node.spacecraft_clock().quality(now.into()))
    }

    /// The instant of the node's timers at which it is, or was, `scet`: for a timer that makes an edge then. As the clock is
    /// steered it moves a little; ask as late as there is time for.
    pub fn when(&self, scet: Scet) -> FineInstant {
        self.core.lock(|shared| shared.node.spacecraft_clock().when(scet.into()))
    }

    /// Waits until it is `scet`; at once when that is past, which the nearer half of the counter is. When the clock is set to
    /// that time or beyond, that is noticed within 100 ms.
    pub async fn at(&self, scet: Scet) {
        while let Err(due) = self.reached(scet) {
            self.core.clock.at(due).await;
        }
    }

    /// # Errors
    /// When to look again.
    fn reached(&self, scet: Scet) -> Result<(), Instant> {
        let now = self.core.clock.now();
        self.core.lock(|shared| {
            let clock = shared.node.spacecraft_clock();
            if !clock.at(now.into()).scet().is_before(scet) {
                return Ok(());
            }
            // The microsecond after: timers count whole ones.
            let due = clock.when(scet.into()).instant() + Duration::from_micros(1);
            Err(due.max(now + Duration::from_micros(1)).min(now + LOOK))
        })
    }
}
