//! Frames at even distances, and frames that arrive while the board does what is due by time: looks at its controllers, sends its heartbeat, arms its timers.
//!
//! Frames at even distances meet that by chance. A sweep aims at it: frames arrive at a certain distance from the instants at which
//! the board wakes up by itself. The distance grows by a microsecond every 100 ms.

use std::ops::Range;

use can_wire::time::Time;
use twin::spacecraft::Bus;

use crate::bench::rig::{MASTER_BEATS, Rig};

/// From what was before to the heartbeat of the master that comes before a frame.
const BREAK: Time = Time::from_us(500);

/// How long the sweep keeps a distance: what is due ten times a second is due once.
const PERIOD: Time = Time::from_ms(100);

/// Distances, microseconds, counted from [`BEFORE`]. The last frame arrives when all is done.
const DISTANCES: Range<u64> = 0..50;

/// The first frame arrives so long before the board wakes up, and is not yet with the node then.
const BEFORE: Time = Time::from_us(5);

/// Times that the distances are gone through.
const PASSES: usize = 2;

/// Before a pass. Frames shift looks: another one is then the first of those that follow closely upon each other.
const PAUSE: Time = Time::from_ms(37);

/// Between heartbeats of the master.
const BEAT: Time = Time::from_ms(50);

/// What was found of frames at even distances, and of those of a sweep.
pub struct Series<T> {
    even: Vec<T>,
    swept: Vec<T>,
}

/// Cycles of the frames of a series.
pub struct Cycles {
    /// Most of all frames.
    pub worst: u64,
    /// Median of the frames at even distances.
    pub median: u64,
    /// Most of the sweep.
    pub swept: u64,
}

impl<T> Series<T> {
    /// A part of what was found.
    pub fn cycles(&self, part: impl Fn(&T) -> u64) -> Cycles {
        let mut even: Vec<u64> = self.even.iter().map(&part).collect();
        even.sort_unstable();
        let swept = self.swept.iter().map(&part).max().unwrap_or(0);
        Cycles { worst: even[even.len() - 1].max(swept), median: even[even.len() / 2], swept }
    }
}

/// Sends `count` frames, one each `spacing`, then those of a sweep. Frame `n`, from 0, takes `duration(n)` from SOF until its receiver has
/// it; `send(rig, at, n)` sends it, follows it through the board and returns what it found.
///
/// # Errors
/// When the twin had to stop the board, and those of `send`.
pub fn series<T>(
    rig: &mut Rig,
    (count, spacing): (u32, Time),
    duration: impl Fn(u32) -> Time,
    mut send: impl FnMut(&mut Rig, Time, u32) -> anyhow::Result<T>,
) -> anyhow::Result<Series<T>> {
    let mut series = Series { even: Vec::new(), swept: Vec::new() };
    let mut at = rig.spacecraft.now();
    for number in 0..count {
        at += spacing;
        rig.send(Bus::Nominal, rig.spacecraft.now() + BREAK, MASTER_BEATS);
        series.even.push(send(rig, at, number)?);
    }
    let mut number = count;
    let mut beat = rig.spacecraft.now();
    for distance in (0..PASSES).flat_map(|_| DISTANCES) {
        if distance == DISTANCES.start {
            rig.run_until(rig.spacecraft.now() + PAUSE)?;
        }
        let end = rig.spacecraft.now() + PERIOD;
        while rig.spacecraft.now() < end {
            let now = rig.spacecraft.now();
            let wakes = rig.board().next_event();
            let at = (wakes + Time::from_us(distance)).since(BEFORE + duration(number));
            if wakes == Time::ZERO {
                rig.run_until(now + Time::from_us(10))?;
            } else if now + BREAK + BREAK < at && beat + BEAT < now {
                beat = now;
                rig.send(Bus::Nominal, now + Time::from_us(1), MASTER_BEATS);
                rig.run_until(now + BREAK)?;
            } else if at <= now {
                // Something else was going on shortly before.
                rig.run_until(wakes + Time::from_us(1))?;
            } else {
                series.swept.push(send(rig, at, number)?);
                number += 1;
            }
        }
    }
    Ok(series)
}
