//! The application of the slave, for a board and for tests on the host.
//!
//! An image runs [`Application`] on the LEDs of its board (`src/app.rs`). A test runs the same code on a mock board with
//! [`mission::Indicators`] of its own.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod application;

pub use application::{Application, Node, pulses_per_second};
