//! ECSS-E-ST-50-15C, the CANbus extension protocol, on top of CANopen.
//!
//! The protocol is *sans-IO*: every service is a plain struct that is given frames and the time and puts what it wants
//! done into an outbox. Only [`runner`] is async; it joins a node to two CAN controllers through the traits
//! [`link::port::CanPort`] and [`time::Clock`], which boards implement on bxCAN and host tests on mocks.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

// The derive macros name this crate from outside, also in here.
extern crate self as ecss_can;

pub mod boot;
pub mod emcy;
pub mod heartbeat;
pub mod link;
pub mod nmt;
pub mod node;
pub mod od;
pub mod pdo;
pub mod profile;
pub mod redundancy;
pub mod runner;
pub mod sdo;
pub mod store;
pub mod sync;
pub mod time;
pub mod types;
