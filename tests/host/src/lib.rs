//! Scenarios that the first tier of the tests flies in samples, and the second one in full.

#![forbid(unsafe_code)]

pub mod events;
pub mod reports;
