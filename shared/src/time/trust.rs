//! Error bound of the clock. It follows from the pairs that the clock took, with no other assumption than the
//! limits of the crystals.
//!
//! Each pair shows the difference between pair and clock. The source of a pair limits the error of the pair itself.
//! Two pairs bound the rate, because the crystals drift no faster than the profile states. After the last pair the
//! error grows by the unknown part of the rate, and by the largest ramp that the profile admits. So the bound does
//! not depend on how well the filter follows: while the filter lags, the difference is part of the bound.

use super::estimator::{SHIFT, elapsed, half, limited, scale};
use super::policy::Limits;
use crate::types::{FineInstant, FineScet};

/// Error bound that follows from the pairs.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Trust {
    /// Last pair, less the clock at its instant. Units of 2^-32 s.
    pub off: i64,
    /// The pair from which the rate is measured next.
    from: (FineInstant, FineScet),
    /// The rate as it was measured at the last pair. 2^-40.
    rate: i32,
    /// Largest error of that measurement. 2^-40.
    unsure: i32,
}

impl Trust {
    /// Makes a bound with no other knowledge than the tolerance of the crystals.
    pub const fn new(limits: &Limits) -> Self {
        let from = (FineInstant::from_units(0), FineScet::from_units(0));
        Trust { off: 0, from, rate: 0, unsure: limits.rate }
    }

    /// Notes that the clock was set to `scet` at `at`, `silence` after the last pair. Its rate did not change.
    pub fn set(&mut self, at: FineInstant, scet: FineScet, silence: i64, limits: &Limits) {
        (self.off, self.from) = (0, (at, scet));
        self.unsure = limited(i64::from(self.unsure) + limits.drift_over(silence), limits.rate);
    }

    /// Forgets the rate.
    pub fn forget_rate(&mut self, limits: &Limits) {
        (self.rate, self.unsure) = (0, limits.rate);
    }

    /// Takes a pair of the same source as the one before, `silence` earlier. The error of each is at most
    /// `error`.
    pub fn measure(&mut self, at: FineInstant, scet: FineScet, silence: i64, error: i64, limits: &Limits) {
        let aged = i64::from(self.unsure) + limits.drift_over(silence);
        let (before, then) = self.from;
        let span = elapsed(before, at);
        // The mean of the rate is as far from its present value as the drift makes it in half of the span.
        let drift = limits.drift_over(half(span));
        let noise = rate_of(2 * error, span);
        self.unsure = limited(aged, limits.rate);
        if noise + drift < aged {
            self.unsure = limited(noise + drift, limits.rate);
            self.rate = limited(rate_of(scet.since(then).saturating_sub(span), span), limits.rate);
        }
        // A longer span would add more drift than it removes noise.
        if drift >= noise {
            self.from = (at, scet);
        }
    }

    /// Returns the largest error of `rate`, in units of 2^-40, at the last pair.
    pub fn rate_error(&self, rate: i32) -> i64 {
        (i64::from(rate) - i64::from(self.rate)).abs() + i64::from(self.unsure)
    }

    /// Returns the most that the error grows by in a span after the last pair, in units of 2^-32 s. `rate_error`:
    /// error of the rate.
    pub fn growth(rate_error: i64, span: i64, limits: &Limits) -> i64 {
        scale(span >> SHIFT, rate_error) + limits.ramp_over(span)
    }
}

/// An offset per span as a rate, 2^-40.
pub(super) fn rate_of(offset: i64, span: i64) -> i64 {
    // Keeps the dividend within 62 bits.
    let places = (offset.unsigned_abs().leading_zeros().max(2) - 2).min(40);
    ((offset << places) / span.max(1)).saturating_mul(1 << (40 - places))
}
