//! Kalman filter of the local clock: how well offset, rate and drift are known, and the gains that follow.
//!
//! The three states of the usual clock model: offset from spacecraft time, rate (its derivative) and drift (the derivative
//! of the rate), each with process noise. White frequency noise walks the offset, random walk of frequency walks the rate,
//! and a small noise lets the drift follow the temperature. R. E. Kalman, "A New Approach to Linear Filtering and Prediction
//! Problems" (1960); the clock model is that of C. Zucca and P. Tavella, "The Clock Model and Its Relationship with the Allan
//! and Related Variances" (IEEE Trans. UFFC, 2005). The full covariance is kept, so that intervals may be irregular, and
//! the bound of a holdover is that of the filter itself.
//!
//! One unit is 2^-32 s (0.23 ns), one of rate a unit per second (0.23 ppb). Variances have 12 binary places.

/// Variances and covariances of offset (0), rate (1) and drift (2), in squared units and 2^-12 of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Covariance {
    p00: i64,
    p01: i64,
    p02: i64,
    p11: i64,
    p12: i64,
    p22: i64,
}

/// What part of an innovation goes to offset, rate (per second) and drift (per square second). 2^-32.
pub(super) struct Gains {
    pub offset: i64,
    pub rate: i64,
    pub drift: i64,
}

impl Gains {
    /// The whole offset, and nothing of rate and drift.
    pub const OFFSET: Gains = Gains { offset: 1 << 32, rate: 0, drift: 0 };
}

/// Binary places of variances.
pub(super) const PLACES: u32 = 12;

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
const WALK_OF_DRIFT: i64 = 756;

/// The least variances that rounding may leave of rate and drift.
const LEAST: i64 = 1 << 6;

/// A pair leaves 2^-24 of the variance of the offset at least, so that gains of 32 bits are exact enough.
const RESOLVED: u32 = 24;

/// Variance of a standard deviation in nanoseconds, or of one in nanoseconds per second.
pub(super) const fn variance(ns: i64) -> i64 {
    let units = ns * 4_295 / 1_000;
    (units * units) << PLACES
}

impl Covariance {
    /// An offset of the variance `noise`; nothing is known of rate and drift.
    pub const fn fresh(noise: i64) -> Self {
        Covariance { p00: noise, p01: 0, p02: 0, p11: PRIOR_RATE, p12: 0, p22: PRIOR_DRIFT }
    }

    /// The offset was replaced by one of the variance `noise`. Rate and drift are known as before.
    pub fn replace_offset(&mut self, noise: i64) {
        (self.p00, self.p01, self.p02) = (noise, 0, 0);
    }

    /// After `span`, units of time, without a pair.
    #[must_use]
    pub fn after(&self, span: i64) -> Self {
        let mut p = self.clone();
        let walk = scale(WALK_OF_RATE / 2, span);
        p.p11 += walk;
        p.shear_rate(span / 2);
        // Long intervals: what comes of the rate is held below the limit, without a change of its correlations.
        while scale(scale(p.p11, span), span) > MOST / 4 {
            (p.p11, p.p01, p.p12) = (p.p11 / 4, p.p01 / 2, p.p12 / 2);
        }
        p.shear_offset(span);
        p.shear_rate(span / 2);
        p.p00 = least(p.p00 + scale(WALK_OF_OFFSET, span));
        p.p11 = least(p.p11 + walk);
        p.p22 = least(p.p22 + scale(WALK_OF_DRIFT, span));
        p
    }

    /// Rate grows by `span` times the drift.
    fn shear_rate(&mut self, span: i64) {
        let p12 = self.p12 + scale(self.p22, span);
        self.p11 += scale(self.p12 + p12, span);
        self.p01 += scale(self.p02, span);
        self.p12 = p12;
    }

    /// Offset grows by `span` times the rate.
    fn shear_offset(&mut self, span: i64) {
        let p01 = self.p01 + scale(self.p11, span);
        self.p00 += scale(self.p01 + p01, span);
        self.p02 += scale(self.p12, span);
        self.p01 = p01;
    }

    /// Standard deviation of the offset, or of a pair of the variance `noise` against it, in units.
    pub fn deviation(&self, noise: i64) -> u32 {
        root(((self.p00 + noise) >> PLACES) as u64)
    }

    /// A pair of the variance `noise` is taken.
    pub fn update(&mut self, noise: i64) -> Gains {
        let noise = noise.max(self.p00 >> RESOLVED);
        let innovation = self.p00 + noise;
        let gains = Gains {
            offset: ratio(self.p00, innovation),
            rate: ratio(self.p01, innovation),
            drift: ratio(self.p02, innovation),
        };
        self.p11 = least(self.p11 - scale(self.p01, gains.rate));
        self.p12 -= scale(self.p02, gains.rate);
        self.p22 = least(self.p22 - scale(self.p02, gains.drift));
        // With the variance of the pair, not with the difference from one: that is next to nothing where an offset was not known.
        self.p00 = scale(noise, gains.offset);
        self.p01 = scale(noise, gains.rate);
        self.p02 = scale(noise, gains.drift);
        gains
    }
}

/// `value` times `factor` / 2^32, rounded down, at most [`MOST`] either way.
#[inline(never)] // 128 bits on a chip of 32
pub(super) const fn scale(value: i64, factor: i64) -> i64 {
    let product = (value as i128 * factor as i128) >> 32;
    if product > MOST as i128 {
        MOST
    } else if product < -MOST as i128 {
        -MOST
    } else {
        product as i64
    }
}

/// `part` / `whole` in units of 2^-32; `whole` is positive, `part` below it by size or up to 2^20 times above.
#[inline(never)] // three times
const fn ratio(part: i64, whole: i64) -> i64 {
    let largest =
        if part.unsigned_abs() > whole.unsigned_abs() { part.unsigned_abs() } else { whole.unsigned_abs() };
    let excess = 33_u32.saturating_sub(largest.leading_zeros());
    let whole = whole >> excess;
    ((part >> excess) << 32) / if whole > 0 { whole } else { 1 }
}

/// A variance that stays within what can be reckoned with.
const fn least(variance: i64) -> i64 {
    if variance < LEAST {
        LEAST
    } else if variance > MOST {
        MOST
    } else {
        variance
    }
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
