//! Time to fractions of a nanosecond, for stamps and for the local clock.

use super::Instant;

/// Instant of this node's clock in units of 2^-8 µs (3.9 ns): [`Instant`] with eight more bits. Timers that
/// capture frames count in units of their own. Their counts, for example at 84 MHz, are converted to the nearest
/// of these units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FineInstant(u64);

impl FineInstant {
    /// Number of units in a microsecond.
    pub const PER_MICRO: u64 = 256;

    /// Takes units of 2^-8 µs since power-on.
    pub const fn from_units(units: u64) -> Self {
        FineInstant(units)
    }

    /// Returns the units of 2^-8 µs since power-on.
    pub const fn units(self) -> u64 {
        self.0
    }

    /// Returns the instant nearest to a count of a timer that makes `per_micro`, above zero, in a microsecond.
    pub const fn from_ticks(ticks: u64, per_micro: u32) -> Self {
        FineInstant(scaled(ticks, per_micro, Self::PER_MICRO as u32))
    }

    /// Returns the nearest count of a timer that makes `per_micro` in a microsecond.
    pub const fn ticks(self, per_micro: u32) -> u64 {
        scaled(self.0, Self::PER_MICRO as u32, per_micro)
    }

    /// Returns the instant later by this many units, earlier if negative. Saturates.
    #[must_use]
    pub const fn plus(self, units: i64) -> Self {
        FineInstant(self.0.saturating_add_signed(units))
    }

    /// Returns the instant rounded down to a microsecond.
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

/// `count` units, of which `from` are as long as `to` of those asked for, to the nearest; saturates.
const fn scaled(count: u64, from: u32, to: u32) -> u64 {
    let (from, to) = (from as u64, to as u64);
    // In two parts: their product would not fit in 64 bits.
    (count / from).saturating_mul(to).saturating_add(((count % from) * to + from / 2) / from)
}
