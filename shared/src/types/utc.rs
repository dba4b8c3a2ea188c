//! Spacecraft UTC, CCSDS Day Segmented time code (ECSS 7.1.3).
//!
//! A network uses either this or the [`Scet`](crate::types::Scet) (ECSS 7.1.1d). The nodes here keep the SCET; a device with a
//! clock of its own for UTC takes the objects of [`LocalUtc`](crate::time::LocalUtc) among its own.

/// Days since an epoch that the mission defines, milliseconds of the day, and parts of a millisecond.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Utc {
    day: u16,
    ms: u32,
    submilliseconds: u16,
}

/// Milliseconds of the longest day, one with a leap second.
const LONGEST_DAY: u32 = 86_401_000;

impl Utc {
    /// Length in a frame, bytes.
    pub const LEN: usize = 8;

    /// From days, milliseconds and units of 2^-16 ms; `None` for milliseconds that no day has.
    pub const fn new(day: u16, ms: u32, submilliseconds: u16) -> Option<Utc> {
        if ms < LONGEST_DAY { Some(Utc { day, ms, submilliseconds }) } else { None }
    }

    /// Days since the epoch.
    pub const fn day(self) -> u16 {
        self.day
    }

    /// Milliseconds of the day, `0..86_401_000`.
    pub const fn ms(self) -> u32 {
        self.ms
    }

    /// Units of 2^-16 ms.
    pub const fn submilliseconds(self) -> u16 {
        self.submilliseconds
    }

    /// The octets of Figure 7-2: submilliseconds, milliseconds, days, each little-endian.
    pub const fn encode(self) -> [u8; Self::LEN] {
        let [s0, s1] = self.submilliseconds.to_le_bytes();
        let [m0, m1, m2, m3] = self.ms.to_le_bytes();
        let [d0, d1] = self.day.to_le_bytes();
        [s0, s1, m0, m1, m2, m3, d0, d1]
    }

    /// From the octets of a PDO; `None` when there are fewer, and for milliseconds that no day has.
    pub const fn decode(octets: &[u8]) -> Option<Utc> {
        let Some(&[s0, s1, m0, m1, m2, m3, d0, d1]) = octets.first_chunk() else { return None };
        let (day, ms) = (u16::from_le_bytes([d0, d1]), u32::from_le_bytes([m0, m1, m2, m3]));
        Utc::new(day, ms, u16::from_le_bytes([s0, s1]))
    }
}
