//! Parallel and saturating arithmetic, selection and packing (A4.4.5, A4.4.8, A4.4.9).

use super::bits::saturated;
use super::data::shift;
use crate::core::Core;
use crate::instruction::{Lanes, Saturating, Shift, Treatment};

/// Lane `index` of `bits` bits.
fn lane(value: u32, index: u32, bits: u32, signed: bool) -> i64 {
    let raw = value >> (index * bits) << (32 - bits);
    if signed { i64::from(raw as i32 >> (32 - bits)) } else { i64::from(raw >> (32 - bits)) }
}

impl Core {
    pub(super) fn parallel(
        &mut self,
        lanes: Lanes,
        treatment: Treatment,
        signed: bool,
        rd: u8,
        rn: u8,
        rm: u8,
    ) {
        let bits = if matches!(lanes, Lanes::Add8 | Lanes::Sub8) { 8 } else { 16 };
        let count = 32 / bits;
        let n = self.reg(rn);
        let m = match lanes {
            Lanes::Asx | Lanes::Sax => self.reg(rm).rotate_right(16),
            _ => self.reg(rm),
        };
        let mut result = 0;
        let mut ge = 0;
        for index in 0..count {
            let subtracts = match lanes {
                Lanes::Add16 | Lanes::Add8 => false,
                Lanes::Sub16 | Lanes::Sub8 => true,
                Lanes::Asx => index == 0,
                Lanes::Sax => index == 1,
            };
            let (a, b) = (lane(n, index, bits, signed), lane(m, index, bits, signed));
            let exact = if subtracts { a - b } else { a + b };
            // GE: the result is not negative, or the unsigned sum has a carry.
            let is_ge = if signed || subtracts { exact >= 0 } else { exact >> bits != 0 };
            if is_ge {
                // Two bits for a half-word, one for a byte.
                ge |= (if bits == 16 { 3 } else { 1 }) << (index * bits / 8);
            }
            let value = match treatment {
                Treatment::Plain => exact,
                Treatment::Saturating => saturated(exact, signed, bits as u8).0,
                Treatment::Halving => exact >> 1,
            };
            result |= (value as u32 & u32::MAX >> (32 - bits)) << (index * bits);
        }
        if treatment == Treatment::Plain {
            self.flags.ge = ge;
        }
        self.set_reg(rd, result);
    }

    pub(super) fn saturating_add(&mut self, op: Saturating, rd: u8, rn: u8, rm: u8) {
        let (n, m) = (i64::from(self.reg(rn) as i32), i64::from(self.reg(rm) as i32));
        let mut saturate = |value| {
            let (result, saturates) = saturated(value, true, 32);
            self.flags.q |= saturates;
            result
        };
        let result = match op {
            Saturating::Add => saturate(m + n),
            Saturating::Sub => saturate(m - n),
            Saturating::DoubleAdd => {
                let doubled = saturate(2 * n);
                saturate(m + doubled)
            }
            Saturating::DoubleSub => {
                let doubled = saturate(2 * n);
                saturate(m - doubled)
            }
        };
        self.set_reg(rd, result as u32);
    }

    pub(super) fn select(&mut self, rd: u8, rn: u8, rm: u8) {
        let mask = (0..4)
            .filter(|byte| self.flags.ge >> byte & 1 == 1)
            .fold(0, |mask, byte| mask | 0xFF_u32 << (8 * byte));
        self.set_reg(rd, self.reg(rn) & mask | self.reg(rm) & !mask);
    }

    pub(super) fn pack(&mut self, top: bool, rd: u8, rn: u8, rm: u8, by: Shift) {
        let (operand, _) = shift(self.reg(rm), by.kind, u32::from(by.amount), self.flags.c);
        let base = self.reg(rn);
        let result =
            if top { base & 0xFFFF_0000 | operand & 0xFFFF } else { operand & 0xFFFF_0000 | base & 0xFFFF };
        self.set_reg(rd, result);
    }

    pub(super) fn absolute_differences(&mut self, rd: u8, rn: u8, rm: u8, ra: u8) {
        let (n, m) = (self.reg(rn).to_le_bytes(), self.reg(rm).to_le_bytes());
        let sum: u32 = n.into_iter().zip(m).map(|(n, m)| u32::from(n.abs_diff(m))).sum();
        let base = if ra == 15 { 0 } else { self.reg(ra) };
        self.set_reg(rd, base.wrapping_add(sum));
    }
}
