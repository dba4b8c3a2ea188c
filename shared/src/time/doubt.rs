//! Pairs that contradict the clock: decides whether the pairs or the clock are wrong.
//!
//! A pair contradicts the clock if it differs from it by more than the error bounds of both. A forged or corrupted
//! pair must not move the clock. A wrong clock must be moved. Consecutive pairs that agree with each other decide.
//! They agree if the clock, shifted to one of them and running at its own rate, predicts the next one. After a
//! move, three times as many pairs have to confirm the clock. Until then the distance of the move is part of the
//! reported bound.

use super::estimator::MOST;
use crate::types::FineInstant;

/// Pairs that contradict the clock, and what they moved it by.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Doubt {
    /// Difference of the last such pair, in units of 2^-32 s; zero if there is none.
    differs: i64,
    /// Its instant.
    pub at: FineInstant,
    /// Weight of such pairs in a row: [`AGREES`] for each that agrees with the one before.
    weight: u8,
    /// One of them agrees at another rate alone.
    is_other_rate: bool,
    /// Distance by which they moved the clock.
    moved: i64,
    /// Pairs that are still to confirm it.
    unconfirmed: u8,
}

/// Weight of a pair that agrees with the one before at the rate of the clock. One that needs another rate within the
/// tolerance of the crystals has a weight of 1.
const AGREES: u8 = 3;

/// Agreement of a pair with the last one that contradicted the clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Agreement {
    /// At the rate of the clock.
    AtRate,
    /// At another rate that crystals can have.
    AtOtherRate,
    /// Not at all.
    None,
}

/// Effect of a contradicting pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is refused.
    Refused,
    /// The clock moves to it. Its rate is as it was.
    Moves,
    /// The clock moves to it, and its rate to that of the last two.
    MovesAtOtherRate,
}

impl Doubt {
    pub const fn new() -> Self {
        let at = FineInstant::from_units(0);
        Doubt { differs: 0, at, weight: 0, is_other_rate: false, moved: 0, unconfirmed: 0 }
    }

    /// Returns the distance by which this pair differs more than the last one, zero for the first.
    pub fn beyond(&self, differs: i64) -> i64 {
        if self.weight == 0 { 0 } else { differs.saturating_sub(self.differs) }
    }

    /// Takes a pair at `at` that differs from the clock by `differs`.
    pub fn contradicted(
        &mut self,
        at: FineInstant,
        differs: i64,
        agreement: Agreement,
        agreeing: u8,
    ) -> Verdict {
        match agreement {
            Agreement::AtRate => self.weight += AGREES,
            Agreement::AtOtherRate => (self.weight, self.is_other_rate) = (self.weight + 1, true),
            Agreement::None => (self.weight, self.is_other_rate) = (AGREES, false),
        }
        (self.differs, self.at) = (differs, at);
        let whole = agreeing.saturating_mul(AGREES);
        if self.weight < whole {
            return Verdict::Refused;
        }
        let verdict = if self.is_other_rate { Verdict::MovesAtOtherRate } else { Verdict::Moves };
        *self = Doubt { moved: distance(differs), unconfirmed: whole, ..Doubt::new() };
        verdict
    }

    /// Takes a pair that agrees with the clock.
    pub fn agreed(&mut self) {
        let unconfirmed = self.unconfirmed.saturating_sub(1);
        let moved = if unconfirmed == 0 { 0 } else { self.moved };
        *self = Doubt { moved, unconfirmed, ..Doubt::new() };
    }

    /// Returns the width that is added to the reported bound, in units of 2^-32 s.
    pub fn widens(&self) -> i64 {
        distance(self.differs) + self.moved
    }
}

/// A distance, at most [`MOST`]: 4 years.
fn distance(differs: i64) -> i64 {
    differs.clamp(-MOST, MOST).abs()
}
