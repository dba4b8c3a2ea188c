//! Clock, estimator and time service of a node, as machines without input and output.
//!
//! For nodes of another kind, and for tests. A user of a node needs none of these.

pub use super::clock::LocalClock;
pub use super::service::{ClientSamples, PairOutcome, Places, TimeService, mean_of_truncated};
