//! The analysis behind `cargo schedule`; the other commands are packages of their own.

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod schedule;
