//! Virtual time in ticks of 1/336 µs.
//!
//! 336 MHz is the least common multiple of the clocks in use (168, 84, 42 and 16 MHz), so that every nominal clock
//! edge falls on an integer tick.

use core::ops::{Add, AddAssign, Sub};

/// Ticks per microsecond.
pub const TICKS_PER_US: u64 = 336;

/// A point on the virtual time axis, or a span on it, in ticks of 1/336 µs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Time(pub u64);

impl Time {
    /// The start of the simulation.
    pub const ZERO: Time = Time(0);
    /// Later than everything.
    pub const NEVER: Time = Time(u64::MAX);

    /// Makes a time from whole microseconds.
    pub const fn from_us(us: u64) -> Self {
        Time(us * TICKS_PER_US)
    }

    /// Makes a time from whole milliseconds.
    pub const fn from_ms(ms: u64) -> Self {
        Time::from_us(ms * 1000)
    }

    /// Makes a time from nanoseconds, rounded to the nearest tick.
    pub const fn from_ns(ns: u64) -> Self {
        Time((ns * TICKS_PER_US + 500) / 1000)
    }

    /// Whole microseconds, rounded down.
    pub const fn as_us(self) -> u64 {
        self.0 / TICKS_PER_US
    }

    /// Seconds, for people and plots; never for comparisons.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 / (TICKS_PER_US as f64 * 1e6)
    }

    /// The span from `earlier` to here, zero when `earlier` is later.
    pub const fn since(self, earlier: Time) -> Time {
        Time(self.0.saturating_sub(earlier.0))
    }
}

impl Add for Time {
    type Output = Time;
    fn add(self, rhs: Time) -> Time {
        Time(self.0.saturating_add(rhs.0))
    }
}

impl AddAssign for Time {
    fn add_assign(&mut self, rhs: Time) {
        *self = *self + rhs;
    }
}

impl Sub for Time {
    type Output = Time;
    fn sub(self, rhs: Time) -> Time {
        self.since(rhs)
    }
}
