//! All measurements, by area.
//!
//! A new area is a file here with a function `measure`, and its name in the two lists below.

mod bound;
mod demo;
mod failover;
mod holdover;
mod instructions;
mod irq;
mod load;
mod mission;
mod rx;
mod sdo;
mod size;
mod stamp;
mod sync;
mod takeover;
mod time;
mod twin;
mod upsets;
mod wire;

use ecss_can_cli::images::support::needs::{Need, VALGRIND};
pub use size::biggest_symbols;
pub use time::clock_errors;

use super::context::Context;
use super::row::Row;

/// Rows that are measured together. Their names start with its name.
pub struct Area {
    /// Name on the command line and before the dot of its rows.
    pub name: &'static str,
    /// Description of its measurements.
    pub about: &'static str,
    /// Third-party programs that it runs.
    pub needs: &'static [Need],
    /// Measures the rows.
    pub measure: Measure,
}

type Measure = fn(&Context) -> anyhow::Result<Vec<Row>>;

/// Makes an area that runs no third-party program.
const fn area(name: &'static str, about: &'static str, measure: Measure) -> Area {
    Area { name, about, needs: &[], measure }
}

impl Area {
    const fn with(self, needs: &'static [Need]) -> Area {
        Area { needs, ..self }
    }
}

/// All areas, in the order in which they are measured and printed.
pub const ALL: [Area; 18] = [
    area("size", "flash and RAM of the images, the deepest stacks in operation", size::measure),
    area("instructions", "instructions of the host per operation of a slave", instructions::measure)
        .with(&[VALGRIND]),
    area("twin", "instructions of the host per emulated one, of a whole run", twin::measure)
        .with(&[VALGRIND]),
    area("rx", "model cycles from receive interrupt to node and application", rx::measure),
    area("load", "frames back to back on both buses, 10 s", load::measure),
    area(
        "mission",
        "processor, stack and bus load of the demonstration by profile and role",
        mission::measure,
    ),
    area("failover", "from a cut to commands on the other bus", failover::measure),
    area(
        "takeover",
        "two active masters, one of which became so at each 5 us of a heartbeat period: six cases in worlds of the host",
        takeover::measure,
    ),
    area("sdo", "block transfers of 20 kB against the wire limit", sdo::measure),
    area("irq", "interrupts of a controller on a cut bus", irq::measure),
    area("stamp", "stamps of 1000 SYNCs at 30 % and at 90 % load", stamp::measure),
    area("sync", "model cycles to the stamp of a SYNC", sync::measure),
    area("time", "clocks of three slaves against the master's, five seeds of 60 s", time::measure),
    area("holdover", "clocks of three slaves without SYNC for 100 s, five seeds", holdover::measure),
    area(
        "bound",
        "reported error bounds of three slaves against their errors, four cases of two seeds",
        bound::measure,
    ),
    area("wire", "the fast path of the buses against the bit path", wire::measure),
    area("upsets", "model cycles of the check of the program", upsets::measure),
    area("demo", "cost of a run of the demo", demo::measure),
];
