//! The local clock against emulated crystals: a master that distributes its time, and a slave that follows it.
//!
//! The truth is known here to a fraction of a nanosecond, so that the error of the clock is measured and not guessed.
//! [`Scenario::run`] gives it as a series, for tests, tables and pictures.

pub mod crystal;
pub mod figures;
pub mod follower;
pub mod scenario;
pub mod trials;

pub use crystal::{Crystal, Data, Warmth};
pub use figures::Figures;
pub use follower::{Follower, Slave};
pub use scenario::{Sample, Scenario, Stamps};
