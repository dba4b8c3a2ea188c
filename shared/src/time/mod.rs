//! Time: the clock of protocol timers, the local clock of spacecraft time, and the service that sets and steers it.
//!
//! *SCET* is the spacecraft elapsed time, which the master distributes (ECSS 7.1.2, 7.2). A *pair* is an instant of
//! the node and the spacecraft time at that instant. The [`LocalClock`] follows such pairs. It is *steered* if a
//! pair corrects it without a jump, and makes a *step* if it is set.
//!
//! ```
//! use ecss_can::time::ClockPolicy;
//! use ecss_can::time::machine::LocalClock;
//! use ecss_can::types::{Instant, Scet};
//!
//! let second = |s: u64| Instant::from_micros(s * 1_000_000);
//! let scet = |s: u32| Scet::new(s, 0).unwrap();
//!
//! let mut clock = LocalClock::new(&ClockPolicy::DEFAULT);
//! clock.set(second(1).into(), scet(100).into());
//! assert_eq!(clock.at(second(3).into()).scet(), scet(102));
//! assert_eq!(clock.when(scet(105).into()).instant(), second(6));
//! ```
//!
//! | type | purpose |
//! | --- | --- |
//! | [`LocalClock`] | spacecraft time at every instant, with a [`Quality`] |
//! | [`TimeService`] | clock of a node with its SYNCs, and the reads and writes of its objects |
//! | [`ClockPolicy`] | limits of the crystals, on which the error bound relies |
//! | [`LocalScet`], [`LocalUtc`], [`ClockObjects`] | objects 2010h to 2016h |
//!
//! # Limits
//!
//! - The error bound in [`Quality`] holds as long as every crystal stays within the [`ClockPolicy`].
//! - Without stamps in hardware a SYNC is stamped in its interrupt, some microseconds late.
//! - Nodes count the SCET. UTC follows from a [`UtcRelation`](crate::types::UtcRelation), which does not count leap
//!   seconds.

mod clock;
mod copies;
mod doubt;
mod estimator;
pub mod machine;
mod objects;
mod policy;
mod quality;
mod service;
mod trust;

pub(crate) use clock::LocalClock;
pub(crate) use copies::ClockCopies;
pub use objects::{
    ClockObjects, ClockQuality, LocalScet, LocalUtc, NoTime, ScetGet, ScetSet, TimeCorrection, UtcGet, UtcSet,
};
pub use policy::ClockPolicy;
pub use quality::{Quality, Step, TimeSource};
pub(crate) use service::{ClientSamples, PairOutcome, Places, TimeService, mean_of_truncated};
