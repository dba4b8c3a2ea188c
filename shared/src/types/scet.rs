//! Spacecraft Elapsed Time, CCSDS Unsegmented Time Code (ECSS 7.1.2).

use super::Duration;

/// Spacecraft elapsed time: 32 bits of seconds and 24 bits of binary fractions (59.6 ns). It is a free-running
/// counter that wraps after 2^32 s.
#[doc(alias("SCET", "spacecraft elapsed time", "CUC"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Scet {
    /// Units of 2^-24 s, `0..2^56`.
    units: u64,
}

const FINE_BITS: u32 = 24;
const FINE_MASK: u64 = (1 << FINE_BITS) - 1;
const MASK: u64 = (1 << 56) - 1;
const MICROS: u64 = 1_000_000;

impl Scet {
    /// Length in a frame, in bytes.
    pub const LEN: usize = 7;

    /// Makes a time of seconds and units of 2^-24 s. `None` for a fine time of 2^24 or more.
    pub const fn new(coarse: u32, fine: u32) -> Option<Scet> {
        if fine as u64 > FINE_MASK {
            return None;
        }
        Some(Scet { units: (coarse as u64) << FINE_BITS | fine as u64 })
    }

    /// Takes units of 2^-24 s. From 2^56 units on it wraps.
    pub const fn from_units(units: u64) -> Scet {
        Scet { units: units & MASK }
    }

    /// Returns the units of 2^-24 s, `0..2^56`.
    pub const fn units(self) -> u64 {
        self.units
    }

    /// Returns the whole seconds.
    pub const fn coarse(self) -> u32 {
        (self.units >> FINE_BITS) as u32
    }

    /// Returns the units of 2^-24 s, `0..2^24`.
    pub const fn fine(self) -> u32 {
        (self.units & FINE_MASK) as u32
    }

    /// Returns the time with the highest `bits` of fine time, 0 to 24. The others are zero. A device with less
    /// resolution sends and receives times in this form (7.1.2g, h).
    #[must_use]
    pub const fn truncated(self, bits: u32) -> Scet {
        let unused = FINE_BITS.saturating_sub(bits);
        Scet { units: self.units >> unused << unused }
    }

    /// Returns whether this time is before the other, the nearer way round the counter. The counter has no first
    /// and no last time, so times have no total order.
    pub const fn is_before(self, other: Scet) -> bool {
        let ahead = other.units.wrapping_sub(self.units) & MASK;
        ahead != 0 && ahead <= MASK / 2
    }

    /// Returns the first time after this one at which a second begins, or one of `parts` equal parts of it,
    /// rounded up to a unit.
    #[must_use]
    pub const fn next_part(self, parts: u16) -> Scet {
        let parts = if parts == 0 { 1 } else { parts as u64 };
        let next = (((self.units & FINE_MASK) * parts) >> FINE_BITS) + 1;
        let fine = (next << FINE_BITS).div_ceil(parts);
        Scet::from_units((self.units & !FINE_MASK) + fine)
    }

    /// Returns the time later by `span`, rounded to the nearest unit. It wraps after 2^32 s.
    #[must_use]
    pub const fn plus(self, span: Duration) -> Scet {
        Scet { units: self.units.wrapping_add(units(span)) & MASK }
    }

    /// Returns the time earlier by `span`, rounded to the nearest unit. It wraps below zero.
    #[must_use]
    pub const fn minus(self, span: Duration) -> Scet {
        Scet { units: self.units.wrapping_sub(units(span)) & MASK }
    }

    /// Returns the microseconds from `reference` to this time, rounded to the nearest. They are negative if this
    /// time is the earlier one. It counts the nearer way round the counter, so at most 2^31 s in either
    /// direction.
    pub const fn micros_since(self, reference: Scet) -> i64 {
        let forward = self.units.wrapping_sub(reference.units) & MASK;
        if forward <= MASK / 2 {
            micros(forward) as i64
        } else {
            -(micros(reference.units.wrapping_sub(self.units) & MASK) as i64)
        }
    }

    /// Returns the octets of Figure 7-1: fine time, then coarse time, each little-endian.
    pub const fn encode(self) -> [u8; Self::LEN] {
        let [f0, f1, f2, _] = self.fine().to_le_bytes();
        let [c0, c1, c2, c3] = self.coarse().to_le_bytes();
        [f0, f1, f2, c0, c1, c2, c3]
    }

    /// Decodes the first seven octets of a PDO. `None` if there are fewer.
    pub const fn decode(octets: &[u8]) -> Option<Scet> {
        let Some(&[f0, f1, f2, c0, c1, c2, c3]) = octets.first_chunk() else { return None };
        Scet::new(u32::from_le_bytes([c0, c1, c2, c3]), u32::from_le_bytes([f0, f1, f2, 0]))
    }
}

/// Units of 2^-24 s in a span, to the nearest; modulo 2^56.
#[inline(never)] // later and earlier
const fn units(span: Duration) -> u64 {
    let us = span.as_micros();
    let fine = (((us % MICROS) << FINE_BITS) + MICROS / 2) / MICROS;
    ((us / MICROS) << FINE_BITS).wrapping_add(fine) & MASK
}

/// Microseconds in units below 2^56, to the nearest.
const fn micros(units: u64) -> u64 {
    let fine = ((units & FINE_MASK) * MICROS + (1 << (FINE_BITS - 1))) >> FINE_BITS;
    (units >> FINE_BITS) * MICROS + fine
}
