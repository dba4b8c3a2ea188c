//! The demonstration mission: what its master and its slaves agree on beyond the protocol.
//!
//! Profiles, objects of a slave, commands and telemetry. A mission of your own has a crate like this one.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod message;
mod objects;
mod profiles;
mod record;

pub use message::{Command, Request, Telemetry};
pub use objects::{
    COMMANDED_VALUE, MissionObjects, Outgoing, REQUEST_RPDO, Samples, TELECOMMAND_RPDO, TELEMETRY_TPDO,
    TIME_RPDO, TIME_TPDO, Telecommand, TelemetryRequest, slave,
};
pub use profiles::{LIBRECUBE, STANDARD};
pub use record::{Declined, SlaveRecord};
