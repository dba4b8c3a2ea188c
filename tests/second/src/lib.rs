//! Tests of the spacecraft with independent tools.
//!
//! A test is a Python script in `python/`, one per topic, and a line in `tests/tools/scripts.rs` that says with which
//! spacecraft it runs. [`script::run`] starts `cargo twin` on free ports, passes the addresses of both buses to the
//! script, and fails with the output of both. Shared code of the scripts is in `python/spacecraft.py`: channels by
//! SLCAN with the twin's own time stamps, and networks of the `canopen` package.
//!
//! In the other direction, [`host::Host`] is the SDO client of `ecss-can` on this computer, and a script
//! ([`script::Companion`]) is the server: [`flight::Flight`], `tests/tools/sdo_client.rs`.
//!
//! Values of types that the mission's objects do not have are those of the test device, `firmware/fixtures`: [`device`] has its
//! image and its data sheets.
//!
//! `cargo xtask test-all --tier tools` checks that the tools are installed and runs these tests side by side. A test whose tool is missing fails
//! and names that command.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod device;
pub mod flight;
pub mod host;
pub mod page;
pub mod program;
pub mod programs;
pub mod script;
pub mod slcan;
pub mod tools;
