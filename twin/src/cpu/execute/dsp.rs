//! Parallel and saturating arithmetic, selection and packing (A4.4.5, A4.4.8, A4.4.9).

use super::bits::saturated;
use super::data::shift;
use crate::cpu::core::Core;
use crate::cpu::instruction::{Instruction as I, Lanes, Saturating, Treatment};

/// Lane `index` of `bits` bits.
fn lane(value: u32, index: u32, bits: u32, signed: bool) -> i64 {
    let raw = value >> (index * bits) << (32 - bits);
    if signed { i64::from(raw as i32 >> (32 - bits)) } else { i64::from(raw >> (32 - bits)) }
}

impl Core {
    /// Runs an instruction of this group. `false`: it belongs to another one.
    pub(super) fn execute_dsp(&mut self, instruction: I) -> bool {
        match instruction {
            I::Parallel { lanes, treatment, signed, rd, rn, rm } => {
                let (result, ge) = in_lanes(lanes, treatment, signed, self.reg(rn), self.reg(rm));
                if treatment == Treatment::Plain {
                    self.flags.ge = ge;
                }
                self.set_reg(rd, result);
            }
            I::SaturatingAdd { op, rd, rn, rm } => {
                let (n, m) = (i64::from(self.reg(rn) as i32), i64::from(self.reg(rm) as i32));
                let exact = match op {
                    Saturating::Add => m + n,
                    Saturating::Sub => m - n,
                    Saturating::DoubleAdd => m + self.saturate(2 * n, true, 32),
                    Saturating::DoubleSub => m - self.saturate(2 * n, true, 32),
                };
                let result = self.saturate(exact, true, 32);
                self.set_reg(rd, result as u32);
            }
            I::Select { rd, rn, rm } => {
                let mask = (0..4)
                    .filter(|byte| self.flags.ge >> byte & 1 == 1)
                    .fold(0, |mask, byte| mask | 0xFF_u32 << (8 * byte));
                self.set_reg(rd, self.reg(rn) & mask | self.reg(rm) & !mask);
            }
            I::Pack { top, rd, rn, rm, shift: by } => {
                let (operand, _) = shift(self.reg(rm), by.kind, u32::from(by.amount), self.flags.c);
                let base = self.reg(rn);
                let (high, low) = if top { (base, operand) } else { (operand, base) };
                self.set_reg(rd, high & 0xFFFF_0000 | low & 0xFFFF);
            }
            I::AbsoluteDifferences { rd, rn, rm, ra } => {
                let (n, m) = (self.reg(rn).to_le_bytes(), self.reg(rm).to_le_bytes());
                let sum: u32 = n.into_iter().zip(m).map(|(n, m)| u32::from(n.abs_diff(m))).sum();
                let base = if ra == 15 { 0 } else { self.reg(ra) };
                self.set_reg(rd, base.wrapping_add(sum));
            }
            _ => return false,
        }
        true
    }
}

/// Sums or differences of the lanes of two words, and GE.
fn in_lanes(lanes: Lanes, treatment: Treatment, signed: bool, n: u32, m: u32) -> (u32, u8) {
    let bits = if matches!(lanes, Lanes::Add8 | Lanes::Sub8) { 8 } else { 16 };
    let m = if matches!(lanes, Lanes::Asx | Lanes::Sax) { m.rotate_right(16) } else { m };
    let (mut result, mut ge) = (0, 0);
    for index in 0..32 / bits {
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
    (result, ge)
}
