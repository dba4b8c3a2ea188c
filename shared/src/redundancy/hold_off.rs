//! Resolves contradicting heartbeats: a slave with parallel access hears a master on both buses.
//!
//! There is one master, so one of the two heartbeats is forged, or comes from a faulty node. The first heartbeat on
//! the other bus does not show which: it may be the first message after a change of the bus, and the slave follows
//! it. The next heartbeat on the old bus is the contradiction. Then the bus counts on which the master works. If
//! that does not decide, the bus counts on which the master was before.

use super::Parameters;
use crate::types::{Bus, Duration, Instant, PerBus};

/// A heartbeat on the bus that was left is no contradiction so soon after the move: it was under way when the master
/// changed the bus.
pub(super) const UNDER_WAY: Duration = Duration::from_millis(5);

/// Gaps between the last heartbeats of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Rhythm {
    /// Microseconds; zero is unknown.
    gaps: [u32; 4],
    /// Gaps noted; wraps. The next one takes the place of the oldest.
    count: u8,
}

impl Rhythm {
    /// Makes an empty record of gaps.
    pub const fn new() -> Self {
        Rhythm { gaps: [0; 4], count: 0 }
    }

    /// Records the time between two consecutive heartbeats on one bus.
    #[inline]
    pub fn note(&mut self, gap: Duration) {
        if let Some(oldest) = self.gaps.get_mut(usize::from(self.count & 3)) {
            *oldest = gap.as_micros().min(u64::from(u32::MAX)) as u32;
        }
        self.count = self.count.wrapping_add(1);
    }

    /// Returns the silence after which the master counts as gone from a bus: 1.5 times the longest recorded gap, or
    /// half the consumer time if none was recorded.
    ///
    /// Heartbeats of an intruder on the same bus make gaps shorter. Therefore the period of this node's own
    /// heartbeat is the least gap that counts.
    pub fn patience(&self, parameters: &Parameters) -> Duration {
        let longest = self.gaps.iter().copied().max().unwrap_or(0);
        if longest == 0 {
            return Duration::from_micros(parameters.consumer.as_micros() / 2);
        }
        let gap = parameters.producer.max(Duration::from_micros(u64::from(longest)));
        Duration::from_micros(gap.as_micros() * 3 / 2)
    }
}

/// A change of the bus that a heartbeat on the old one can still take back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Move {
    /// End of the heartbeat that caused the move.
    pub at: Instant,
    /// End of the last heartbeat on the bus that was left.
    pub last: Instant,
    /// Bdefault before the move.
    pub bdefault: Bus,
    /// Gaps between the heartbeats on the bus that was left.
    pub rhythm: Rhythm,
}

impl Move {
    /// Returns whether a heartbeat on the bus that was left, which ended at `at`, was on its way when the master
    /// left.
    pub fn was_under_way(&self, at: Instant) -> bool {
        at <= self.at + UNDER_WAY
    }

    /// Returns whether a heartbeat on the bus that was left, which ended at `at`, continues those before the
    /// move. Later the master has left that bus, and what arrives there does not count.
    pub fn is_open(&self, at: Instant, parameters: &Parameters) -> bool {
        at < self.at + self.rhythm.patience(parameters)
    }
}

/// On which bus the master works: frames of its services (SYNC, SDO, PDO) that came on each. A node that forges or
/// repeats heartbeats does not do the master's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Work {
    /// Frames since power-on; wraps.
    pub frames: PerBus<u32>,
    /// As it was at `since`.
    before: PerBus<u32>,
    since: Instant,
}

impl Work {
    /// Makes a record without frames.
    pub const fn new() -> Self {
        let none = PerBus { nominal: 0, redundant: 0 };
        Work { frames: none, before: none, since: Instant::ZERO }
    }

    /// Starts the observation at `now`.
    pub fn restart(&mut self, now: Instant) {
        (self.before, self.since) = (self.frames, now);
    }

    /// Starts the observation again, unless it began less than `patience` ago.
    pub fn renew(&mut self, now: Instant, patience: Duration) {
        if now >= self.since + patience {
            self.restart(now);
        }
    }

    /// Returns whether the master worked on `bus`, and not on the other one.
    pub fn is_only_on(&self, bus: Bus) -> bool {
        let is_done = |bus| self.frames[bus] != self.before[bus];
        is_done(bus) && !is_done(bus.other())
    }
}

#[cfg(feature = "model")]
mod relative;
