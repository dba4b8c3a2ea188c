//! The local clock against emulated crystals: a master that distributes its time, and a slave that follows it.
//!
//! The true time is known to a fraction of a nanosecond, so that the error of the clock can be measured.
//! [`Scenario::run`] returns it as a series, for tests, tables and pictures.

pub mod crystal;
pub mod figures;
pub mod follower;
pub mod scenario;
pub mod trials;

pub use crystal::{Crystal, Data, Warmth};
pub use figures::Figures;
pub use follower::{Follower, Slave};
pub use scenario::{Sample, Scenario, Stamps};
