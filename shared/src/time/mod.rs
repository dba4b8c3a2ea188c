//! Time: protocol timers, stamps, spacecraft time.

mod clock;
pub mod disciplined;
mod estimator;
mod objects;
mod quality;
mod span;

pub use clock::LocalClock;
pub use objects::{LocalScet, LocalUtc, NoTime, ScetGet, ScetSet, UtcGet, UtcSet};
pub use quality::{Quality, Step, TimeSource};

use crate::types::Instant;

/// Where the protocol gets its time from. One per node, monotonic.
#[allow(async_fn_in_trait)] // spawned on single-threaded executors only
pub trait Clock {
    /// The present.
    fn now(&self) -> Instant;

    /// Completes at `deadline`, at once when it has passed.
    async fn at(&self, deadline: Instant);
}
