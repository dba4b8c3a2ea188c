//! Worlds of nodes on two simulated buses, in virtual time, on the host.
//!
//! The same runners as on the boards run here on mocks of [`CanPort`] and [`Clock`]: one
//! single-threaded executor per node, no sleeping, and time that jumps from event to event. Equal worlds give equal
//! traces.
//!
//! [`CanPort`]: ecss_can::link::port::CanPort
//! [`Clock`]: ecss_can::time::Clock

#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod application;
mod board;
mod builder;
pub mod clock;
pub mod log;
pub mod port;
mod rogue;
pub mod task;
pub mod timeline;
pub mod world;

pub use application::{MasterHandle, MissionMaster, MissionSlave, SlaveHandle};
pub use board::Mock;
pub use builder::Builder;
