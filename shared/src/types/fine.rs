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

    /// The nearest one to a count of a timer that makes `per_micro`, above zero, in a microsecond.
    pub const fn from_ticks(ticks: u64, per_micro: u32) -> Self {
        FineInstant(scaled(ticks, per_micro, Self::PER_MICRO as u32))
    }

    /// The nearest count of a timer that makes `per_micro` in a microsecond.
    pub const fn ticks(self, per_micro: u32) -> u64 {
        scaled(self.0, Self::PER_MICRO as u32, per_micro)
    }

    /// Later by this many units, earlier if negative; saturates.
    #[must_use]
    pub const fn plus(self, units: i64) -> Self {
        FineInstant(self.0.saturating_add_signed(units))
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

    /// What a frame can carry of it, to the nearest unit of 2^-24 s.
    pub const fn scet(self) -> Scet {
        Scet::from_units(self.0.wrapping_add(0x80) >> 8)
    }

    /// Later by this many units of 2^-32 s, earlier if negative.
    #[must_use]
    pub const fn plus(self, units: i64) -> Self {
        FineScet(self.0.wrapping_add_signed(units))
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

/// `count` units, of which `from` are as long as `to` of those asked for, to the nearest; saturates.
const fn scaled(count: u64, from: u32, to: u32) -> u64 {
    let (from, to) = (from as u64, to as u64);
    // In two parts: their product would not fit in 64 bits.
    (count / from).saturating_mul(to).saturating_add(((count % from) * to + from / 2) / from)
}
