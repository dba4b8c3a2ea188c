//! Instants and durations of protocol timers, in microseconds.
//!
//! All arithmetic saturates: a timer far in the future never wraps into the past.

use core::ops::{Add, AddAssign, Sub};

/// Microseconds since the power-on of the node. Aligned to words: with an alignment of eight, every event and
/// every deadline of a node would have four bytes of padding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C, packed(4))]
pub struct Instant(u64);

/// Time span in microseconds. Aligned to words, as [`Instant`] is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C, packed(4))]
pub struct Duration(u64);

#[cfg(feature = "defmt")]
impl defmt::Format for Instant {
    fn format(&self, fmt: defmt::Formatter<'_>) {
        defmt::write!(fmt, "Instant({=u64})", self.as_micros());
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Duration {
    fn format(&self, fmt: defmt::Formatter<'_>) {
        defmt::write!(fmt, "Duration({=u64})", self.as_micros());
    }
}

impl Instant {
    /// Instant of power-on.
    pub const ZERO: Instant = Instant(0);

    /// Instant after all others.
    pub const NEVER: Instant = Instant(u64::MAX);

    /// Takes microseconds since power-on.
    pub const fn from_micros(us: u64) -> Instant {
        Instant(us)
    }

    /// Returns the microseconds since power-on.
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// Makes the instant `latest` if it is later: a bit of it flipped.
    #[cfg_attr(target_os = "none", inline(never))] // row `size.pyboard-v11.slave.flash`
    pub fn confine(&mut self, latest: Instant) {
        if *self > latest {
            *self = latest;
        }
    }

    /// Returns the span since `earlier`, zero if `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Instant) -> Duration {
        Duration(self.0.saturating_sub(earlier.0))
    }
}

/// Returns the first of several deadlines, if there is one.
#[inline(never)] // asked for in many places
pub fn earliest(deadlines: &[Option<Instant>]) -> Option<Instant> {
    deadlines.iter().flatten().min().copied()
}

impl Duration {
    /// Duration of zero.
    pub const ZERO: Duration = Duration(0);

    /// Takes a number of microseconds.
    pub const fn from_micros(us: u64) -> Duration {
        Duration(us)
    }

    /// Takes a number of milliseconds.
    pub const fn from_millis(ms: u64) -> Duration {
        Duration(ms.saturating_mul(1_000))
    }

    /// Returns the number of microseconds.
    pub const fn as_micros(self) -> u64 {
        self.0
    }

    /// Returns whole milliseconds, rounded down.
    pub const fn as_millis(self) -> u64 {
        self.0 / 1_000
    }

    /// Returns a span that is `factor` times as long.
    #[must_use]
    #[inline(always)]
    pub const fn times(self, factor: u32) -> Duration {
        Duration(product(self.0, factor))
    }
}

/// Seldom, and long on a chip of 32 bits.
#[cfg_attr(target_os = "none", inline(never))]
const fn product(one: u64, factor: u32) -> u64 {
    one.saturating_mul(factor as u64)
}

impl Add<Duration> for Instant {
    type Output = Instant;
    #[inline(always)]
    fn add(self, span: Duration) -> Instant {
        Instant(sum(self.0, span.0))
    }
}

impl AddAssign<Duration> for Instant {
    fn add_assign(&mut self, span: Duration) {
        *self = *self + span;
    }
}

impl Sub<Duration> for Instant {
    type Output = Instant;
    fn sub(self, span: Duration) -> Instant {
        Instant(self.0.saturating_sub(span.0))
    }
}

impl Add for Duration {
    type Output = Duration;
    #[inline(always)]
    fn add(self, other: Duration) -> Duration {
        Duration(sum(self.0, other.0))
    }
}

/// On a chip of 32 bits a call is a third of the code, and it is in 60 places. With numbers all of it is in
/// registers: an instant would be returned in memory.
#[cfg_attr(target_os = "none", inline(never))]
const fn sum(one: u64, other: u64) -> u64 {
    one.saturating_add(other)
}
