//! Speed of undisturbed frames computed at once, compared with the same frames bit by bit.
//!
//! Eight stations on 35 m of cable, each with its own crystal, send random frames of 8 bytes in turn, each when the bus
//! is free. Then all send at the same time, and only the part after the arbitration can be computed at once. Both paths
//! must give the stations and the observer the same events, to the tick. Times are wall-clock. Runs of both paths with
//! about the same duration, some milliseconds, alternate, and the shortest of each path counts, which other programs on
//! the computer did not disturb.

use std::time::{Duration, Instant};

use anyhow::ensure;
use can_twin::wire::bus::WireConfig;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::station::{Bench, Station};
use can_twin::wire::time::Time;
use can_twin::wire::timing::BitTiming;

use crate::bench::context::Context;
use crate::bench::row::Row;

/// Position and clock error of the stations, metres and parts per billion.
const BOARDS: [(f64, i32); 8] = [
    (0.0, 0),
    (5.0, 20_000),
    (10.0, -35_000),
    (15.0, 50_000),
    (20.0, -50_000),
    (25.0, 5_000),
    (30.0, -12_000),
    (35.0, 41_000),
];

/// Frames of a run on the fast path.
const FRAMES: u64 = 800;

/// Frames of a run on the bit path, which takes about the same time.
const BIT_FRAMES: u64 = FRAMES / 20;

/// Longer than any frame of 8 bytes with its intermission: 135 bits and 3.
const SLOT_US: u64 = 150;

/// Runs of either path.
const ROUNDS: usize = 150;

/// Smallest ratio of the speeds.
const RATIO: f64 = 20.0;

pub fn measure(_: &Context) -> anyhow::Result<Vec<Row>> {
    let alone = compare(|n| Time::from_us(n * SLOT_US))?;
    // All stations send at the same time.
    let contended = compare(|n| Time::from_us(n / BOARDS.len() as u64 * BOARDS.len() as u64 * SLOT_US))?;
    Ok(vec![
        Row::higher("fast_frames_per_second", alone.fast.round(), "frames_per_second").noisy(),
        Row::higher("bit_frames_per_second", alone.bits.round(), "frames_per_second").noisy(),
        Row::higher("fast_ratio", alone.ratio, "times").within(RATIO).noisy(),
        Row::higher("contended_ratio", contended.ratio, "times").noisy(),
    ])
}

/// Frames per second of wall-clock time, and the ratio of the speeds.
struct Speeds {
    fast: f64,
    bits: f64,
    ratio: f64,
}

fn compare(at: impl Fn(u64) -> Time) -> anyhow::Result<Speeds> {
    let (one, _) = run(&at, FRAMES, false);
    let (other, _) = run(&at, FRAMES, true);
    ensure_same(one, other)?;
    let per_second = |frames: u64, took: Duration| frames as f64 / took.as_secs_f64();
    let (mut fast, mut bits) = (0.0_f64, 0.0_f64);
    for _ in 0..ROUNDS {
        fast = fast.max(per_second(FRAMES, run(&at, FRAMES, false).1));
        bits = bits.max(per_second(BIT_FRAMES, run(&at, BIT_FRAMES, true).1));
    }
    Ok(Speeds { fast, bits, ratio: fast / bits })
}

/// Sends the first `frames` frames. Each station has a share of them, the same in each run.
fn run(at: impl Fn(u64) -> Time, frames: u64, bit_by_bit: bool) -> (Bench, Duration) {
    let mut stations = BOARDS.map(|(_, ppb)| Station::with_timing(BitTiming::MEGABIT.fast_by(ppb)));
    let mut random = fastrand::Rng::with_seed(1);
    for n in 0..frames {
        let sender = n as u16 % BOARDS.len() as u16;
        // Each identifier has one station.
        let id = random.u16(..0x100) * BOARDS.len() as u16 + sender;
        let frame = WireFrame::standard(id, &random.u64(..).to_le_bytes());
        // All stations have joined after 11 bits.
        stations[usize::from(sender)].queue.push_back((Time::from_us(50) + at(n), frame));
    }
    let config = WireConfig { bit_by_bit, ..WireConfig::default() };
    let keys = BOARDS.into_iter().zip(stations).map(|((position_m, _), station)| (position_m, station));
    let mut bench = Bench::new(config, keys.collect());
    let end = at(frames) + Time::from_ms(1);
    let start = Instant::now();
    bench.leap(end);
    (bench, start.elapsed())
}

/// Checks that all frames were sent, and that both benches had the same events.
fn ensure_same(mut one: Bench, mut other: Bench) -> anyhow::Result<()> {
    ensure!(one.wire.counters().completed == FRAMES, "not all frames are out: {:?}", one.wire.counters());
    ensure!(one.wire.take_records() == other.wire.take_records(), "the two paths differ in their records");
    let told = |bench: Bench| bench.stations.into_iter().map(|station| station.log).collect::<Vec<_>>();
    ensure!(told(one) == told(other), "the two paths differ in what they told the stations");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_is_noticed() {
        let at = |n| Time::from_us(n * SLOT_US);
        let (one, _) = run(at, FRAMES, false);
        let (mut other, _) = run(at, FRAMES, true);
        other.stations[7].log.pop();
        assert!(ensure_same(one, other).unwrap_err().to_string().contains("told the stations"));
    }
}
