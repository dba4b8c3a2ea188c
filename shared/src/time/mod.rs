//! Time: protocol timers, stamps, spacecraft time.

mod clock;
mod instant;
mod pattern;
mod periodic;
pub mod producer;
mod scet;
mod stamp;
mod utc;

pub use clock::LocalClock;
pub use instant::{Duration, Instant, earliest};
pub use periodic::Periodic;
pub use scet::Scet;
pub use stamp::{Captured, EDGES, EdgeRing, Miss, Stamp, StampSource, Ticks};
pub use utc::Utc;

/// Where the protocol gets its time from. One per node, monotonic.
#[allow(async_fn_in_trait)] // spawned on single-threaded executors only
pub trait Clock {
    /// The present.
    fn now(&self) -> Instant;

    /// Completes at `deadline`, at once when it has passed.
    async fn at(&self, deadline: Instant);
}
