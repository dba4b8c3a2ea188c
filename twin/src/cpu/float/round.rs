//! Rounding to a format (FPRound in the manual).

use super::{Float, INEXACT, INFINITY, INVALID, Number, OVERFLOW, Rounding, SIGN, UNDERFLOW};

/// Bits of fraction and exponent.
#[derive(Clone, Copy)]
struct Format {
    fraction: u32,
    exponent: u32,
}

const SINGLE: Format = Format { fraction: 23, exponent: 8 };
const HALF: Format = Format { fraction: 10, exponent: 5 };

impl Float {
    /// Rounds to single precision.
    pub(super) fn round(&mut self, negative: bool, number: Number) -> u32 {
        let sign = if negative { SIGN } else { 0 };
        let leading = number.exponent + number.significand.ilog2() as i32;
        if self.flush_to_zero && leading < -126 {
            self.flags |= UNDERFLOW;
            return sign;
        }
        let magnitude = self.round_to(SINGLE, negative, number);
        let limit = INFINITY;
        if magnitude < limit {
            return sign | magnitude;
        }
        self.flags |= OVERFLOW | INEXACT;
        sign | if self.overflows_to_infinity(negative) { limit } else { limit - 1 }
    }

    /// Rounds to half precision. The alternative format has no infinity (A2.5.3).
    pub(super) fn round_to_half(&mut self, negative: bool, number: Number) -> u32 {
        let sign = u32::from(negative) << 15;
        let flags = self.flags;
        let magnitude = self.round_to(HALF, negative, number);
        if self.alternative_half {
            if magnitude <= 0x7FFF {
                return sign | magnitude;
            }
            self.flags = flags | INVALID;
            return sign | 0x7FFF;
        }
        let limit = 0x7C00;
        if magnitude < limit {
            return sign | magnitude;
        }
        self.flags |= OVERFLOW | INEXACT;
        sign | if self.overflows_to_infinity(negative) { limit } else { limit - 1 }
    }

    fn overflows_to_infinity(&self, negative: bool) -> bool {
        match self.rounding {
            Rounding::Nearest => true,
            Rounding::Up => !negative,
            Rounding::Down => negative,
            Rounding::ToZero => false,
        }
    }

    /// Exponent and fraction of the rounded number, without a limit to the exponent.
    fn round_to(&mut self, format: Format, negative: bool, number: Number) -> u32 {
        let least = 2 - (1 << (format.exponent - 1));
        let leading = number.exponent + number.significand.ilog2() as i32;
        let last = leading.max(least) - format.fraction as i32;
        let (integer, is_inexact) = self.round_integer(negative, number, last);
        if is_inexact {
            self.flags |= INEXACT;
            if leading < least {
                self.flags |= UNDERFLOW;
            }
        }
        // The leading one of the integer adds one to the exponent, as does a carry out of the fraction. An exponent
        // that is far too large has the same result as one that is just too large.
        let biased = (leading.max(least) - least).clamp(0, 1 << format.exponent) as u32;
        (biased << format.fraction) + integer as u32
    }

    /// The number in units of two to the power of `last`, rounded, and whether it is inexact.
    pub(super) fn round_integer(&self, negative: bool, number: Number, last: i32) -> (u64, bool) {
        let shift = last - number.exponent;
        if shift <= 0 {
            return (number.significand << -shift, false);
        }
        let (integer, rest) = match shift {
            1..=63 => (number.significand >> shift, number.significand << (64 - shift)),
            64 => (0, number.significand),
            _ => (0, 1),
        };
        let half = 1 << 63;
        let up = match self.rounding {
            Rounding::Nearest => rest > half || (rest == half && integer & 1 == 1),
            Rounding::Up => rest != 0 && !negative,
            Rounding::Down => rest != 0 && negative,
            Rounding::ToZero => false,
        };
        (integer + u64::from(up), rest != 0)
    }

    /// The sign of an exact zero that is the sum of numbers of different signs.
    pub(super) fn exact_zero(&self) -> u32 {
        if self.rounding == Rounding::Down { SIGN } else { 0 }
    }
}
