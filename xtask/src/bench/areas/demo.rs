//! Cost of the flight of `cargo demo`.
//!
//! Emulated instructions of all boards and events on the buses (frames that completed), per second of virtual time. A
//! more accurate bus or chip must not make the demo slow. The speed on this computer is given as a ratio.

use crate::bench::context::Context;
use crate::bench::row::Row;

/// Instructions and frames of the 40 s of the demo before the buses became bit-accurate: 42 million and 3930.
const BASELINE: f64 = 42_003_930.0 / 40.0;

/// Largest allowed ratio to the baseline.
const ALLOWED: f64 = 1.2;

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let flight = context.demo()?;
    let seconds = flight.end.as_secs_f64();
    let per_second = |count: u64| (count as f64 / seconds).round() as u64;
    let instructions: u64 = flight.boards.iter().map(|board| board.instructions).sum();
    let events = flight.frames().count() as u64;
    let target = (BASELINE * ALLOWED).round() as u64;
    let speed = seconds / flight.wall.as_secs_f64();
    Ok(vec![
        Row::lower("instructions", per_second(instructions), "per_virtual_second"),
        Row::lower("bus_events", per_second(events), "per_virtual_second"),
        Row::lower("work", per_second(instructions + events), "per_virtual_second").within(target),
        Row::higher("real_time", speed, "times").noisy(),
    ])
}
