//! Time to fractions of a nanosecond: what stamps are in, and what the local clock makes of them.

use super::{Instant, Scet};

/// An instant of this node's clock in units of 2^-8 µs (3.9 ns): [`Instant`] with eight more bits. Timers that capture frames
/// count in units of their own; 84 MHz, say, is converted to the nearest of these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FineInstant(u64);

impl FineInstant {
    /// Units in a microsecond.
    pub const PER_MICRO: u64 = 256;

    /// From units of 2^-8 µs since power-on.
    pub const fn from_units(units: u64) -> Self {
        FineInstant(units)
    }

    /// Units of 2^-8 µs since power-on.
    pub const fn units(self) -> u64 {
        self.0
    }

    /// Rounded down to a microsecond.
    pub const fn instant(self) -> Instant {
        Instant::from_micros(self.0 / Self::PER_MICRO)
    }
}

impl From<Instant> for FineInstant {
    /// The beginning of the microsecond; the last instants are all one.
    fn from(instant: Instant) -> Self {
        FineInstant(instant.as_micros().saturating_mul(Self::PER_MICRO))
    }
}

/// Spacecraft elapsed time in units of 2^-32 s (0.23 ns): [`Scet`] with eight more bits. A free-running counter that wraps
/// after 2^32 s, as all arithmetic with it does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FineScet(u64);

impl FineScet {
    /// From units of 2^-32 s.
    pub const fn from_units(units: u64) -> Self {
        FineScet(units)
    }

    /// Units of 2^-32 s.
    pub const fn units(self) -> u64 {
        self.0
    }

    /// What a frame can carry of it: rounded down to 2^-24 s (7.1.2g: what is not carried is zero, not rounded).
    pub const fn scet(self) -> Scet {
        Scet::from_units(self.0 >> 8)
    }

    /// Units of 2^-32 s from `reference` to this time, negative when this is the earlier one. The shorter way round, so at most
    /// 2^31 s either way.
    pub const fn since(self, reference: FineScet) -> i64 {
        self.0.wrapping_sub(reference.0) as i64
    }
}

impl From<Scet> for FineScet {
    fn from(scet: Scet) -> Self {
        FineScet(scet.units() << 8)
    }
}
