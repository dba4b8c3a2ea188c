//! The application of the master, for a board and for tests on the host.
//!
//! An image runs [`Application`] on the LEDs of its board, and [`Cables`] in a task of its own (`src/app.rs`). A test runs the same
//! code on a mock board with [`mission::Indicators`] of its own.

#![no_std]
#![forbid(unsafe_code)]
#![warn(missing_docs)]

mod application;

pub use application::{Application, Cables, Node, pulses_per_second};
