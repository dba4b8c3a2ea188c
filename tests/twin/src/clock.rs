//! A board's own clock: core cycles against the virtual time of the spacecraft.
//!
//! The length of a cycle is a fraction of integers that contains the crystal's error, and the remainder is carried:
//! after any number of cycles the board is where exact arithmetic puts it.

use can_wire::time::{TICKS_PER_US, Time};

use crate::bxcan::PclkTick;
use crate::mmio::Now;
use crate::peripherals::Clocks;

const BILLION: u64 = 1_000_000_000;

/// Where a board stands.
#[derive(Clone, Debug)]
pub struct BoardClock {
    now: Now,
    /// A cycle lasts `numerator / denominator` ticks; `remainder` of the last cycle's fraction.
    numerator: u64,
    denominator: u64,
    remainder: u64,
    crystal_ppb: i32,
}

impl BoardClock {
    /// A clock at time zero on HSI; the crystal runs `crystal_ppb` parts per billion fast.
    pub fn new(crystal_ppb: i32) -> Self {
        // HSI: 16 MHz, 21 ticks per cycle.
        BoardClock { now: Now::default(), numerator: 21, denominator: 1, remainder: 0, crystal_ppb }
    }

    /// The present.
    pub fn now(&self) -> Now {
        self.now
    }

    /// Sets the cycle's length; the fraction of a tick under way is dropped. Returns the length of a PCLK1 tick.
    pub fn set(&mut self, clocks: Clocks) -> PclkTick {
        let error = if clocks.from_crystal { i64::from(self.crystal_ppb) } else { 0 };
        let scale = u128::from(BILLION.checked_add_signed(error).expect("an i32 of ppb is small"));
        let numerator = u128::from(TICKS_PER_US) * 1_000_000 * u128::from(BILLION);
        let denominator = u128::from(clocks.hclk) * scale;
        let common = gcd(numerator, denominator);
        let narrow =
            |n: u128| u64::try_from(n / common).expect("the clock tree's frequencies share large factors");
        self.numerator = narrow(numerator);
        self.denominator = narrow(denominator);
        self.remainder = 0;
        PclkTick::new(self.numerator * clocks.apb1_divider, self.denominator)
    }

    /// Lets `cycles` pass.
    pub fn advance(&mut self, cycles: u32) {
        let total = self.remainder + u64::from(cycles) * self.numerator;
        self.now.time += Time(total / self.denominator);
        self.remainder = total % self.denominator;
        self.now.cycle += u64::from(cycles);
    }

    /// Lets cycles pass until `time` is reached, not one more.
    pub fn advance_to(&mut self, time: Time) {
        let span = u128::from(time.since(self.now.time).0) * u128::from(self.denominator);
        let wanted = span.saturating_sub(u128::from(self.remainder));
        let cycles = wanted.div_ceil(u128::from(self.numerator));
        self.skip(cycles as u64);
    }

    /// Lets cycles pass until the cycle count is `cycle`.
    pub fn advance_to_cycle(&mut self, cycle: u64) {
        self.skip(cycle.saturating_sub(self.now.cycle));
    }

    fn skip(&mut self, cycles: u64) {
        let total = u128::from(self.remainder) + u128::from(cycles) * u128::from(self.numerator);
        let denominator = u128::from(self.denominator);
        self.now.time += Time((total / denominator) as u64);
        self.remainder = (total % denominator) as u64;
        self.now.cycle += cycles;
    }

    /// The instant at which the cycle count will be `cycle`.
    pub fn time_at(&self, cycle: u64) -> Time {
        let mut then = self.clone();
        then.advance_to_cycle(cycle);
        then.now.time
    }

    /// Without power no cycles pass.
    pub fn jump_to(&mut self, time: Time) {
        self.now.time = time;
    }
}

fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT_168_MHZ: Clocks =
        Clocks { hclk: 168_000_000, apb1_divider: 4, timer1_divider: 2, from_crystal: true };

    #[test]
    fn a_second_of_cycles_is_a_second() {
        let mut clock = BoardClock::new(0);
        clock.set(AT_168_MHZ);
        for _ in 0..168 {
            clock.advance(1_000_000);
        }
        assert_eq!(clock.now().time, Time::from_ms(1000));
    }

    #[test]
    fn a_fast_crystal_finishes_its_second_early() {
        // 50 ppm fast: 168 000 000 cycles last 1 s / 1.00005 = 999 950.0024998750 us = 335 983 200.839... ticks.
        let mut clock = BoardClock::new(50_000);
        clock.set(AT_168_MHZ);
        for _ in 0..168_000 {
            clock.advance(1000);
        }
        assert_eq!(clock.now().time, Time(335_983_200));
    }

    #[test]
    fn small_and_large_strides_agree() {
        let mut small = BoardClock::new(-23_456);
        small.set(AT_168_MHZ);
        let mut large = small.clone();
        for _ in 0..12_345 {
            small.advance(7);
        }
        large.advance_to_cycle(12_345 * 7);
        assert_eq!(small.now(), large.now());
    }

    #[test]
    fn advancing_to_an_instant_overshoots_by_less_than_a_cycle() {
        let mut clock = BoardClock::new(12_000);
        clock.set(AT_168_MHZ);
        clock.advance_to(Time(100_001));
        assert!((100_001..=100_002).contains(&clock.now().time.0));
    }
}
