//! Budget: the number of frames that a node may send.
//!
//! A *token bucket* holds a number of tokens. A frame takes one, and the bucket fills again at a fixed rate. There
//! is a bucket for each COB-ID and one for the node:
//!
//! | frames | bucket of the COB-ID | bucket of the node |
//! | --- | --- | --- |
//! | [vital](is_vital) frames and emergencies | yes | no |
//! | SDO | no | no |
//! | all others | yes | yes |
//!
//! SDO is limited by its confirmations: a client asks for each frame, or for a sub-block of at most 127. An empty
//! bucket refuses frames until it is full again. If the bucket of the node is empty, the node is silent for a time.
//!
//! # Limits
//!
//! The pre-defined COB-IDs of one slave have a bucket each. The COB-IDs of a master for its slaves share sixteen
//! buckets.

use super::queue::is_vital;
use crate::types::{CobId, Duration, Instant};

/// Buckets of what the network lives on, and as many of all others: none of these can close one of those.
const BUCKETS: usize = 16;
/// Time without a refusal after which the error ends.
const CALM: Duration = Duration::from_millis(1_000);

/// Returns whether this is an SDO response or request.
pub const fn is_sdo(id: CobId) -> bool {
    matches!(id.function(), 0x580 | 0x600)
}

/// Frames that may be sent at once, and frames per second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rate {
    /// Time in which a token comes back, microseconds.
    period: u32,
    /// Frames at once in the low half; in the high one a checksum, which each bit changes.
    sealed: u32,
}

impl Rate {
    /// Allows `burst` frames at once from a full bucket, and `per_second` on average.
    ///
    /// # Panics
    /// If one of them is zero. In a constant this is a compile error.
    pub const fn new(burst: u16, per_second: u16) -> Rate {
        assert!(burst > 0 && per_second > 0, "a rate without frames");
        let period = 1_000_000 / per_second as u32;
        Rate { period, sealed: burst as u32 | Self::checksum(period, burst) << 16 }
    }

    const fn checksum(period: u32, burst: u16) -> u32 {
        !(period ^ period >> 16 ^ burst as u32) & 0xFFFF
    }

    const fn burst(self) -> u16 {
        self.sealed as u16
    }

    /// Returns whether no bit of the rate has flipped.
    const fn is_intact(self) -> bool {
        self.sealed >> 16 == Self::checksum(self.period, self.burst())
    }

    /// Returns the time in which an empty bucket is full again, microseconds.
    const fn whole(self) -> u32 {
        self.period.saturating_mul(self.burst() as u32)
    }

    /// Returns whether frames with this period take at most half of the rate. A period of zero means no frames.
    pub const fn is_twice(self, period: Duration) -> bool {
        let us = period.as_micros();
        us == 0 || (us >= 2 * self.period as u64 && self.burst() > 1)
    }

    /// Returns whether the rate admits everything that `other` admits.
    pub const fn is_at_least(self, other: Rate) -> bool {
        self.period <= other.period && self.burst() >= other.burst()
    }
}

/// Number of frames that the nodes of a mission may send, and reaction to more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BudgetPolicy {
    /// Rate of the frames with one COB-ID.
    pub cob_id: Rate,
    /// Rate of all frames of a slave that count for the node.
    pub slave: Rate,
    /// Rate of all frames of the master that count for the node. The master sends to every slave.
    pub master: Rate,
    /// Rate of the frames that the master receives from one slave on the active bus, without SDO. Above it the
    /// master stops that slave.
    pub heard: Rate,
    /// Time for which a node above its budget is silent.
    pub silence: Duration,
}

/// Tokens of a COB-ID or of a node, one for each frame that may be sent now.
///
/// Its times are microseconds, which wrap after 71 minutes: on a chip of 32 bits they cost a third. A sender that is
/// silent for just so long finds the bucket as it was then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Bucket {
    full_at: u32,
    /// It was empty, and is not full again.
    is_closed: bool,
}

impl Bucket {
    /// Bucket with all its tokens.
    pub const FULL: Bucket = Bucket { full_at: 0, is_closed: false };

    /// Takes a token at `now`, in microseconds. Returns whether there was one. A bucket that was empty has none until
    /// it is full again. A rate of which a bit has flipped admits every frame.
    #[inline(never)] // of several callers
    pub fn take(&mut self, rate: Rate, now: u32) -> bool {
        let whole = rate.whole();
        let mut missing = self.full_at.wrapping_sub(now);
        if missing > whole {
            // More than an empty one misses: that was in the past.
            missing = 0;
        }
        let after = missing.wrapping_add(rate.period);
        let is_over = after > whole || (self.is_closed && missing > 0);
        self.is_closed = is_over && rate.is_intact();
        if !self.is_closed {
            self.full_at = now.wrapping_add(after);
        }
        !self.is_closed
    }
}

/// Reason why a frame is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Over {
    /// The frames with this COB-ID are above their budget.
    CobId,
    /// The node is above its budget and becomes silent.
    Node,
    /// The node is silent already.
    Silent,
}

/// Change of state of a node that was above its budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BudgetStep {
    /// The silence is over: the node sends again.
    Resume,
    /// No frame was refused for a second: the error is gone.
    Calm,
}

/// Token buckets of a node.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Budget {
    cob_id: Rate,
    node: Rate,
    silence: Duration,
    buckets: [Bucket; 2 * BUCKETS],
    whole: Bucket,
    is_silent: bool,
    /// End of the silence, or of what was reported.
    until: Instant,
}

impl Budget {
    /// Makes the budget of a slave. All buckets are full.
    pub const fn of_slave(policy: &BudgetPolicy) -> Self {
        Self::new(policy.cob_id, policy.slave, policy.silence)
    }

    /// Makes the budget of a master. All buckets are full.
    pub const fn of_master(policy: &BudgetPolicy) -> Self {
        Self::new(policy.cob_id, policy.master, policy.silence)
    }

    const fn new(cob_id: Rate, node: Rate, silence: Duration) -> Self {
        let buckets = [Bucket::FULL; 2 * BUCKETS];
        Budget {
            cob_id,
            node,
            silence,
            buckets,
            whole: Bucket::FULL,
            is_silent: false,
            until: Instant::NEVER,
        }
    }

    /// Returns whether the node is silent because it was above its budget.
    pub const fn is_silent(&self) -> bool {
        self.is_silent
    }

    /// Takes the tokens for a frame that is to go out. Returns the reason if the frame is refused.
    #[inline(never)] // registers of its own: half the code
    pub fn take(&mut self, id: CobId, now: Instant) -> Option<Over> {
        let over = self.over(id, now.as_micros() as u32)?;
        if over == Over::Node {
            (self.is_silent, self.until) = (true, now + self.silence);
        } else if !self.is_silent {
            self.until = now + CALM;
        }
        Some(over)
    }

    #[inline(always)] // called from one place
    fn over(&mut self, id: CobId, now: u32) -> Option<Over> {
        let raw = usize::from(id.raw());
        if is_sdo(id) {
            return None;
        }
        let is_vital = is_vital(id);
        if self.is_silent && !is_vital {
            return Some(Over::Silent);
        }
        // By Node-ID and function code.
        let place = (raw ^ raw >> 7) % BUCKETS + if is_vital { BUCKETS } else { 0 };
        if let Some(bucket) = self.buckets.get_mut(place)
            && !bucket.take(self.cob_id, now)
        {
            return Some(Over::CobId);
        }
        (!is_vital && !self.whole.take(self.node, now)).then_some(Over::Node)
    }

    /// Ends a silence that would be longer than the budget sets: a bit of its end flipped.
    pub fn confine(&mut self, now: Instant) {
        let is_set = self.is_silent || self.until < Instant::NEVER;
        if is_set && self.until.since(now) > self.silence.max(CALM) {
            self.until = now;
        }
    }

    /// Returns one change that is due. Call it until `None`.
    pub fn poll(&mut self, now: Instant) -> Option<BudgetStep> {
        if now < self.until {
            return None;
        }
        if core::mem::take(&mut self.is_silent) {
            self.until = now + CALM;
            return Some(BudgetStep::Resume);
        }
        self.until = Instant::NEVER;
        Some(BudgetStep::Calm)
    }

    /// Returns when to call [`Budget::poll`] next.
    pub fn deadline(&self) -> Option<Instant> {
        (self.until < Instant::NEVER).then_some(self.until)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a budget of which any bit of a rate flips, then frames at half of the rate are all admitted.
    #[test]
    fn flipped_bit_of_a_rate_refuses_no_frame() {
        let words: [fn(&mut Budget) -> &mut u32; 4] = [
            |budget| &mut budget.cob_id.period,
            |budget| &mut budget.cob_id.sealed,
            |budget| &mut budget.node.period,
            |budget| &mut budget.node.sealed,
        ];
        for (number, word) in words.iter().enumerate() {
            for bit in 0..u32::BITS {
                let silence = Duration::from_millis(100);
                let mut budget = Budget::new(Rate::new(20, 100), Rate::new(100, 500), silence);
                *word(&mut budget) ^= 1 << bit;
                for frame in 0..200 {
                    let now = Instant::ZERO + Duration::from_millis(20 * frame);
                    let over = budget.take(CobId::new(0x185).unwrap(), now);
                    assert_eq!(over, None, "word {number}, bit {bit}, frame {frame}");
                }
            }
        }
    }
}
