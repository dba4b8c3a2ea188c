//! A board's own clock: core cycles against the virtual time of the spacecraft.
//!
//! The length of a cycle is a fraction of integers that contains the crystal's error, and the remainder is carried:
//! after any number of cycles the time is exact. A crystal with drift or noise has stretches of constant frequency, so
//! that time is a function of the cycle count only, independent of the step size.

use std::cell::RefCell;

use crate::bxcan::PclkTick;
use crate::crystal::{Crystal, Frequency};
use crate::mmio::Now;
use crate::peripherals::Clocks;
use crate::wire::time::{TICKS_PER_US, Time};

const BILLION: u64 = 1_000_000_000;
/// The denominator of cycle lengths while the frequency changes.
const FINE: u64 = 1_000_000_000_000;

/// Cycles of one length.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    /// Start of the stretch, with `remainder` of the fraction of a tick.
    start: Now,
    remainder: u64,
    /// Start of the next stretch.
    end: Now,
    /// A cycle lasts `numerator / denominator` ticks.
    numerator: u64,
    denominator: u64,
}

/// End of a stretch without end.
const NEVER: Now = Now { cycle: u64::MAX, time: Time::NEVER };

impl Stretch {
    /// Returns the beginning of `cycle`: its tick, and the elapsed part of that tick.
    fn at(&self, cycle: u64) -> (Time, u64) {
        // Numbers of 64 bits suffice nearly always and improve the row twin.host_instructions.
        let short = cycle.checked_sub(self.start.cycle).and_then(|cycles| cycles.checked_mul(self.numerator));
        if let Some(span) = short.and_then(|span| span.checked_add(self.remainder)) {
            return (self.start.time + Time(span / self.denominator), span % self.denominator);
        }
        let cycles = i128::from(cycle) - i128::from(self.start.cycle);
        let span = cycles * i128::from(self.numerator) + i128::from(self.remainder);
        let denominator = i128::from(self.denominator);
        let ticks = i128::from(self.start.time.0) + span.div_euclid(denominator);
        (Time(ticks.max(0) as u64), span.rem_euclid(denominator) as u64)
    }

    /// Cycles from its start until `time` is reached.
    fn cycles_to(&self, time: Time) -> u64 {
        if let Some(span) = time.since(self.start.time).0.checked_mul(self.denominator) {
            return span.saturating_sub(self.remainder).div_ceil(self.numerator);
        }
        let span = u128::from(time.since(self.start.time).0) * u128::from(self.denominator);
        let wanted = span.saturating_sub(u128::from(self.remainder));
        wanted.div_ceil(u128::from(self.numerator)) as u64
    }

    /// The cycle that runs at `time`, also before its start.
    fn cycle_at(&self, time: Time) -> u64 {
        let denominator = i128::from(self.denominator);
        let span =
            (i128::from(time.0) - i128::from(self.start.time.0)) * denominator - i128::from(self.remainder);
        let cycles = span.div_euclid(i128::from(self.numerator));
        self.start.cycle.saturating_add_signed(cycles.clamp(i64::MIN.into(), i64::MAX.into()) as i64)
    }
}

/// Stretches of a crystal whose frequency changes, since the clock tree was set.
#[derive(Clone, Debug)]
struct Stretches {
    frequency: Frequency,
    hclk: u64,
    /// Stretches without gaps; empty while the length of a cycle is constant.
    all: Vec<Stretch>,
}

impl Stretches {
    /// Starts again from `start` on. Returns the first stretch.
    fn restart(&mut self, start: Now, hclk: u64) -> Stretch {
        self.all.clear();
        self.hclk = hclk;
        self.push(start, 0)
    }

    fn push(&mut self, start: Now, remainder: u64) -> Stretch {
        let step = start.time.0 / Crystal::STEP.0;
        let nominal = (TICKS_PER_US * 1_000_000) as f64 * FINE as f64 / self.hclk as f64;
        let numerator = (nominal / (1.0 + self.frequency.in_step(step as usize))).round() as u64;
        let mut stretch = Stretch { start, remainder, end: Now::default(), numerator, denominator: FINE };
        // The first cycle that begins in the next step.
        let cycle = start.cycle + stretch.cycles_to(Time((step + 1) * Crystal::STEP.0));
        stretch.end = Now { cycle, time: stretch.at(cycle).0 };
        self.all.push(stretch);
        stretch
    }

    /// Adds stretches as long as `wanted` returns true for the end of the last one.
    fn extend(&mut self, wanted: impl Fn(Now) -> bool) {
        while let Some(last) = self.all.last().filter(|last| wanted(last.end)) {
            let (end, (_, remainder)) = (last.end, last.at(last.end.cycle));
            self.push(end, remainder);
        }
    }

    /// Returns the last stretch for whose start `is_reached` returns true.
    fn last(&mut self, is_reached: impl Fn(Now) -> bool) -> Option<Stretch> {
        self.extend(&is_reached);
        let n = self.all.partition_point(|stretch| is_reached(stretch.start));
        self.all.get(n.saturating_sub(1)).copied()
    }
}

/// Clock of a board.
#[derive(Clone, Debug)]
pub struct BoardClock {
    now: Now,
    /// Remainder of the last cycle's fraction.
    remainder: u64,
    /// Stretch that contains the present.
    stretch: Stretch,
    stretches: RefCell<Stretches>,
}

impl BoardClock {
    /// A clock at time zero on HSI, beside a crystal.
    pub fn new(crystal: Crystal) -> Self {
        let start = Now::default();
        // HSI: 16 MHz, 21 ticks per cycle.
        let stretch = Stretch { start, remainder: 0, end: NEVER, numerator: 21, denominator: 1 };
        let frequency = Frequency::new(crystal);
        let stretches = RefCell::new(Stretches { frequency, hclk: 0, all: Vec::new() });
        BoardClock { now: start, remainder: 0, stretch, stretches }
    }

    /// Returns the present.
    pub fn now(&self) -> Now {
        self.now
    }

    /// Sets the cycle's length; the fraction of the present tick is dropped. Returns the length of a PCLK1 tick; for a
    /// crystal that drifts, the present one.
    pub fn set(&mut self, clocks: Clocks) -> PclkTick {
        self.remainder = 0;
        let stretches = self.stretches.get_mut();
        stretches.all.clear();
        let crystal = stretches.frequency.crystal;
        if clocks.from_crystal && !crystal.is_steady() {
            self.stretch = stretches.restart(self.now, clocks.hclk);
        } else {
            let ppm = if clocks.from_crystal { crystal.ppm } else { 0.0 };
            let error = (ppm * 1000.0).round() as i64;
            let scale = u128::from(BILLION.checked_add_signed(error).expect("an error within 1000 ppm"));
            let numerator = u128::from(TICKS_PER_US) * 1_000_000 * u128::from(BILLION);
            let denominator = u128::from(clocks.hclk) * scale;
            let common = gcd(numerator, denominator);
            let narrow = |n: u128| {
                u64::try_from(n / common).expect("the clock tree's frequencies share large factors")
            };
            let (numerator, denominator) = (narrow(numerator), narrow(denominator));
            self.stretch = Stretch { start: self.now, remainder: 0, end: NEVER, numerator, denominator };
        }
        PclkTick::new(self.stretch.numerator * clocks.apb1_divider, self.stretch.denominator)
    }

    /// Advances by the fewest cycles that reach `time`.
    pub fn advance_to(&mut self, time: Time) {
        self.advance_to_cycle(self.cycle_reaching(time));
    }

    /// Returns the first cycle that does not begin before `time`; the present one if `time` is past.
    pub fn cycle_reaching(&self, time: Time) -> u64 {
        if time <= self.now.time {
            return self.now.cycle;
        }
        let stretch = self.stretch_at(time);
        stretch.start.cycle + stretch.cycles_to(time)
    }

    /// Advances until the cycle count is `cycle`.
    pub fn advance_to_cycle(&mut self, cycle: u64) {
        if cycle > self.now.cycle {
            self.go_to(cycle);
        }
    }

    fn go_to(&mut self, cycle: u64) {
        let stretch = self.stretch_of(cycle);
        let (time, remainder) = stretch.at(cycle);
        if cycle >= self.stretch.end.cycle {
            self.stretch = stretch;
        }
        (self.now, self.remainder) = (Now { cycle, time }, remainder);
    }

    /// The stretch of `cycle`, which may lie in the past.
    fn stretch_of(&self, cycle: u64) -> Stretch {
        let is_present = (self.stretch.start.cycle..self.stretch.end.cycle).contains(&cycle);
        let other =
            if is_present { None } else { self.stretches.borrow_mut().last(|now| now.cycle <= cycle) };
        other.unwrap_or_else(|| self.present())
    }

    fn stretch_at(&self, time: Time) -> Stretch {
        let is_present = (self.stretch.start.time..self.stretch.end.time).contains(&time);
        let other = if is_present { None } else { self.stretches.borrow_mut().last(|now| now.time <= time) };
        other.unwrap_or_else(|| self.present())
    }

    /// Returns the present stretch with its start moved to now: short numbers are divided faster.
    fn present(&self) -> Stretch {
        Stretch { start: self.now, remainder: self.remainder, ..self.stretch }
    }

    /// Returns the past or future instant at which the cycle count is `cycle`.
    pub fn time_at(&self, cycle: u64) -> Time {
        self.stretch_of(cycle).at(cycle).0
    }

    /// Returns the beginning of `cycle`, which may be in the past: its tick, and the elapsed fraction of that tick.
    pub fn exact_time_at(&self, cycle: u64) -> (Time, f64) {
        let stretch = self.stretch_of(cycle);
        let (time, remainder) = stretch.at(cycle);
        (time, remainder as f64 / stretch.denominator as f64)
    }

    /// Returns the cycle at `time`, which may be in the past. Before the clock tree was set the length of a cycle
    /// counts as constant.
    pub fn cycle_at(&self, time: Time) -> u64 {
        self.stretch_at(time).cycle_at(time)
    }

    /// Advances the time without cycles, as without power.
    pub fn jump_to(&mut self, time: Time) {
        self.now.time = time;
        self.stretches.get_mut().all.clear();
        self.stretch = Stretch { end: NEVER, ..self.present() };
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
        let mut clock = BoardClock::new(Crystal::ppm(0.0));
        clock.set(AT_168_MHZ);
        for _ in 0..168 {
            clock.advance_to_cycle(clock.now().cycle + 1_000_000);
        }
        assert_eq!(clock.now().time, Time::from_ms(1000));
    }

    #[test]
    fn a_fast_crystal_finishes_its_second_early() {
        // 50 ppm fast: 168 000 000 cycles last 1 s / 1.00005 = 999 950.0024998750 us = 335 983 200.839... ticks.
        let mut clock = BoardClock::new(Crystal::ppm(50.0));
        clock.set(AT_168_MHZ);
        for _ in 0..168_000 {
            clock.advance_to_cycle(clock.now().cycle + 1000);
        }
        assert_eq!(clock.now().time, Time(335_983_200));
    }

    #[test]
    fn small_and_large_strides_agree() {
        let mut small = BoardClock::new(Crystal::ppm(-23.456));
        small.set(AT_168_MHZ);
        let mut large = small.clone();
        for _ in 0..12_345 {
            small.advance_to_cycle(small.now().cycle + 7);
        }
        large.advance_to_cycle(12_345 * 7);
        assert_eq!(small.now(), large.now());
    }

    #[test]
    fn an_instant_in_the_past_has_its_cycle() {
        // Exact: two ticks per cycle.
        let mut clock = BoardClock::new(Crystal::ppm(0.0));
        clock.set(AT_168_MHZ);
        clock.advance_to_cycle(1000);
        for (ticks, cycle) in [(2000, 1000), (1999, 999), (1998, 999), (0, 0), (2001, 1000), (2002, 1001)] {
            assert_eq!(clock.cycle_at(Time(ticks)), cycle, "{ticks} ticks");
        }
        // 100 ppm slow: 2.0002 ticks per cycle.
        let mut slow = BoardClock::new(Crystal::ppm(-100.0));
        slow.set(AT_168_MHZ);
        slow.advance_to_cycle(20_000_000);
        assert_eq!(slow.cycle_at(Time(20_002_000)), 9_999_999);
        assert_eq!(slow.cycle_at(Time(20_002_001)), 10_000_000);
    }

    #[test]
    fn advancing_to_an_instant_overshoots_by_less_than_a_cycle() {
        let mut clock = BoardClock::new(Crystal::ppm(12.0));
        clock.set(AT_168_MHZ);
        clock.advance_to(Time(100_001));
        assert!((100_001..=100_002).contains(&clock.now().time.0));
    }

    /// Drift, noise, and an offset that is not a whole number of parts per billion.
    const LIVELY: Crystal =
        Crystal { drift_ppm_per_s: 100.0, white_ppb: 1.0, walk_ppb: 2.0, seed: 7, ..Crystal::ppm(-33.3333) };

    fn lively() -> BoardClock {
        let mut clock = BoardClock::new(LIVELY);
        clock.jump_to(Time(1_234_567));
        clock.set(AT_168_MHZ);
        clock
    }

    #[test]
    fn time_does_not_depend_on_the_strides_of_a_changing_crystal() {
        let mut large = lively();
        large.advance_to_cycle(20_000_000);
        let mut small = lively();
        for _ in 0..20_000_000 / 625 {
            small.advance_to_cycle(small.now().cycle + 625);
        }
        assert_eq!((small.now(), small.remainder), (large.now(), large.remainder));
        let mut sleeper = lively();
        for ms in 0..100 {
            sleeper.advance_to(Time::from_ms(ms));
        }
        sleeper.advance_to_cycle(20_000_000);
        assert_eq!((sleeper.now(), sleeper.remainder), (large.now(), large.remainder));
    }

    #[test]
    fn instants_and_cycles_of_a_changing_crystal_agree_both_ways() {
        let mut clock = lively();
        clock.advance_to_cycle(10_000_000);
        // Past and future, across many steps.
        for cycle in (0..20_000_000).step_by(99_991) {
            let (time, part) = clock.exact_time_at(cycle);
            assert_eq!(clock.time_at(cycle), time);
            let before = if part == 0.0 { cycle } else { cycle - u64::from(cycle > 0) };
            assert!(cycle == 0 || clock.cycle_at(time) == before, "cycle {cycle}");
            let mut then = lively();
            then.advance_to_cycle(cycle);
            assert_eq!((then.now().time, then.remainder as f64 / 1e12), (time, part));
        }
    }

    /// The count of cycles in ten seconds is that of the crystal's own phase.
    #[test]
    fn a_changing_crystal_keeps_its_phase() {
        let crystal = Crystal { drift_ppm_per_s: 0.1, white_ppb: 1.0, walk_ppb: 2.0, ..Crystal::ppm(50.0) };
        let mut clock = BoardClock::new(crystal);
        clock.set(AT_168_MHZ);
        clock.advance_to(Time::from_ms(10_000));
        let ahead = crystal.phase(Time::from_ms(10_000))[2000];
        let expected = 168e6 * (10.0 + ahead);
        // 50 ppm for 10 s and half of 0.1 ppm/s for 10 s: 500 + 5 us, and some ns of noise.
        assert!((ahead - 505e-6).abs() < 0.1e-6, "{ahead:e}");
        assert!((clock.now().cycle as f64 - expected).abs() <= 1.5, "{} for {expected}", clock.now().cycle);
    }
}
