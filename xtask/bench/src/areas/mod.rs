//! Everything that is measured, area by area.
//!
//! A new area is a file here with `pub const AREA: Area`, and its name in the two lists below. An area that takes minutes has
//! several steps.

mod bound;
mod core;
mod crowd;
mod demo;
mod failover;
mod holdover;
mod instructions;
mod irq;
mod load;
mod master;
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
    /// Number of steps. They have rows of their own, so each can run on another machine.
    pub steps: u64,
    /// Measures the rows of a step, from 0.
    pub measure: fn(&Context, u64) -> anyhow::Result<Vec<Row>>,
}

impl Area {
    /// Measures all rows.
    ///
    /// # Errors
    /// When something cannot be measured.
    pub fn rows(&self, context: &Context) -> anyhow::Result<Vec<Row>> {
        let mut rows = Vec::new();
        for step in 0..self.steps {
            rows.extend((self.measure)(context, step)?);
        }
        Ok(rows)
    }
}

/// All areas, in the order in which they are measured and printed.
pub const ALL: &[Area] = &[
    size::AREA,
    instructions::AREA,
    core::AREA,
    twin::AREA,
    rx::AREA,
    load::AREA,
    master::AREA,
    failover::AREA,
    takeover::AREA,
    demo::AREA,
    crowd::AREA,
    sdo::AREA,
    irq::AREA,
    stamp::AREA,
    sync::AREA,
    time::AREA,
    holdover::AREA,
    bound::AREA,
    wire::AREA,
];
