//! A small spacecraft: the state machines of the firmware for two slaves and one or two masters, on two buses with
//! faults.
//!
//! It has so few states that `tests/search` visits all of them. The tests of this package use random faults.

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
