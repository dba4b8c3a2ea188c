//! Clock of the spacecraft time, for an application.

use easy_ext::ext;

use super::extend::{Waiter, WholeNode};
use super::{Handle, Platform};
use crate::node::TimeKeeper;
use crate::time::Quality;
use crate::types::{Duration, FineInstant, Instant, Scet};

/// Clock of a node that keeps the spacecraft time.
#[doc(alias("SCET", "spacecraft elapsed time"))]
pub struct SpacecraftClock<B: Platform, N: TimeKeeper> {
    handle: Handle<B, N>,
}

impl<B: Platform, N: TimeKeeper> Clone for SpacecraftClock<B, N> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B: Platform, N: TimeKeeper> Copy for SpacecraftClock<B, N> {}

impl<B: Platform, N: TimeKeeper> SpacecraftClock<B, N> {
    pub(super) const fn new(handle: Handle<B, N>) -> Self {
        SpacecraftClock { handle }
    }

    /// Returns the spacecraft time at the present microsecond.
    pub fn now(&self) -> Scet {
        let now = self.handle.now();
        self.handle.inspect(|node| node.spacecraft_clock().at(now.into()).scet())
    }

    /// Returns the quality of the clock.
    pub fn quality(&self) -> Quality {
        let now = self.handle.now();
        self.handle.inspect(|node| node.spacecraft_clock().quality(now.into()))
    }

    /// Returns the instant of the node's timers at which the spacecraft time is, or was, `scet`: for a timer that
    /// makes an edge then. The instant moves a little while the clock is steered, so call it as late as possible.
    pub fn when(&self, scet: Scet) -> FineInstant {
        self.handle.inspect(|node| node.spacecraft_clock().when(scet.into()))
    }

    /// Waits until the spacecraft time is `scet`, or until the clock is set to that time or a later one. Completes
    /// at once if `scet` is in the past: in the half of the counter's range before the present. Of more than four
    /// tasks that wait, the others notice a step of the clock within 100 ms.
    ///
    /// # Cancel safety
    /// A dropped future has no effect.
    pub async fn at(&self, scet: Scet) {
        let place = Waiter::take(self.handle);
        while let Err(due) = self.reached(scet) {
            place.wait_until(due).await;
        }
    }

    /// # Errors
    /// Instant at which to check again.
    fn reached(&self, scet: Scet) -> Result<(), Instant> {
        let now = self.handle.now();
        self.handle.inspect(|node| {
            let clock = node.spacecraft_clock();
            if !clock.at(now.into()).scet().is_before(scet) {
                return Ok(());
            }
            // The microsecond after: timers count whole ones.
            let due = clock.when(scet.into()).instant() + Duration::from_micros(1);
            Err(due.max(now + Duration::from_micros(1)))
        })
    }
}

/// What the handle of a node that keeps the spacecraft time has beyond that of a CANopen node.
#[ext(TimeHandle)]
impl<B: Platform, N: TimeKeeper> Handle<B, N> {
    /// Returns the clock of the spacecraft time.
    pub fn clock(&self) -> SpacecraftClock<B, N> {
        SpacecraftClock::new(*self)
    }
}
