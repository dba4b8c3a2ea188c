//! Spacecraft UTC, CCSDS Day Segmented time code (ECSS 7.1.3).
//!
//! A network uses either this or the [`Scet`](crate::types::Scet) (ECSS 7.1.1d). Nodes count the SCET.
//! [`UtcRelation`] gives the UTC.

use super::{Duration, FineScet, Scet};

/// Days since an epoch of the agency, milliseconds of the day, microseconds of the millisecond (CCSDS 301.0-B-4
/// 3.3). The milliseconds have 32 bits, the others 16.
#[doc(alias("UTC", "CDS"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Utc {
    day: u16,
    ms: u32,
    micros: u16,
}

/// Milliseconds of a day without leap second.
const DAY_MS: u32 = 86_400_000;
/// Milliseconds of the longest day, one with a leap second.
const LONGEST_DAY: u32 = DAY_MS + 1_000;
const MS: u64 = 1_000;
const DAY_MICROS: u64 = DAY_MS as u64 * MS;

impl Utc {
    /// Length in a frame, in bytes.
    pub const LEN: usize = 8;

    /// Makes a time of days, milliseconds and microseconds. `None` for milliseconds that no day has, and for 1000
    /// microseconds or more.
    pub const fn new(day: u16, ms: u32, micros: u16) -> Option<Utc> {
        if ms < LONGEST_DAY && (micros as u64) < MS { Some(Utc { day, ms, micros }) } else { None }
    }

    /// Returns the days since the epoch.
    pub const fn day(self) -> u16 {
        self.day
    }

    /// Returns the milliseconds of the day, `0..86_401_000`.
    pub const fn ms(self) -> u32 {
        self.ms
    }

    /// Returns the microseconds of the millisecond, `0..1000`.
    pub const fn micros(self) -> u16 {
        self.micros
    }

    /// Returns the time without the microseconds. A device without that field sends and receives times in this
    /// form (7.1.3f, g).
    #[must_use]
    pub const fn whole_ms(self) -> Utc {
        Utc { micros: 0, ..self }
    }

    /// Returns the time later by `span`. Days have 86,400 s, so a leap second within is not counted. It wraps
    /// after 2^16 days.
    #[must_use]
    pub const fn plus(self, span: Duration) -> Utc {
        Self::from_day_micros(self.day as u64, self.of_day() + span.as_micros() % (DAY_MICROS << 16))
    }

    /// Returns the time earlier by `span`. It wraps below the epoch.
    #[must_use]
    pub const fn minus(self, span: Duration) -> Utc {
        const AROUND: u64 = DAY_MICROS << 16;
        Self::from_day_micros(self.day as u64, self.of_day() + AROUND - span.as_micros() % AROUND)
    }

    /// Returns the microseconds from `reference` to this time, negative if this time is the earlier one. It
    /// counts the nearer way round the days.
    pub const fn micros_since(self, reference: Utc) -> i64 {
        let days = self.day.wrapping_sub(reference.day) as i16 as i64;
        days * DAY_MICROS as i64 + self.of_day() as i64 - reference.of_day() as i64
    }

    /// Returns the octets of Figure 7-2: microseconds, milliseconds, days, each little-endian.
    pub const fn encode(self) -> [u8; Self::LEN] {
        let [s0, s1] = self.micros.to_le_bytes();
        let [m0, m1, m2, m3] = self.ms.to_le_bytes();
        let [d0, d1] = self.day.to_le_bytes();
        [s0, s1, m0, m1, m2, m3, d0, d1]
    }

    /// Decodes the octets of a PDO. `None` if there are fewer, and for values that [`Utc::new`] refuses.
    pub const fn decode(octets: &[u8]) -> Option<Utc> {
        let Some(&[s0, s1, m0, m1, m2, m3, d0, d1]) = octets.first_chunk() else { return None };
        let (day, ms) = (u16::from_le_bytes([d0, d1]), u32::from_le_bytes([m0, m1, m2, m3]));
        Utc::new(day, ms, u16::from_le_bytes([s0, s1]))
    }

    const fn of_day(self) -> u64 {
        self.ms as u64 * MS + self.micros as u64
    }

    const fn from_day_micros(day: u64, micros: u64) -> Utc {
        let of_day = micros % DAY_MICROS;
        Utc {
            day: day.wrapping_add(micros / DAY_MICROS) as u16,
            ms: (of_day / MS) as u32,
            micros: (of_day % MS) as u16,
        }
    }
}

/// Relation of UTC and SCET: both times at one instant. It holds until a leap second or a command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UtcRelation {
    /// SCET at that instant.
    pub scet: Scet,
    /// UTC at that instant.
    pub utc: Utc,
}

impl UtcRelation {
    /// Returns the UTC of a SCET, to the nearest microsecond.
    pub const fn utc(&self, scet: FineScet) -> Utc {
        let ahead = scet.units().wrapping_sub(self.scet.units() << 8) as i64;
        // Seconds, then the fraction: their product with a million would not fit in 64 bits.
        let seconds = ahead >> 32;
        let micros = ((ahead as u32 as u64) * 1_000_000 + (1 << 31)) >> 32;
        let whole = Duration::from_micros(seconds.unsigned_abs() * 1_000_000);
        let at_second = if seconds < 0 { self.utc.minus(whole) } else { self.utc.plus(whole) };
        at_second.plus(Duration::from_micros(micros))
    }

    /// Returns the SCET of a UTC, at most 2^31 s from that of the relation, rounded to the nearest unit.
    pub const fn scet(&self, utc: Utc) -> Scet {
        let micros = utc.micros_since(self.utc);
        let span = Duration::from_micros(micros.unsigned_abs());
        if micros < 0 { self.scet.minus(span) } else { self.scet.plus(span) }
    }
}
