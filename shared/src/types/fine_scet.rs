//! Spacecraft time to fractions of a nanosecond, for the local clock.

use super::Scet;

/// Spacecraft elapsed time in units of 2^-32 s (0.23 ns): [`Scet`] with eight more bits. It is a free-running
/// counter that wraps after 2^32 s. All arithmetic with it wraps, too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FineScet(u64);

impl FineScet {
    /// Takes units of 2^-32 s.
    pub const fn from_units(units: u64) -> Self {
        FineScet(units)
    }

    /// Returns the units of 2^-32 s.
    pub const fn units(self) -> u64 {
        self.0
    }

    /// Returns the time in the resolution of a frame, to the nearest unit of 2^-24 s.
    pub const fn scet(self) -> Scet {
        Scet::from_units(self.0.wrapping_add(0x80) >> 8)
    }

    /// Returns the time later by this many units of 2^-32 s, earlier if negative.
    #[must_use]
    pub const fn plus(self, units: i64) -> Self {
        FineScet(self.0.wrapping_add_signed(units))
    }

    /// Returns the units of 2^-32 s from `reference` to this time, negative if this time is the earlier one. It
    /// counts the nearer way round the counter, so at most 2^31 s in either direction.
    pub const fn since(self, reference: FineScet) -> i64 {
        self.0.wrapping_sub(reference.0) as i64
    }
}

impl From<Scet> for FineScet {
    fn from(scet: Scet) -> Self {
        FineScet(scet.units() << 8)
    }
}
