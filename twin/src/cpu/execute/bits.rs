//! Bit fields, saturation, extension, and reordering of bits (A4.4.4, A4.4.6, A4.4.7).

use super::data::shift;
use crate::cpu::core::Core;
use crate::cpu::instruction::{Extension, Instruction as I, Reverse};

/// The value that a signed or unsigned number of `bits` bits can hold next to `value`, and whether it differs (A2.2.1).
pub fn saturated(value: i64, signed: bool, bits: u8) -> (i64, bool) {
    let (least, most) =
        if signed { (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) } else { (0, (1_i64 << bits) - 1) };
    let result = value.clamp(least, most);
    (result, result != value)
}

impl Core {
    /// Runs an instruction of this group. `false`: it belongs to another one.
    pub(super) fn execute_bits(&mut self, instruction: I) -> bool {
        match instruction {
            I::BitFieldInsert { rd, rn, lsb, width } => self.bit_field_insert(rd, self.reg(rn), lsb, width),
            I::BitFieldClear { rd, lsb, width } => self.bit_field_insert(rd, 0, lsb, width),
            I::BitFieldExtract { signed, rd, rn, lsb, width } => {
                let top = self.reg(rn) << (32 - lsb - width);
                let by = 32 - width;
                self.set_reg(rd, if signed { (top as i32 >> by) as u32 } else { top >> by });
            }
            I::Saturate { signed, bits, rd, rn, shift: by } => {
                let (operand, _) = shift(self.reg(rn), by.kind, u32::from(by.amount), self.flags.c);
                let result = self.saturate(i64::from(operand as i32), signed, bits);
                self.set_reg(rd, result as u32);
            }
            I::Saturate16 { signed, bits, rd, rn } => {
                let operand = self.reg(rn);
                let low = self.saturate(i64::from(operand as i16), signed, bits);
                let high = self.saturate(i64::from((operand >> 16) as i16), signed, bits);
                self.set_reg(rd, low as u32 & 0xFFFF | (high as u32) << 16);
            }
            I::Extend { kind, rd, rn, rm, rotation } => self.extend(kind, rd, rn, rm, rotation),
            I::Reverse { kind, rd, rm } => {
                let operand = self.reg(rm);
                let result = match kind {
                    Reverse::Bytes => operand.swap_bytes(),
                    Reverse::BytesOfHalves => operand.swap_bytes().rotate_right(16),
                    Reverse::SignedHalf => (operand as u16).swap_bytes() as i16 as u32,
                    Reverse::Bits => operand.reverse_bits(),
                    Reverse::CountLeadingZeros => operand.leading_zeros(),
                };
                self.set_reg(rd, result);
            }
            _ => return false,
        }
        true
    }

    fn bit_field_insert(&mut self, rd: u8, value: u32, lsb: u8, width: u8) {
        let field = u32::MAX >> (32 - width) << lsb;
        self.set_reg(rd, self.reg(rd) & !field | value << lsb & field);
    }

    /// As [`saturated`]; sets Q if that differs.
    pub(super) fn saturate(&mut self, value: i64, signed: bool, bits: u8) -> i64 {
        let (result, saturates) = saturated(value, signed, bits);
        self.flags.q |= saturates;
        result
    }

    fn extend(&mut self, kind: Extension, rd: u8, rn: u8, rm: u8, rotation: u8) {
        let operand = self.reg(rm).rotate_right(u32::from(rotation));
        let base = if rn == 15 { 0 } else { self.reg(rn) };
        let halves = |low: u32, high: u32| {
            let low = (base & 0xFFFF).wrapping_add(low) & 0xFFFF;
            (base >> 16).wrapping_add(high) << 16 | low
        };
        let result = match kind {
            Extension::SignedByte => base.wrapping_add(operand as i8 as u32),
            Extension::SignedHalf => base.wrapping_add(operand as i16 as u32),
            Extension::Byte => base.wrapping_add(operand & 0xFF),
            Extension::Half => base.wrapping_add(operand & 0xFFFF),
            Extension::SignedBytes16 => halves(operand as i8 as u32, (operand >> 16) as i8 as u32),
            Extension::Bytes16 => halves(operand & 0xFF, operand >> 16 & 0xFF),
        };
        self.set_reg(rd, result);
    }
}
