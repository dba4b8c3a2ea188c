//! Spans of the node's clock in units of spacecraft time, and what they are at another rate.

use crate::types::FineInstant;

/// Seconds and 2^-32 of them.
#[derive(Clone, Copy)]
pub(super) struct Span {
    seconds: u32,
    fraction: u32,
}

/// The drift counts this long: 128 s, in units of 2^-16 s.
const HORIZON: u64 = 128 << 16;

impl Span {
    /// From an instant to a later one, rounded down; none when it is the earlier one.
    #[inline(never)] // two divisions of 64 bits
    pub fn between(from: FineInstant, to: FineInstant) -> Span {
        let units = to.units().saturating_sub(from.units());
        let seconds = units / PER_SECOND;
        let rest = units - seconds * PER_SECOND;
        // 2^32 / 256,000,000 is 2^18 / 15,625.
        let fraction = ((rest << 18) / 15_625) as u32;
        Span { seconds: u32::try_from(seconds).unwrap_or(u32::MAX), fraction }
    }

    /// Units of 2^-32 s.
    pub fn units(self) -> u64 {
        u64::from(self.seconds) << 32 | u64::from(self.fraction)
    }

    /// This span by a clock whose rate is `rate` (2^-40) higher at its beginning, and grows by `drift` (2^-48) each second
    /// until the horizon.
    pub fn advance(self, rate: i64, drift: i64) -> u64 {
        let gained = self.gained(drift);
        let drifting = self.drifting() as i64;
        let correction = self.times(rate + gained) - ((gained * drifting) >> 25);
        self.units().wrapping_add(correction as u64)
    }

    /// By how much the rate has grown after this span. 2^-40.
    pub fn gained(self, drift: i64) -> i64 {
        (drift * self.drifting() as i64) >> 24
    }

    /// A rate (2^-40) over this span, units of 2^-32 s.
    #[inline(never)] // multiplications of 64 bits
    pub fn times(self, rate: i64) -> i64 {
        (rate * i64::from(self.seconds) + ((rate * i64::from(self.fraction)) >> 32)) >> 8
    }

    /// How much of this span the drift counts, units of 2^-16 s.
    fn drifting(self) -> u64 {
        (self.units() >> 16).min(HORIZON)
    }
}

/// Units of [`FineInstant`] in a second.
pub(super) const PER_SECOND: u64 = FineInstant::PER_MICRO * 1_000_000;
