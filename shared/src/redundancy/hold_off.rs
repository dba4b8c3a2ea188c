//! Resolves contradicting heartbeats: a slave with parallel access hears a master on both buses.
//!
//! There is one master, so one of the two heartbeats is forged, or comes from a faulty node. The first heartbeat on
//! the other bus does not show which: it may be the first message after a change of the bus, and the slave follows
//! it. The next heartbeat on the old bus is the contradiction. Then the bus counts on which the master works. If
//! that does not decide, the bus counts on which the master was before.

use super::Parameters;
use crate::types::{Bus, Canonical, Duration, Instant, Instants, PerBus};

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

/// More than a shift of instants: records are equal that will always have the same patience.
impl Canonical for Rhythm {
    type Context = ();

    fn canonical(&mut self, _: Instant, (): &()) {
        // Oldest first. A gap that is shorter than a later one is forgotten before it, and never counts.
        self.gaps.rotate_left(usize::from(self.count & 3));
        self.count = 0;
        let mut longest = 0;
        for gap in self.gaps.iter_mut().rev() {
            longest = longest.max(*gap);
            *gap = longest;
        }
    }
}

/// A change of the bus that a heartbeat on the old one can still take back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[canonical(context = Parameters)]
pub(super) struct Move {
    /// End of the heartbeat that caused the move.
    #[canonical(age = self.rhythm.patience(context).max(UNDER_WAY))]
    pub at: Instant,
    /// End of the last heartbeat on the bus that was left. With the next one there it is a gap, however old.
    #[canonical(age = Duration::from_micros(u64::MAX))]
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

    /// Returns whether the move can be taken back or contradicted at `now` or later.
    pub fn has_effect(&self, now: Instant, parameters: &Parameters) -> bool {
        self.is_open(now, parameters) || self.was_under_way(now)
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

/// More than a shift of instants: of the numbers only the difference counts, and of that whether it is zero. The node
/// counts from zero again.
impl Canonical for Work {
    /// Patience of [`Work::renew`].
    type Context = Duration;

    fn canonical(&mut self, now: Instant, patience: &Duration) {
        let has_worked = |bus| self.frames[bus] != self.before[bus];
        self.before = PerBus::from_fn(|bus| u32::from(has_worked(bus)).wrapping_neg());
        self.frames = PerBus::default();
        self.since.age(now, *patience);
    }
}
