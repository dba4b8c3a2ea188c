//! Everything that is measured, area by area.
//!
//! A new area is a file here with `pub const AREA: Area`, and its name in the two lists below.

mod bound;
mod demo;
mod failover;
mod holdover;
mod instructions;
mod irq;
mod load;
mod rx;
mod sdo;
mod size;
mod stamp;
mod sync;
mod takeover;
mod time;
mod twin;
mod wire;

pub use size::biggest_symbols;
pub use time::clock_errors;

use firmware_images::support::needs::Need;

use super::context::Context;
use super::row::Row;

/// Rows that are measured together; its name is the first part of theirs.
pub struct Area {
    /// On the command line and before the dot of its rows.
    pub name: &'static str,
    /// What it measures, for people.
    pub about: &'static str,
    /// Programs of others that it runs.
    pub needs: &'static [Need],
    /// Measures the rows.
    pub measure: fn(&Context) -> anyhow::Result<Vec<Row>>,
}

/// All areas, in the order in which they are measured and printed.
pub const ALL: &[Area] = &[
    size::AREA,
    instructions::AREA,
    twin::AREA,
    rx::AREA,
    load::AREA,
    failover::AREA,
    takeover::AREA,
    sdo::AREA,
    irq::AREA,
    stamp::AREA,
    sync::AREA,
    time::AREA,
    holdover::AREA,
    bound::AREA,
    wire::AREA,
    demo::AREA,
];
