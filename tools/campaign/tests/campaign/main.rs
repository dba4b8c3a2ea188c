//! The campaign of random faults: its judges, its regressions, and a share of its runs.

mod broken;
mod jolts;
mod machines;
mod patches;
mod regressions;
mod share;
mod takeover;
