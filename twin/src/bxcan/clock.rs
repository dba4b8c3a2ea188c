//! Bit timing from PCLK1 and BTR, without rounding drift.

use crate::wire::time::Time;
use crate::wire::timing::{BitTiming, Quantum};

/// Length of one PCLK1 tick as the rational `ticks / per`, in [`Time`] ticks of 1/336 µs.
///
/// A rational number, because a crystal's error of some ppm is smaller than a tick: exactly 42 MHz is `8 / 1`, the same
/// crystal 50 ppm slow is `8_000_400 / 1_000_000`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PclkTick {
    ticks: u64,
    per: u64,
}

impl PclkTick {
    /// Makes a tick length: `ticks` of [`Time`] for `per` ticks of PCLK1.
    ///
    /// # Panics
    /// When either is zero.
    pub fn new(ticks: u64, per: u64) -> Self {
        assert!(ticks > 0 && per > 0, "a clock has a period, not {ticks}/{per}");
        PclkTick { ticks, per }
    }

    /// Length of `count` ticks, rounded to the nearest [`Time`] tick once.
    pub fn span(self, count: u64) -> Time {
        let per = u128::from(self.per);
        let exact = u128::from(count) * u128::from(self.ticks);
        Time(u64::try_from((exact + per / 2) / per).unwrap_or(u64::MAX))
    }

    /// Returns the bit timing that BTR configures, RM0090 32.7.7. A jump width beyond segment 1 acts as segment 1.
    pub fn timing(self, btr: u32) -> BitTiming {
        let field = |shift: u32, mask: u32| (btr >> shift & mask) as u8 + 1;
        let prescaler = u64::from(btr & 0x3FF) + 1;
        let (segment1, segment2, jump) = (field(16, 0xF), field(20, 0x7), field(24, 0x3));
        let quantum = Quantum::new(self.ticks * prescaler, self.per);
        BitTiming::new(quantum, segment1, segment2, jump.min(segment1))
    }
}

/// PCLK1 ticks of one bit: `(BRP + 1) * (1 + TS1 + 1 + TS2 + 1)`, RM0090 32.7.7.
pub fn bit_pclks(btr: u32) -> u64 {
    let brp = u64::from(btr & 0x3FF);
    let ts1 = u64::from(btr >> 16 & 0xF);
    let ts2 = u64::from(btr >> 20 & 0x7);
    (brp + 1) * (1 + (ts1 + 1) + (ts2 + 1))
}
