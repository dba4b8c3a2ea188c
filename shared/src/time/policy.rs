//! Limits of the crystals of a network against each other, as the profile of a mission states them.

use super::estimator::{SHIFT, half, scale};
use crate::link::bit_timing::PartsPerMillion;

/// Most spacecraft times in a row that a policy may ask for.
const AGREEING: u8 = 40;

/// Limits of the crystals that drive the clocks of a network.
///
/// The error bound of a clock (2015h) holds as long as every crystal stays within them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClockPolicy {
    /// Largest deviation of a crystal from its nominal frequency, at any temperature and age. At most 900 ppm.
    pub tolerance: PartsPerMillion,
    /// Largest drift of two crystals against each other, in parts per billion per second. At most 3,500.
    pub drift: u32,
    /// Largest change of their rates against each other with temperature, in parts per billion.
    pub excursion: u32,
    /// Number of consecutive spacecraft times, 2 to 40, that have to agree with each other before they move a
    /// clock that they contradict.
    pub agreeing: u8,
}

impl ClockPolicy {
    /// Crystals of ±150 ppm that drift apart by at most 0.2 ppm/s and 2 ppm. Three times move a clock.
    pub const DEFAULT: ClockPolicy =
        ClockPolicy { tolerance: PartsPerMillion(150), drift: 200, excursion: 2_000, agreeing: 3 };

    /// Returns whether the estimator can follow such crystals.
    pub const fn is_sound(&self) -> bool {
        let is_represented = 0 < self.tolerance.0 && self.tolerance.0 <= 900;
        let drifts = 0 < self.drift && self.drift <= 3_500 && self.excursion <= 1_000_000;
        is_represented && drifts && 2 <= self.agreeing && self.agreeing <= AGREEING
    }

    pub(super) const fn limits(&self) -> Limits {
        // Beyond its limits a policy counts as the nearest one that is sound.
        let tolerance = if self.tolerance.0 > 900 { 900 } else { self.tolerance.0 };
        let drift = if self.drift > 3_500 { 3_500 } else { self.drift };
        let ramp = if drift == 0 { 0 } else { ((self.excursion as i64) << 32) / drift as i64 };
        Limits {
            rate: rate(tolerance as i64 * 2_000),
            drift: rate(drift as i64),
            ramp,
            agreeing: if self.agreeing > AGREEING { AGREEING } else { self.agreeing },
        }
    }
}

/// A policy in the units of the clock.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Limits {
    /// Largest rate of two crystals against each other. 2^-40.
    pub rate: i32,
    /// Largest drift. 2^-40 per second.
    pub drift: i32,
    /// Time in which the largest drift makes the largest excursion, units of 2^-32 s.
    pub ramp: i64,
    pub agreeing: u8,
}

impl Limits {
    /// Returns the largest change of the rate within a span, in units of 2^-40.
    pub fn drift_over(&self, span: i64) -> i64 {
        scale(self.drift.into(), span.min(self.ramp))
    }

    /// Returns the largest offset that this change adds, in units of 2^-32 s.
    pub fn ramp_over(&self, span: i64) -> i64 {
        ramp(self.drift.into(), self.ramp, span)
    }
}

/// Offset after `span` by a rate that grows by `drift` (2^-40 per second) for at most `most`. Units of 2^-32 s.
pub(super) fn ramp(drift: i64, most: i64, span: i64) -> i64 {
    let drifting = span.min(most);
    scale((span - half(drifting)) >> SHIFT, scale(drift, drifting))
}

/// Parts per billion as 2^-40.
const fn rate(ppb: i64) -> i32 {
    ((ppb << 40) / 1_000_000_000) as i32
}
