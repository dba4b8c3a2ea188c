//! Instructions of the host for one operation of a slave, as valgrind's callgrind counts them.
//!
//! Release build, frame in to response out or value in the dictionary, the program around it included: the difference
//! between 100,000 repetitions and none. Targets are the figures of the best public CANopen stack in C, measured in the
//! same way, with static mapping and with variable mapping if that differs.

use std::path::Path;

use crate::bench::callgrind;
use crate::bench::context::Context;
use crate::bench::row::Row;

const REPETITIONS: u64 = 100_000;

/// Scenarios of `shared/benches/instructions`, and the target of each. Scenarios with scattered values and the local
/// clock have no target.
const SCENARIOS: [(&str, Option<u64>); 13] = [
    ("rpdo_static", Some(263)),
    ("rpdo_variable", Some(565)),
    ("sync_tpdo_static", Some(301)),
    ("sync_tpdo_variable", Some(589)),
    ("rpdo_scattered", None),
    ("sync_tpdo_scattered", None),
    ("sdo_upload", Some(341)),
    ("sdo_download", Some(367)),
    ("block_download_segment", Some(168)),
    ("heartbeat_consumed", Some(209)),
    ("peer_heartbeat_consumed", Some(209)),
    ("irrelevant_frame", Some(67)),
    ("clock_discipline", None),
];

pub fn measure(_: &Context) -> anyhow::Result<Vec<Row>> {
    let program = callgrind::build(&["--package", "ecss-can", "--bench", "instructions"], "release")?;
    SCENARIOS.into_iter().map(|(scenario, target)| row(&program, scenario, target)).collect()
}

fn row(program: &Path, scenario: &str, target: Option<u64>) -> anyhow::Result<Row> {
    let count = |repetitions: u64| callgrind::count(program, &[scenario, &repetitions.to_string()]);
    let operations = count(REPETITIONS)?.saturating_sub(count(0)?);
    let each = operations as f64 / REPETITIONS as f64;
    Ok(Row::lower(scenario, each, "instructions").within_any(target))
}
