//! Conversions from and to integers, fixed point and half precision (FPToFixed, FixedToFP, FPHalfToSingle, FPSingleToHalf).

use super::{
    DEFAULT_NAN, Float, INEXACT, INFINITY, INVALID, Number, QUIET, Rounding, SIGN, Value, is_signaling,
};

const HALF_DEFAULT_NAN: u32 = 0x7E00;

impl Float {
    /// A number with `fraction` bits after the point, as FPSCR rounds.
    pub fn fixed_to_single(&mut self, value: i64, fraction: u8) -> u32 {
        if value == 0 {
            return 0;
        }
        let number = Number { exponent: -i32::from(fraction), significand: value.unsigned_abs() };
        self.round(value < 0, number)
    }

    /// The nearest number with `fraction` bits after the point that fits in `bits` bits, as `rounding` says.
    ///
    /// NaN gives zero. NaN and what does not fit are invalid.
    pub fn single_to_fixed(
        &mut self,
        a: u32,
        signed: bool,
        bits: u32,
        fraction: u8,
        rounding: Rounding,
    ) -> i64 {
        let negative = a & SIGN != 0;
        let (least, most) = if signed {
            (-(1_i64 << (bits - 1)), (1_i64 << (bits - 1)) - 1)
        } else {
            (0, (1_i64 << bits) - 1)
        };
        let limit = if negative { least } else { most };
        let number = match self.unpack(a) {
            Value::Zero => return 0,
            Value::Nan => {
                self.flags |= INVALID;
                return 0;
            }
            Value::Infinity => {
                self.flags |= INVALID;
                return limit;
            }
            Value::Number(number) => number,
        };
        let scaled = Number { exponent: number.exponent + i32::from(fraction), ..number };
        let rounder = Float { rounding, ..*self };
        let (magnitude, is_inexact) = match scaled.exponent {
            // Far above any limit.
            38.. => (1 << 62, false),
            _ => rounder.round_integer(negative, scaled, 0),
        };
        let value = if negative { -(magnitude as i64) } else { magnitude as i64 };
        if !(least..=most).contains(&value) {
            self.flags |= INVALID;
            return limit;
        }
        if is_inexact {
            self.flags |= INEXACT;
        }
        value
    }

    /// Half precision to single; exact.
    pub fn half_to_single(&mut self, half: u32) -> u32 {
        let sign = (half & 0x8000) << 16;
        let (exponent, fraction) = (half >> 10 & 0x1F, half & 0x3FF);
        match (exponent, fraction) {
            (0, 0) => sign,
            (0x1F, 0) if !self.alternative_half => sign | INFINITY,
            (0x1F, _) if !self.alternative_half => {
                let nan = sign | INFINITY | fraction << 13;
                if is_signaling(nan) {
                    self.flags |= INVALID;
                }
                if self.default_nan { DEFAULT_NAN } else { nan | QUIET }
            }
            (0, _) => {
                // A denormal half is a normal single.
                let leading = fraction.ilog2();
                sign | (leading + 103) << 23 | (fraction << (23 - leading) & 0x007F_FFFF)
            }
            _ => sign | (exponent + 112) << 23 | fraction << 13,
        }
    }

    /// Single precision to half.
    pub fn single_to_half(&mut self, a: u32) -> u32 {
        let sign = a >> 16 & 0x8000;
        match self.unpack(a) {
            Value::Nan => {
                if self.alternative_half || is_signaling(a) {
                    self.flags |= INVALID;
                }
                match (self.alternative_half, self.default_nan) {
                    (true, _) => sign,
                    (false, true) => HALF_DEFAULT_NAN,
                    (false, false) => sign | HALF_DEFAULT_NAN | a >> 13 & 0x1FF,
                }
            }
            Value::Infinity if self.alternative_half => {
                self.flags |= INVALID;
                sign | 0x7FFF
            }
            Value::Infinity => sign | 0x7C00,
            Value::Zero => sign,
            Value::Number(number) => self.round_to_half(sign != 0, number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_survives_the_way_to_single_and_back() {
        for half in 0..=0xFFFF_u32 {
            let is_nan = half & 0x7C00 == 0x7C00 && half & 0x3FF != 0;
            let mut float = Float::new(0);
            let back = float.half_to_single(half);
            let back = float.single_to_half(back);
            assert_eq!(back, if is_nan { half | 0x200 } else { half });
        }
    }

    #[test]
    fn integers_saturate_and_raise_invalid() {
        let mut float = Float::new(0);
        assert_eq!(
            float.single_to_fixed(3.0e9_f32.to_bits(), true, 32, 0, Rounding::ToZero),
            i64::from(i32::MAX)
        );
        assert_eq!(float.single_to_fixed((-1.0_f32).to_bits(), false, 32, 0, Rounding::ToZero), 0);
        assert_eq!(float.flags, INVALID);
        let mut float = Float::new(0);
        assert_eq!(float.single_to_fixed((-2.5_f32).to_bits(), true, 32, 0, Rounding::Nearest), -2);
        assert_eq!(float.flags, INEXACT);
        assert_eq!(float.single_to_fixed(1.5_f32.to_bits(), true, 16, 4, Rounding::ToZero), 24);
    }

    #[test]
    fn integers_to_single_equal_those_of_the_host() {
        for value in [1, -1, 16_777_217, i32::MAX, i32::MIN, 123_456_789] {
            assert_eq!(Float::new(0).fixed_to_single(i64::from(value), 0), (value as f32).to_bits());
        }
        assert_eq!(Float::new(0).fixed_to_single(i64::from(u32::MAX), 0), (u32::MAX as f32).to_bits());
        assert_eq!(Float::new(0).fixed_to_single(1, 4), 0.0625_f32.to_bits());
    }
}
