//! Time: protocol timers, stamps, spacecraft time.

mod clock;
pub mod consumer;
mod instant;
mod periodic;
pub mod producer;
mod scet;

pub use clock::LocalClock;
pub use instant::{Duration, Instant};
pub use periodic::Periodic;
pub use scet::Scet;

/// Where the protocol gets its time from. One per node, monotonic.
#[allow(async_fn_in_trait)] // spawned on single-threaded executors only
pub trait Clock {
    /// The present.
    fn now(&self) -> Instant;

    /// Completes at `deadline`, at once when it has passed.
    async fn at(&self, deadline: Instant);
}

/// When a frame ended, on the clock of the node that saw it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamp {
    /// End of the last bit of the frame, as well as the source allows.
    pub at: Instant,
    /// How it was measured.
    pub source: StampSource,
}

/// How a [`Stamp`] was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StampSource {
    /// Read in the interrupt at the end of the frame: late by the interrupt latency, some microseconds.
    Interrupt,
}
