//! Kalman filter of the local clock: the uncertainty of offset, rate and drift, and the gains that follow.
//!
//! The three states of the usual clock model: offset from spacecraft time, rate (its derivative) and drift (the
//! derivative of the rate), each with process noise. White frequency noise walks the offset, random walk of
//! frequency walks the rate, and a small noise lets the drift follow the temperature. R. E. Kalman, "A New Approach
//! to Linear Filtering and Prediction Problems" (1960); the clock model is that of C. Zucca and P. Tavella, "The
//! Clock Model and Its Relationship with the Allan and Related Variances" (IEEE Trans. UFFC, 2005). The full
//! covariance is kept, so that intervals may be irregular, and the bound of a holdover is that of the filter
//! itself.
//!
//! One unit is 2^-32 s (0.23 ns), one of rate a unit per second (0.23 ppb). Variances have 8 binary places.

use crate::types::FineInstant;

/// Offset, rate and drift.
pub(super) type State = [i64; 3];

/// Variances and covariances of the state, in squared units and 2^-8 of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Covariance([State; 3]);

/// Parts of an innovation that go to offset, rate (per second) and drift (per square second), in units of 2^-32.
pub(super) type Gains = State;

/// Binary places of variances.
pub(super) const PLACES: u32 = 8;

/// Binary places of a rate in units of 2^-40 beyond those of one in units of 2^-32.
pub(super) const SHIFT: u32 = 8;

/// No entry grows beyond this, so that no sum of some of them overflows.
pub(super) const MOST: i64 = 1 << 59;

/// Rate before the first two pairs: 100 ppm, two crystals of ±50 ppm.
const PRIOR_RATE: i64 = variance(100_000);

/// Drift before the first three pairs: 0.3 ppm/s.
const PRIOR_DRIFT: i64 = variance(300);

/// White frequency noise of both crystals, per second: (1.4 ns)².
const WALK_OF_OFFSET: i64 = 37 << PLACES;

/// Random walk of the frequency of both crystals, per second: (2.8 ppb)².
const WALK_OF_RATE: i64 = 148 << PLACES;

/// Change of the drift, per second: (0.1 ppb/s)².
const WALK_OF_DRIFT: i64 = 47;

/// A pair leaves 2^-24 of the variance of the offset at least, so that gains of 32 bits are exact enough.
const RESOLVED: u32 = 24;

/// Variance of a standard deviation in nanoseconds, or of one in nanoseconds per second.
pub(super) const fn variance(ns: i64) -> i64 {
    let units = units(ns);
    (units * units) << PLACES
}

/// Nanoseconds in units of 2^-32 s.
pub(super) const fn units(ns: i64) -> i64 {
    ns * 4_295 / 1_000
}

impl Covariance {
    /// Makes the covariance after one pair with the variance `noise`. The variance of the offset is 16 times
    /// that, because no other pair confirms it. Rate and drift are unknown.
    #[inline(never)] // more than a call
    pub const fn fresh(noise: i64) -> Self {
        Covariance([[noise * 16, 0, 0], [0, PRIOR_RATE, 0], [0, 0, PRIOR_DRIFT]])
    }

    /// Replaces the offset by one with the variance `noise`, `span` after the last pair.
    pub fn replace_offset(&mut self, noise: i64, span: i64) {
        *self = self.after(span);
        let [[p00, ..], ..] = &mut self.0;
        *p00 = noise;
    }

    /// Returns the covariance after `span`, in units of time, without a pair.
    #[must_use]
    pub fn after(&self, span: i64) -> Self {
        let mut this = self.clone();
        let walk = scale(WALK_OF_RATE / 2, span) + 1;
        this.0[1][1] += walk;
        this.advance_rows(span);
        this.transpose();
        this.advance_rows(span);
        this.0[0][0] += scale(WALK_OF_OFFSET, span);
        this.0[1][1] += walk;
        this.0[2][2] += scale(WALK_OF_DRIFT, span) + 1;
        this
    }

    fn advance_rows(&mut self, span: i64) {
        self.0.iter_mut().for_each(|row| advance(row, span));
    }

    fn transpose(&mut self) {
        let Covariance([[p00, p01, p02], [p10, p11, p12], [p20, p21, p22]]) = *self;
        self.0 = [[p00, p10, p20], [p01, p11, p21], [p02, p12, p22]];
    }

    /// Returns the standard deviation of the offset, or of a pair with the variance `noise` against it, in units.
    pub fn deviation(&self, noise: i64) -> u32 {
        root(((self.0[0][0] + noise) >> PLACES) as u64)
    }

    /// Takes a pair with the variance `noise`. Returns the gains for it.
    pub fn update(&mut self, noise: i64) -> Gains {
        let first = self.0[0];
        let innovation = first[0] + noise.max(first[0] >> RESOLVED);
        let largest = first.iter().fold(innovation, |largest, p| largest | p.abs());
        let excess = 33_u32.saturating_sub(largest.leading_zeros());
        let whole = (innovation >> excess) as u32 | 1;
        let mut gains = [0; 3];
        for (row, gain) in self.0.iter_mut().zip(&mut gains) {
            *gain = ((row[0] >> excess) << 32) / i64::from(whole);
            subtract(row, &first, *gain);
        }
        // Rounding leaves no variance below zero, and one matrix that is symmetric.
        let Covariance([[p00, p01, p02], [_, p11, p12], [_, _, p22]]) = *self;
        self.0 = [[p00, p01, p02], [p01, positive(p11), p12], [p02, p12, positive(p22)]];
        gains
    }
}

/// The state `span` later: offset grows by the rate, rate by the drift.
pub(super) fn advance([offset, rate, drift]: &mut State, span: i64) {
    let change = scale(*drift, half(span));
    *rate += change;
    *offset += scale(*rate, span);
    *rate += change;
}

/// Half of a number, rounded down. A compiler that optimises for size makes a division of `/ 2`, of 500 cycles (row
/// `rx.inside_look_accelerated`).
pub(super) const fn half(number: i64) -> i64 {
    number >> 1
}

/// `value` times `factor` / 2^32, rounded down, at most [`MOST`] either way.
#[inline(never)] // 128 bits on a chip of 32
pub(super) const fn scale(value: i64, factor: i64) -> i64 {
    let product = (value as i128 * factor as i128) >> 32;
    let (low, high) = (product as i64, (product >> 59) as i64);
    let sign = high >> 63;
    if high == sign { low } else { MOST ^ sign }
}

/// From an instant to a later one, in units of 2^-32 s, rounded down; none when it is the earlier one, 35 years at
/// most.
#[inline(never)] // 128 bits on a chip of 32
pub(super) fn elapsed(from: FineInstant, to: FineInstant) -> i64 {
    let units = to.units().saturating_sub(from.units()).min(1 << 58) as i64;
    units * 16 + ((i128::from(units) * i128::from(REST)) >> 63) as i64
}

/// 2^32 / 256,000,000 less 16, rounded up, 2^-63.
const REST: i64 = ((((1 << 24) - 16_000_000) << 63) / 1_000_000 + 1_i128) as i64;

/// `value`, at most `limit` either way.
#[inline(never)] // three times
pub(super) fn limited(value: i64, limit: i32) -> i32 {
    let limit = i64::from(limit);
    value.min(limit).max(-limit) as i32
}

/// `part` of `whole` is taken from `row`.
fn subtract([p0, p1, p2]: &mut State, [w0, w1, w2]: &State, part: i64) {
    *p0 -= scale(*w0, part);
    *p1 -= scale(*w1, part);
    *p2 -= scale(*w2, part);
}

/// `value`, or zero when it is less.
const fn positive(value: i64) -> i64 {
    value & !(value >> 63)
}

/// Square root, rounded down.
const fn root(value: u64) -> u32 {
    let (mut root, mut bit) = (0_u32, 1_u32 << 31);
    while bit != 0 {
        let next = root | bit;
        if next as u64 * next as u64 <= value {
            root = next;
        }
        bit >>= 1;
    }
    root
}
