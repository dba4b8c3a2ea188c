//! The demonstration mission: definitions beyond the protocol that its master and slaves share.
//!
//! These are profiles, objects of a slave, commands and telemetry. Each mission has a crate like this one.
//!
//! Related crates: [`ecss-can`](https://docs.rs/ecss-can), [`ecss-can-stm32f4`](https://docs.rs/ecss-can-stm32f4),
//! [`ecss-can-worlds`](https://docs.rs/ecss-can-worlds), [`ecss-can-cli`](https://docs.rs/ecss-can-cli).

#![cfg_attr(not(feature = "host"), no_std)]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod application;
mod choice;
pub mod counters;
pub mod fmt;
#[cfg(feature = "host")]
pub mod host;
mod indicators;
mod master;
mod message;
pub mod minimal;
mod objects;
mod payload;
mod profiles;
mod record;

pub use indicators::Indicators;
pub use master::{Boards, CableMeasurement, CommanderObjects, Received, SLAVES, master, received, slot};
pub use message::{Command, Request, Telemetry};
pub use objects::{MissionObjects, Outgoing, REQUEST, TELECOMMAND, Telecommand, TelemetryRequest, slave};
pub use payload::Message;
pub use profiles::{COMMAND_PERIOD, LIBRECUBE, PROFILE, STANDARD, TELEMETRY_PERIOD, TWO_MASTERS};
pub use record::{Declined, SlaveRecord};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
