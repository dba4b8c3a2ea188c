//! The emulated spacecraft boards.

pub mod bxcan;
