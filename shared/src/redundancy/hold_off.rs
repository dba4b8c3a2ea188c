//! What a slave with parallel access makes of heartbeats of the master on both buses.
//!
//! There is one master, so one of the two is forged, or comes from a faulty node. A slave cannot know which from the
//! first one: it may be the first message after a change of the bus, and it follows. The next heartbeat on the bus that
//! it left is the contradiction. Then the bus counts on which the master works, and where that does not decide, the one on
//! which it was before.

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
    /// No heartbeats yet.
    pub const fn new() -> Self {
        Rhythm { gaps: [0; 4], count: 0 }
    }

    /// Two heartbeats in a row on one bus.
    #[inline]
    pub fn note(&mut self, gap: Duration) {
        if let Some(oldest) = self.gaps.get_mut(usize::from(self.count & 3)) {
            *oldest = gap.as_micros().min(u64::from(u32::MAX)) as u32;
        }
        self.count = self.count.wrapping_add(1);
    }

    /// Silence after which the master has left a bus: one and a half of the longest gap, half the consumer time when no
    /// gap is known. Heartbeats of an intruder on the same bus shorten the gaps: the period of this node's own heartbeat
    /// counts as one.
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
    /// When.
    pub at: Instant,
    /// The last heartbeat on the bus that was left.
    pub last: Instant,
    /// Bdefault before.
    pub bdefault: Bus,
    /// The heartbeats on the bus that was left.
    pub rhythm: Rhythm,
}

impl Move {
    /// Whether a heartbeat on the bus that was left, which ended at `at`, was under way when the master left.
    pub fn was_under_way(&self, at: Instant) -> bool {
        at <= self.at + UNDER_WAY
    }

    /// Whether a heartbeat on the bus that was left, which ended at `at`, continues those before the move: later the master
    /// has left that bus, whatever comes there.
    pub fn is_open(&self, at: Instant, parameters: &Parameters) -> bool {
        at < self.at + self.rhythm.patience(parameters)
    }
}

/// On which bus the master works: frames of its services (SYNC, SDO, PDO) that came on each. A node that forges or repeats
/// heartbeats does not do the master's work.
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
    /// None seen.
    pub const fn new() -> Self {
        let none = PerBus { nominal: 0, redundant: 0 };
        Work { frames: none, before: none, since: Instant::ZERO }
    }

    /// Looks at what comes from now on.
    pub fn restart(&mut self, now: Instant) {
        (self.before, self.since) = (self.frames, now);
    }

    /// Looks at what comes from now on, unless that has just begun.
    pub fn renew(&mut self, now: Instant, patience: Duration) {
        if now >= self.since + patience {
            self.restart(now);
        }
    }

    /// Whether all work was done on `bus`, and some was.
    pub fn is_only_on(&self, bus: Bus) -> bool {
        let is_done = |bus| self.frames[bus] != self.before[bus];
        is_done(bus) && !is_done(bus.other())
    }
}

#[cfg(feature = "model")]
mod relative;
