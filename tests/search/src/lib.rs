//! Two long searches for broken rules: [all states](states) of a small spacecraft, and [random sequences](fuzz) of
//! frames.
//!
//! The programs `search` and `fuzz` run them for any time, the tests for a minute.

#![forbid(unsafe_code)]

pub mod fuzz;
pub mod states;
