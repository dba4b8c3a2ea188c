//! Counting sequences of 11 consecutive recessive bits.
//!
//! One such sequence synchronises a controller with the bus (RM0090 32.4.2); 128 of them end bus-off (32.7.6). In a
//! longer stretch every further 11 bits count again.

use can_wire::time::Time;

/// Bits of one sequence.
const SEQUENCE_BITS: u64 = 11;

/// A count in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecessiveCount {
    /// Bits before this instant do not count.
    since: Time,
    /// Start of the stretch that is being counted, and the sequences seen in it.
    stretch: Time,
    seen_in_stretch: u64,
    left: u64,
}

impl RecessiveCount {
    /// Waits from `since` on for `sequences` of 11 recessive bits.
    pub fn new(since: Time, sequences: u64) -> Self {
        RecessiveCount { since, stretch: since, seen_in_stretch: 0, left: sequences }
    }

    /// The line was recessive in `from..=to`; gives the end of the last sequence waited for once it is complete.
    pub fn observe(&mut self, from: Time, to: Time, span: impl Fn(u64) -> Time) -> Option<Time> {
        let stretch = from.max(self.since);
        if stretch != self.stretch {
            self.stretch = stretch;
            self.seen_in_stretch = 0;
        }
        while self.left > 0 && stretch + span(SEQUENCE_BITS * (self.seen_in_stretch + 1)) <= to {
            self.seen_in_stretch += 1;
            self.left -= 1;
        }
        (self.left == 0).then(|| stretch + span(SEQUENCE_BITS * self.seen_in_stretch))
    }

    /// When the count completes if the line stays recessive as it is since `from`.
    pub fn completes_at(&self, from: Time, span: impl Fn(u64) -> Time) -> Time {
        let stretch = from.max(self.since);
        let seen = if stretch == self.stretch { self.seen_in_stretch } else { 0 };
        stretch + span(SEQUENCE_BITS * (seen + self.left))
    }
}
