//! Addition, multiplication, fused multiply-add, division, square root and comparison (A2.5.6 and following).

use super::{
    DIVISION_BY_ZERO, Float, INFINITY, INVALID, Number, SIGN, Value, is_nan, is_signaling, shift_right_sticky,
};

/// Position of the leading bit of a sum's operands. Products of 48 bits fit, and so does a carry.
const LEADING: u32 = 61;

fn is_negative(bits: u32) -> bool {
    bits & SIGN != 0
}

/// Result of a comparison, as NZCV.
const LESS: u32 = 0b1000;
const EQUAL: u32 = 0b0110;
const GREATER: u32 = 0b0010;
const UNORDERED: u32 = 0b0011;

impl Float {
    pub fn add(&mut self, a: u32, b: u32) -> u32 {
        self.add_signed(a, b, is_negative(b))
    }

    pub fn sub(&mut self, a: u32, b: u32) -> u32 {
        self.add_signed(a, b, !is_negative(b))
    }

    /// `a` plus `b`, whose sign is given apart because a NaN keeps its own.
    fn add_signed(&mut self, a: u32, b: u32, b_negative: bool) -> u32 {
        let a_negative = is_negative(a);
        let sign = if b_negative { SIGN } else { 0 };
        let (x, y) = (self.unpack(a), self.unpack(b));
        if let Some(nan) = self.nan_of(&[a, b]) {
            return nan;
        }
        match (x, y) {
            (Value::Infinity, Value::Infinity) if a_negative != b_negative => self.invalid(),
            (Value::Infinity, _) => a,
            (_, Value::Infinity) => sign | INFINITY,
            (Value::Number(x), Value::Number(y)) => self.sum(a_negative, x, b_negative, y),
            (Value::Number(x), _) => self.round(a_negative, x),
            (_, Value::Number(y)) => self.round(b_negative, y),
            _ if a_negative == b_negative => sign,
            _ => self.exact_zero(),
        }
    }

    fn sum(&mut self, x_negative: bool, x: Number, y_negative: bool, y: Number) -> u32 {
        let (x, y) = (x.with_leading_bit(LEADING), y.with_leading_bit(LEADING));
        let exponent = x.exponent.max(y.exponent);
        let x_aligned = shift_right_sticky(x.significand, (exponent - x.exponent) as u32);
        let y_aligned = shift_right_sticky(y.significand, (exponent - y.exponent) as u32);
        let (negative, significand) = match x_negative == y_negative {
            true => (x_negative, x_aligned + y_aligned),
            false if x_aligned >= y_aligned => (x_negative, x_aligned - y_aligned),
            false => (y_negative, y_aligned - x_aligned),
        };
        if significand == 0 {
            return self.exact_zero();
        }
        self.round(negative, Number { exponent, significand })
    }

    pub fn mul(&mut self, a: u32, b: u32) -> u32 {
        let negative = is_negative(a ^ b);
        let sign = (a ^ b) & SIGN;
        let (x, y) = (self.unpack(a), self.unpack(b));
        if let Some(nan) = self.nan_of(&[a, b]) {
            return nan;
        }
        match (x, y) {
            (Value::Infinity, Value::Zero) | (Value::Zero, Value::Infinity) => self.invalid(),
            (Value::Infinity, _) | (_, Value::Infinity) => sign | INFINITY,
            (Value::Number(x), Value::Number(y)) => self.round(negative, product(x, y)),
            _ => sign,
        }
    }

    /// `addend` plus `a` times `b`, rounded once (FPMulAdd).
    pub fn mul_add(&mut self, addend: u32, a: u32, b: u32) -> u32 {
        let (base, x, y) = (self.unpack(addend), self.unpack(a), self.unpack(b));
        let no_product = matches!((x, y), (Value::Infinity, Value::Zero) | (Value::Zero, Value::Infinity));
        if no_product && base == Value::Nan && !is_signaling(addend) {
            return self.invalid();
        }
        if let Some(nan) = self.nan_of(&[addend, a, b]) {
            return nan;
        }
        let (base_negative, negative) = (is_negative(addend), is_negative(a ^ b));
        let sign = (a ^ b) & SIGN;
        let infinite = x == Value::Infinity || y == Value::Infinity;
        match (base, x, y) {
            _ if no_product => self.invalid(),
            (Value::Infinity, ..) if infinite && base_negative != negative => self.invalid(),
            (Value::Infinity, ..) => addend,
            _ if infinite => sign | INFINITY,
            (Value::Number(base), Value::Number(x), Value::Number(y)) => {
                self.sum(base_negative, base, negative, product(x, y))
            }
            (_, Value::Number(x), Value::Number(y)) => self.round(negative, product(x, y)),
            (Value::Number(base), ..) => self.round(base_negative, base),
            _ if base_negative == negative => sign,
            _ => self.exact_zero(),
        }
    }

    pub fn div(&mut self, a: u32, b: u32) -> u32 {
        let negative = is_negative(a ^ b);
        let sign = (a ^ b) & SIGN;
        let (x, y) = (self.unpack(a), self.unpack(b));
        if let Some(nan) = self.nan_of(&[a, b]) {
            return nan;
        }
        match (x, y) {
            (Value::Infinity, Value::Infinity) | (Value::Zero, Value::Zero) => self.invalid(),
            (Value::Number(_), Value::Zero) => {
                self.flags |= DIVISION_BY_ZERO;
                sign | INFINITY
            }
            (Value::Infinity, _) => sign | INFINITY,
            (Value::Number(x), Value::Number(y)) => {
                let (x, y) = (x.with_leading_bit(63), y.with_leading_bit(23));
                let quotient = x.significand / y.significand;
                let sticky = u64::from(x.significand % y.significand != 0);
                self.round(
                    negative,
                    Number { exponent: x.exponent - y.exponent, significand: quotient | sticky },
                )
            }
            _ => sign,
        }
    }

    pub fn sqrt(&mut self, a: u32) -> u32 {
        let value = self.unpack(a);
        if let Some(nan) = self.nan_of(&[a]) {
            return nan;
        }
        match value {
            Value::Zero => a & SIGN,
            _ if is_negative(a) => self.invalid(),
            Value::Number(number) => {
                let mut number = number.with_leading_bit(63);
                if number.exponent % 2 != 0 {
                    number = Number { exponent: number.exponent + 1, significand: number.significand >> 1 };
                }
                let root = number.significand.isqrt();
                let sticky = u64::from(root * root != number.significand);
                self.round(
                    false,
                    Number { exponent: number.exponent / 2 - 1, significand: root << 1 | sticky },
                )
            }
            _ => INFINITY,
        }
    }

    /// NZCV of a comparison; a quiet NaN is invalid with `quiet_raises` (FPCompare).
    pub fn compare(&mut self, a: u32, b: u32, quiet_raises: bool) -> u32 {
        let (x, y) = (self.unpack(a), self.unpack(b));
        if is_nan(a) || is_nan(b) {
            if quiet_raises || is_signaling(a) || is_signaling(b) {
                self.flags |= INVALID;
            }
            return UNORDERED;
        }
        // Sign and magnitude as an integer; a flushed operand is zero.
        let ordered = |value, bits: u32| match (value, is_negative(bits)) {
            (Value::Zero, _) => 0,
            (_, false) => i64::from(bits),
            (_, true) => -i64::from(bits & !SIGN),
        };
        match ordered(x, a).cmp(&ordered(y, b)) {
            std::cmp::Ordering::Less => LESS,
            std::cmp::Ordering::Equal => EQUAL,
            std::cmp::Ordering::Greater => GREATER,
        }
    }
}

fn product(x: Number, y: Number) -> Number {
    Number { exponent: x.exponent + y.exponent, significand: x.significand * y.significand }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns operands at the limits of every class.
    fn samples() -> Vec<u32> {
        let mut bits =
            vec![0, 1, 0x007F_FFFF, 0x0080_0000, 0x3F80_0000, 0x3F80_0001, 0x4B7F_FFFF, 0x7F7F_FFFF];
        let mut state = 1_u32;
        for _ in 0..120 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            bits.push(state & !SIGN);
        }
        let negative: Vec<u32> = bits.iter().map(|bits| bits | SIGN).collect();
        bits.extend(negative);
        bits.retain(|&bits| !is_nan(bits));
        bits
    }

    /// The host rounds to nearest as IEEE 754 says.
    #[test]
    fn results_to_nearest_equal_those_of_the_host() {
        let float = || Float::new(0);
        let samples = samples();
        for &a in &samples {
            let x = f32::from_bits(a);
            if x >= 0.0 {
                assert_eq!(float().sqrt(a), x.sqrt().to_bits(), "sqrt {a:08X}");
            }
            for (&b, &c) in samples.iter().zip(samples.iter().rev()) {
                let (y, z) = (f32::from_bits(b), f32::from_bits(c));
                let cases = [
                    (float().add(a, b), x + y, "add"),
                    (float().sub(a, b), x - y, "sub"),
                    (float().mul(a, b), x * y, "mul"),
                    (float().div(a, b), x / y, "div"),
                    (float().mul_add(c, a, b), x.mul_add(y, z), "fma"),
                ];
                for (ours, host, op) in cases.into_iter().filter(|(_, host, _)| !host.is_nan()) {
                    assert_eq!(ours, host.to_bits(), "{op} {a:08X} {b:08X} {c:08X}");
                }
            }
        }
    }

    #[test]
    fn directed_rounding_encloses_the_exact_result() {
        let third = |mode: u32| {
            let mut float = Float::new(mode << 22);
            (float.div(1.0_f32.to_bits(), 3.0_f32.to_bits()), float.flags)
        };
        let inexact = super::super::INEXACT;
        assert_eq!(third(1), (0x3EAA_AAAB, inexact));
        assert_eq!(third(2), (0x3EAA_AAAA, inexact));
        assert_eq!(third(3), (0x3EAA_AAAA, inexact));
    }

    #[test]
    fn flush_to_zero_raises_input_denormal_and_underflow() {
        let mut float = Float::new(1 << 24);
        assert_eq!(float.add(1, 2), 0);
        assert_eq!(float.flags, super::super::INPUT_DENORMAL);
        let mut float = Float::new(1 << 24);
        assert_eq!(float.mul(0x0080_0000, 0x3F00_0000), 0);
        assert_eq!(float.flags, super::super::UNDERFLOW);
    }

    #[test]
    fn first_signaling_operand_decides_the_nan() {
        let mut float = Float::new(0);
        assert_eq!(float.add(0x7FC0_0001, 0x7F80_0002), 0x7FC0_0002);
        assert_eq!(float.flags, INVALID);
        let mut float = Float::new(1 << 25);
        assert_eq!(float.add(0x7FC0_0001, 0), 0x7FC0_0000);
        assert_eq!(float.flags, 0);
    }
}
