//! The campaign of random faults: its judges, its regressions, and a share of its runs.

mod broken;
mod images;
mod jolts;
mod patches;
mod regressions;
mod share;
mod takeover;
