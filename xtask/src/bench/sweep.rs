//! Frames at regular intervals, and frames that arrive during timed actions of the board: checks of its controllers,
//! heartbeats, timers.
//!
//! Frames at regular intervals arrive then only by chance. In a sweep frames arrive at a given time from the instants
//! at which the board wakes up by itself. This time increases by a microsecond every 100 ms.

use std::ops::Range;

use can_twin::spacecraft::Bus;
use can_twin::wire::time::Time;

use crate::bench::rig::{MASTER_BEATS, Rig};

/// Time from earlier activity to the heartbeat of the master that precedes a frame.
const BREAK: Time = Time::from_us(500);

/// Duration of each time distance, in which actions that are due ten times a second occur once.
const PERIOD: Time = Time::from_ms(100);

/// Distances, microseconds, counted from [`BEFORE`]. The last frame arrives when all is done.
const DISTANCES: Range<u64> = 0..50;

/// Time by which the first frame arrives before the board wakes up. The node does not have it yet at the wake-up.
const BEFORE: Time = Time::from_us(5);

/// Number of passes through the distances.
const PASSES: usize = 2;

/// Time before a pass. Frames shift checks, so that another one is then the first in a close sequence.
const PAUSE: Time = Time::from_ms(37);

/// Period of heartbeats of the master.
const BEAT: Time = Time::from_ms(50);

/// Results of frames at regular intervals, and of those of a sweep.
pub struct Series<T> {
    even: Vec<T>,
    swept: Vec<T>,
}

/// Cycles of the frames of a series.
pub struct Cycles {
    /// Largest value of all frames.
    pub worst: u64,
    /// Median of the frames at regular intervals.
    pub median: u64,
    /// Largest value of the sweep.
    pub swept: u64,
}

impl<T> Series<T> {
    /// Returns the cycles of a part of the results.
    pub fn cycles(&self, part: impl Fn(&T) -> u64) -> Cycles {
        let mut even: Vec<u64> = self.even.iter().map(&part).collect();
        even.sort_unstable();
        let swept = self.swept.iter().map(&part).max().unwrap_or(0);
        Cycles { worst: even[even.len() - 1].max(swept), median: even[even.len() / 2], swept }
    }
}

/// Sends `count` frames, one each `spacing`, then those of a sweep. Frame `n`, from 0, takes `duration(n)` from SOF
/// until its receiver has it; `send(rig, at, n)` sends it, follows it through the board and returns its result.
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
                // There was other activity shortly before.
                rig.run_until(wakes + Time::from_us(1))?;
            } else {
                series.swept.push(send(rig, at, number)?);
                number += 1;
            }
        }
    }
    Ok(series)
}
