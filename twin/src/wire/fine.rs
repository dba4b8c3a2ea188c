//! Time within a bit: 2^-18 of a tick, so that an oscillator's error of 0.2 ppm shows in one time quantum.

use core::ops::{Add, Sub};

use crate::wire::time::Time;

/// Fractional bits of a tick.
const SHIFT: u32 = 18;

/// A point in virtual time, or a span, in units of 2^-18 ticks (11 fs). Reaches 58 hours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(in crate::wire) struct Fine(pub u64);

impl Fine {
    pub(in crate::wire) const NEVER: Fine = Fine(u64::MAX);

    pub(in crate::wire) const fn from_time(time: Time) -> Self {
        if time.0 >> (64 - SHIFT) != 0 { Fine::NEVER } else { Fine(time.0 << SHIFT) }
    }

    /// Rounds `ticks / per` to the nearest unit.
    pub(in crate::wire) fn from_ratio(ticks: u64, per: u64) -> Self {
        let (exact, per) = (u128::from(ticks) << SHIFT, u128::from(per));
        Fine(u64::try_from((exact + per / 2) / per).unwrap_or(u64::MAX))
    }

    /// The tick that has begun.
    pub(in crate::wire) const fn floor(self) -> Time {
        Time(self.0 >> SHIFT)
    }

    /// The first tick at or after this point.
    pub(in crate::wire) const fn ceil(self) -> Time {
        Time(self.0.saturating_add((1 << SHIFT) - 1) >> SHIFT)
    }

    /// The nearest tick.
    pub(in crate::wire) const fn nearest(self) -> Time {
        Time(self.0.saturating_add(1 << (SHIFT - 1)) >> SHIFT)
    }

    pub(in crate::wire) const fn times(self, count: u64) -> Fine {
        Fine(self.0.saturating_mul(count))
    }
}

impl Add for Fine {
    type Output = Fine;
    fn add(self, rhs: Fine) -> Fine {
        Fine(self.0.saturating_add(rhs.0))
    }
}

impl Sub for Fine {
    type Output = Fine;
    fn sub(self, rhs: Fine) -> Fine {
        Fine(self.0 - rhs.0)
    }
}
