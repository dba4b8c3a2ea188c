//! One operation of a slave, so many times: callgrind counts what it costs.
//!
//! Arguments: `SCENARIO REPETITIONS`. Setting up and checking the outcome cost the same whatever the number, so that the
//! difference of two runs is the operations alone. `cargo xtask bench --only instructions` makes both runs of each.

#![forbid(unsafe_code)]

mod harness;
mod objects;
mod scenarios;

use std::env;

use anyhow::{Context, bail};
use ecss_can::pdo::{PdoMapping, StaticMapping};

use crate::scenarios::{
    block_download, discipline, heartbeat, irrelevant, peer_heartbeat, rpdo, rpdo_scattered, sync,
    sync_scattered, upload, write,
};

fn main() -> anyhow::Result<()> {
    // `cargo bench` adds an argument of its own.
    let arguments: Vec<String> = env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let [scenario, repetitions] = arguments.as_slice() else { bail!("usage: SCENARIO REPETITIONS") };
    let repetitions = repetitions.parse().with_context(|| format!("{repetitions:?} is no number"))?;
    match scenario.as_str() {
        "rpdo_static" => rpdo::<StaticMapping>(repetitions),
        "rpdo_variable" => rpdo::<PdoMapping>(repetitions),
        "sync_tpdo_static" => sync::<StaticMapping>(repetitions),
        "sync_tpdo_variable" => sync::<PdoMapping>(repetitions),
        "rpdo_scattered" => rpdo_scattered(repetitions),
        "sync_tpdo_scattered" => sync_scattered(repetitions),
        "sdo_upload" => upload(repetitions),
        "sdo_download" => write(repetitions),
        "block_download_segment" => block_download(repetitions),
        "heartbeat_consumed" => heartbeat(repetitions),
        "peer_heartbeat_consumed" => peer_heartbeat(repetitions),
        "irrelevant_frame" => irrelevant(repetitions),
        "clock_discipline" => discipline(repetitions),
        other => bail!("there is no scenario {other:?}"),
    }
}
