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

    /// When the cycle `cycle` begins, which may lie in the past: the tick that has begun, and how much of it has passed.
    pub fn exact_time_at(&self, cycle: u64) -> (Time, f64) {
        let denominator = i128::from(self.denominator);
        let cycles = i128::from(cycle) - i128::from(self.now.cycle);
        let span = cycles * i128::from(self.numerator) + i128::from(self.remainder);
        let ticks = i128::from(self.now.time.0) + span.div_euclid(denominator);
        (Time(ticks.max(0) as u64), span.rem_euclid(denominator) as f64 / self.denominator as f64)
    }

    /// The cycle that runs at `time`, which may lie in the past: then as if its cycles had been as long as those now.
    pub fn cycle_at(&self, time: Time) -> u64 {
        let denominator = i128::from(self.denominator);
        let span =
            (i128::from(time.0) - i128::from(self.now.time.0)) * denominator - i128::from(self.remainder);
        let cycles = span.div_euclid(i128::from(self.numerator));
        self.now.cycle.saturating_add_signed(cycles.clamp(i64::MIN.into(), i64::MAX.into()) as i64)
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
        Clocks { hclk: 168_000_000, apb1_divider: 4, apb2_divider: 2, timer1_divider: 2, from_crystal: true };

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
    fn an_instant_in_the_past_has_its_cycle() {
        // Exact: two ticks per cycle.
        let mut clock = BoardClock::new(0);
        clock.set(AT_168_MHZ);
        clock.advance_to_cycle(1000);
        for (ticks, cycle) in [(2000, 1000), (1999, 999), (1998, 999), (0, 0), (2001, 1000), (2002, 1001)] {
            assert_eq!(clock.cycle_at(Time(ticks)), cycle, "{ticks} ticks");
        }
        // 100 ppm slow: 2.0002 ticks per cycle.
        let mut slow = BoardClock::new(-100_000);
        slow.set(AT_168_MHZ);
        slow.advance_to_cycle(20_000_000);
        assert_eq!(slow.cycle_at(Time(20_002_000)), 9_999_999);
        assert_eq!(slow.cycle_at(Time(20_002_001)), 10_000_000);
    }

    #[test]
    fn advancing_to_an_instant_overshoots_by_less_than_a_cycle() {
        let mut clock = BoardClock::new(12_000);
        clock.set(AT_168_MHZ);
        clock.advance_to(Time(100_001));
        assert!((100_001..=100_002).contains(&clock.now().time.0));
    }
}
