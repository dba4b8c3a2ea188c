//! Searches all that can happen to a master and two slaves on two buses, by the state machines of flight.

#![forbid(unsafe_code)]

pub mod defect;
pub mod evidence;
pub mod master;
pub mod profile;
pub mod search;
pub mod slave;
pub mod snapshot;
pub mod station;
pub mod step;
pub mod table;
pub mod watch;
pub mod world;
