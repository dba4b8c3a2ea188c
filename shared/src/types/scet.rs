//! Spacecraft Elapsed Time, CCSDS Unsegmented Time Code (ECSS 7.1.2).

use crate::types::Duration;

/// 32 bits of seconds and 24 bits of binary fractions (59.6 ns): a free-running counter that wraps after 2^32 s.
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
    /// Length in a frame, bytes.
    pub const LEN: usize = 7;

    /// From seconds and units of 2^-24 s; `None` for a fine time of 2^24 or more.
    pub const fn new(coarse: u32, fine: u32) -> Option<Scet> {
        if fine as u64 > FINE_MASK {
            return None;
        }
        Some(Scet { units: (coarse as u64) << FINE_BITS | fine as u64 })
    }

    /// From units of 2^-24 s; what is beyond 2^56 of them wraps.
    pub const fn from_units(units: u64) -> Scet {
        Scet { units: units & MASK }
    }

    /// Units of 2^-24 s, `0..2^56`.
    pub const fn units(self) -> u64 {
        self.units
    }

    /// Seconds.
    pub const fn coarse(self) -> u32 {
        (self.units >> FINE_BITS) as u32
    }

    /// Units of 2^-24 s, `0..2^24`.
    pub const fn fine(self) -> u32 {
        (self.units & FINE_MASK) as u32
    }

    /// With the highest `bits` of fine time, 0 to 24; the others are zero. What a device with less sends, and how it takes what
    /// it receives (7.1.2g, h).
    #[must_use]
    pub const fn truncated(self, bits: u32) -> Scet {
        let unused = FINE_BITS.saturating_sub(bits);
        Scet { units: self.units >> unused << unused }
    }

    /// Whether it is before the other, the shorter way round the counter: it has no first time and no last, so that times have
    /// no order of their own.
    pub const fn is_before(self, other: Scet) -> bool {
        let ahead = other.units.wrapping_sub(self.units) & MASK;
        ahead != 0 && ahead <= MASK / 2
    }

    /// The first time after this at which a second, or one of `parts` equal parts of it, begins: rounded up to a unit.
    #[must_use]
    pub const fn next_part(self, parts: u16) -> Scet {
        let parts = if parts == 0 { 1 } else { parts as u64 };
        let next = (((self.units & FINE_MASK) * parts) >> FINE_BITS) + 1;
        let fine = (next << FINE_BITS).div_ceil(parts);
        Scet::from_units((self.units & !FINE_MASK) + fine)
    }

    /// Later by `span`, rounded to the nearest unit; wraps after 2^32 s.
    #[must_use]
    pub const fn plus(self, span: Duration) -> Scet {
        Scet { units: self.units.wrapping_add(units(span)) & MASK }
    }

    /// Earlier by `span`, rounded to the nearest unit; wraps below zero.
    #[must_use]
    pub const fn minus(self, span: Duration) -> Scet {
        Scet { units: self.units.wrapping_sub(units(span)) & MASK }
    }

    /// Microseconds from `reference` to this time, rounded to the nearest; negative when this is the earlier one. The
    /// shorter way round the counter, so at most 2^31 s either way.
    pub const fn micros_since(self, reference: Scet) -> i64 {
        let forward = self.units.wrapping_sub(reference.units) & MASK;
        if forward <= MASK / 2 {
            micros(forward) as i64
        } else {
            -(micros(reference.units.wrapping_sub(self.units) & MASK) as i64)
        }
    }

    /// The octets of Figure 7-1: fine time, then coarse time, each little-endian.
    pub const fn encode(self) -> [u8; Self::LEN] {
        let [f0, f1, f2, _] = self.fine().to_le_bytes();
        let [c0, c1, c2, c3] = self.coarse().to_le_bytes();
        [f0, f1, f2, c0, c1, c2, c3]
    }

    /// From the first seven octets of a PDO; `None` when there are fewer.
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
