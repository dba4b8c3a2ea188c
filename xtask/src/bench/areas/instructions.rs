//! Instructions of the host for one operation of a slave, as valgrind's callgrind counts them.
//!
//! Release build, frame in to response out or value in the dictionary, the program around it included: the difference
//! between 100,000 repetitions and none. Targets are what the best public CANopen stack in C takes, measured in the same
//! way, with static mapping and with variable mapping where it makes a difference there.

use std::path::Path;

use super::Area;
use crate::bench::callgrind;
use crate::bench::context::Context;
use crate::bench::row::Row;

pub const AREA: Area =
    Area { name: "instructions", about: "instructions of the host per operation of a slave", measure };

const REPETITIONS: u64 = 100_000;

/// Scenarios of the program in `xtask/instructions`, and the target of each.
const SCENARIOS: [(&str, u64); 10] = [
    ("rpdo_static", 263),
    ("rpdo_variable", 565),
    ("sync_tpdo_static", 301),
    ("sync_tpdo_variable", 589),
    ("sdo_upload", 341),
    ("sdo_download", 367),
    ("block_download_segment", 168),
    ("heartbeat_consumed", 209),
    ("peer_heartbeat_consumed", 209),
    ("irrelevant_frame", 67),
];

fn measure(_: &Context) -> anyhow::Result<Vec<Row>> {
    let program = callgrind::build("instructions")?;
    SCENARIOS.into_iter().map(|(scenario, target)| row(&program, scenario, target)).collect()
}

fn row(program: &Path, scenario: &str, target: u64) -> anyhow::Result<Row> {
    let count = |repetitions: u64| callgrind::count(program, &[scenario, &repetitions.to_string()]);
    let operations = count(REPETITIONS)?.saturating_sub(count(0)?);
    Ok(Row::lower(scenario, operations as f64 / REPETITIONS as f64, "instructions").within(target))
}
