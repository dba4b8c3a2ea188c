//! Cost of the twin on the host, in the profile of `cargo demo`.
//!
//! Instructions of the host per instruction of the emulated cores, including cores, boards, buses and the observers of
//! the demo. valgrind's callgrind counts them for two lengths of the demo flight without faults. The row has the
//! difference, so that the start of the program does not count. The rows `core_*` are for the core only, with three
//! small programs and plain memory. The time of a fork is that of a copy of four boards on their buses, the shortest of
//! 20.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context as _, ensure};
use can_twin::board::BoardConfig;
use can_twin::crystal::Crystal;
use can_twin::spacecraft::{Spacecraft, SpacecraftConfig};
use can_twin::wire::time::Time;
use ecss_can_cli::images::support::board::Profile;
use ecss_can_cli::images::support::fleet;

use crate::bench::callgrind;
use crate::bench::context::{Context, FLOWN, board};
use crate::bench::row::Row;

/// Virtual seconds of the two flights. The first one ends after the start of all boards.
const LENGTHS: [u64; 2] = [2, 4];
/// Largest number of host instructions per emulated instruction.
const MOST_INSTRUCTIONS: f64 = 260.0;

/// Emulated instructions of the two runs of a small program.
const STEPS: [u64; 2] = [100_000, 300_000];

/// Time after power-on at which the spacecraft is copied, number of its boards, and longest time that a copy may take.
const FORKED: Time = Time::from_ms(2_000);
const BOARDS: u8 = 4;
const MOST_MS: f64 = 2.0;
const REPEATS: usize = 20;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    Ok(vec![
        Row::lower("host_instructions", host_instructions(context)?, "instructions")
            .within(MOST_INSTRUCTIONS),
        Row::lower("core_integers", core("integers")?, "instructions"),
        Row::lower("core_floats", core("floats")?, "instructions"),
        Row::lower("core_checksums", core("checksums")?, "instructions"),
        Row::lower("fork", fork(context)?.as_secs_f64() * 1e3, "ms").within(MOST_MS).noisy(),
    ])
}

fn host_instructions(context: &Context) -> anyhow::Result<f64> {
    let images = context.images(&FLOWN, Profile::Librecube)?;
    // As `cargo test` has it.
    let program = callgrind::build(&["--package", "ecss-can-cli", "--example", "flight"], "dev")?;
    let files = [&images.master, &images.slave].map(|path| path.display().to_string());
    let fly = |seconds: u64| -> anyhow::Result<(u64, u64)> {
        let seconds = seconds.to_string();
        let arguments = [&*seconds, &*files[0], &*files[1]];
        Ok((callgrind::count(&program, &arguments)?, emulated(&program, &arguments)?))
    };
    let [(short, short_emulated), (long, long_emulated)] = [fly(LENGTHS[0])?, fly(LENGTHS[1])?];
    Ok(long.saturating_sub(short) as f64 / (long_emulated - short_emulated) as f64)
}

/// Returns the instructions of the emulated cores that the flight reports.
fn emulated(program: &Path, arguments: &[&str]) -> anyhow::Result<u64> {
    let output = Command::new(program).args(arguments).output().context("cannot run the images")?;
    ensure!(output.status.success(), "the run failed: {}", String::from_utf8_lossy(&output.stderr));
    let report = String::from_utf8_lossy(&output.stdout);
    let count = report.split_whitespace().next().and_then(|count| count.parse().ok());
    count.with_context(|| format!("no number of instructions: {report}"))
}

/// Returns the instructions of the host per instruction of this program of the example `programs`.
fn core(name: &str) -> anyhow::Result<f64> {
    // As `cargo test` has it.
    let program =
        callgrind::build(&["--package", "can-twin", "--features", "boards", "--example", "programs"], "dev")?;
    let run = |steps: u64| callgrind::count(&program, &[name, &steps.to_string()]);
    let [short, long] = [run(STEPS[0])?, run(STEPS[1])?];
    Ok(long.saturating_sub(short) as f64 / (STEPS[1] - STEPS[0]) as f64)
}

/// Measures the wall-clock time of a copy of a spacecraft in flight.
fn fork(context: &Context) -> anyhow::Result<Duration> {
    let built = context.images(&FLOWN, Profile::Librecube)?;
    let nodes: Vec<u8> = (1..=BOARDS).collect();
    let images = fleet::shipped(&built, nodes.iter().copied())?;
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for node in nodes {
        let crystal = Crystal::ppm(f64::from(node));
        spacecraft.add_board(BoardConfig {
            crystal,
            position_m: f64::from(node),
            ..board(node, &images[&node])
        });
    }
    spacecraft.run_until(FORKED)?;
    let copy = |_| {
        let begun = Instant::now();
        let copy = spacecraft.clone();
        let elapsed = begun.elapsed();
        drop(copy);
        elapsed
    };
    (0..REPEATS).map(copy).min().context("at least one copy")
}
