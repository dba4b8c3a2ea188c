//! Time: the clock of protocol timers, the local SCET clock, and the service that sets, steers and tells it.

mod clock;
mod doubt;
mod estimator;
mod objects;
mod policy;
mod quality;
mod service;
mod trust;

pub use clock::LocalClock;
pub use objects::{
    ClockObjects, ClockQuality, LocalScet, LocalUtc, NoTime, ScetGet, ScetSet, TimeCorrection, UtcGet, UtcSet,
};
pub use policy::ClockPolicy;
pub use quality::{Quality, Step, TimeSource};
pub use service::{PairOutcome, Places, TimeService, mean_of_truncated};

use crate::types::Instant;

/// Time source of the protocol: one for each node, monotonic.
#[allow(async_fn_in_trait)] // spawned on single-threaded executors only
pub trait Clock {
    /// Returns the present instant.
    fn now(&self) -> Instant;

    /// Waits until `deadline`. Completes at once if it has passed.
    ///
    /// # Cancel safety
    /// A dropped future must have no effect.
    async fn at(&self, deadline: Instant);
}
