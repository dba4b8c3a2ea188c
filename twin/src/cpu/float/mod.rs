//! Single-precision arithmetic in integers, with the results and flags of FPv4-SP (A2.5).
//!
//! Operands and results are the bits of a single-precision number. Every operation is exact up to one rounding, in any mode.

mod arithmetic;
mod convert;
mod round;

/// Cumulative flags in FPSCR.
pub const INVALID: u32 = 1;
pub const DIVISION_BY_ZERO: u32 = 1 << 1;
pub const OVERFLOW: u32 = 1 << 2;
pub const UNDERFLOW: u32 = 1 << 3;
pub const INEXACT: u32 = 1 << 4;
pub const INPUT_DENORMAL: u32 = 1 << 7;

pub const SIGN: u32 = 1 << 31;
const QUIET: u32 = 1 << 22;
const INFINITY: u32 = 0x7F80_0000;
const DEFAULT_NAN: u32 = 0x7FC0_0000;

/// Rounding mode, as RMode in FPSCR counts them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    Nearest,
    Up,
    Down,
    ToZero,
}

/// Modes of FPSCR, and the flags that operations raise.
#[derive(Clone, Copy, Debug)]
pub struct Float {
    pub rounding: Rounding,
    flush_to_zero: bool,
    default_nan: bool,
    alternative_half: bool,
    pub flags: u32,
}

/// An operand, taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Value {
    Nan,
    Infinity,
    Zero,
    Number(Number),
}

/// `significand` times two to the power of `exponent`; the significand is not zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Number {
    exponent: i32,
    significand: u64,
}

impl Number {
    /// Returns the same number with its leading bit at `bit`. The significand must not have a higher bit.
    fn with_leading_bit(self, bit: u32) -> Self {
        let shift = bit - self.significand.ilog2();
        Number { exponent: self.exponent - shift as i32, significand: self.significand << shift }
    }
}

impl Float {
    /// Modes as in FPSCR, no flags.
    pub fn new(fpscr: u32) -> Self {
        Float {
            rounding: match fpscr >> 22 & 3 {
                0 => Rounding::Nearest,
                1 => Rounding::Up,
                2 => Rounding::Down,
                _ => Rounding::ToZero,
            },
            flush_to_zero: fpscr >> 24 & 1 == 1,
            default_nan: fpscr >> 25 & 1 == 1,
            alternative_half: fpscr >> 26 & 1 == 1,
            flags: 0,
        }
    }

    /// Takes an operand apart; a denormal one counts as zero in flush-to-zero mode (FPUnpack).
    fn unpack(&mut self, bits: u32) -> Value {
        let (exponent, fraction) = (bits >> 23 & 0xFF, u64::from(bits & 0x007F_FFFF));
        match (exponent, fraction) {
            (0xFF, 0) => Value::Infinity,
            (0xFF, _) => Value::Nan,
            (0, 0) => Value::Zero,
            (0, _) if self.flush_to_zero => {
                self.flags |= INPUT_DENORMAL;
                Value::Zero
            }
            (0, significand) => Value::Number(Number { exponent: -149, significand }),
            _ => Value::Number(Number { exponent: exponent as i32 - 150, significand: fraction | 1 << 23 }),
        }
    }

    fn invalid(&mut self) -> u32 {
        self.flags |= INVALID;
        DEFAULT_NAN
    }

    /// The NaN that a NaN operand gives (FPProcessNaN).
    fn quiet(&mut self, nan: u32) -> u32 {
        if is_signaling(nan) {
            self.flags |= INVALID;
        }
        if self.default_nan { DEFAULT_NAN } else { nan | QUIET }
    }

    /// The NaN of some operands: the first signaling one, or else the first quiet one (FPProcessNaNs).
    fn nan_of(&mut self, operands: &[u32]) -> Option<u32> {
        let mut nans = operands.iter().copied();
        let nan =
            nans.clone().find(|&bits| is_signaling(bits)).or_else(|| nans.find(|&bits| is_nan(bits)))?;
        Some(self.quiet(nan))
    }
}

fn is_nan(bits: u32) -> bool {
    bits & !SIGN > INFINITY
}

fn is_signaling(bits: u32) -> bool {
    is_nan(bits) && bits & QUIET == 0
}

/// A number shifted right; bits that are lost leave a one at the end.
fn shift_right_sticky(significand: u64, by: u32) -> u64 {
    match by {
        0 => significand,
        1..=63 => significand >> by | u64::from(significand << (64 - by) != 0),
        _ => u64::from(significand != 0),
    }
}
