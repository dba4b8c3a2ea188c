//! Scenarios of which the first tier of the tests runs samples, and the second tier all.

#![forbid(unsafe_code)]

pub mod events;
pub mod reports;
