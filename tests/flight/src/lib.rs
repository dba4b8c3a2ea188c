//! What flights of the images have in common: a spacecraft of real images, and what was seen on it.
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
