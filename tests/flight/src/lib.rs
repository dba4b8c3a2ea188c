//! Shared code for flights of the images: a spacecraft of real images, and the record of it.
//!
//! Flights of the images of two configurations are `tests/flight/tests/flight`, which `cargo test` flies: pyboards with profile
//! `librecube`, and with `standby`. All others are `tests/second/tests/flights`.

#![forbid(unsafe_code)]

pub mod minimal;
mod program_faults;
pub mod rates;
mod spacecraft;
pub mod standby;

pub use program_faults::*;
pub use spacecraft::*;
