//! A small spacecraft: the state machines of flight of two slaves and of one master or two, on two buses that break.
//!
//! Its states are few enough for `tests/search` to visit all of them. Here, random faults meet it.

#![forbid(unsafe_code)]

pub mod defect;
pub mod master;
pub mod profile;
pub mod property;
pub mod slave;
pub mod station;
pub mod watch;
pub mod what;
pub mod world;
