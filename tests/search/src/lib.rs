//! Two long searches for what breaks a rule: [all states](states) of a small spacecraft, and [random sequences](fuzz) of frames.
//!
//! The programs `search` and `fuzz` run them for as long as one likes, the tests for a minute.

#![forbid(unsafe_code)]

pub mod fuzz;
pub mod states;
