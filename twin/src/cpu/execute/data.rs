//! Data processing: arithmetic, logic and shifts (A4.4.1, A4.4.2).

use crate::cpu::core::Core;
use crate::cpu::instruction::{Alu, Shift, ShiftKind};

/// Sum, carry and overflow of two words and a carry (A2.2.1).
pub fn add_with_carry(a: u32, b: u32, carry: bool) -> (u32, bool, bool) {
    let (partial, first) = a.overflowing_add(b);
    let (sum, second) = partial.overflowing_add(u32::from(carry));
    (sum, first | second, (a ^ sum) & (b ^ sum) & 1 << 31 != 0)
}

/// A shift by 0 to 255 and its carry (A2.2.1, A7.4.2).
#[inline]
pub fn shift(value: u32, kind: ShiftKind, amount: u32, carry: bool) -> (u32, bool) {
    if amount == 0 {
        return (value, carry);
    }
    // With a bit of room at either end a 64-bit shift leaves the carry there.
    match kind {
        ShiftKind::Lsl => {
            let wide = u64::from(value) << amount.min(33);
            (wide as u32, wide >> 32 & 1 == 1)
        }
        ShiftKind::Lsr => {
            let wide = u64::from(value) << 1 >> amount.min(33);
            ((wide >> 1) as u32, wide & 1 == 1)
        }
        ShiftKind::Asr => {
            let wide = i64::from(value as i32) << 1 >> amount.min(33);
            ((wide >> 1) as u32, wide & 1 == 1)
        }
        ShiftKind::Ror => {
            let result = value.rotate_right(amount % 32);
            (result, result >> 31 == 1)
        }
        ShiftKind::Rrx => (value >> 1 | u32::from(carry) << 31, value & 1 == 1),
    }
}

impl Core {
    #[inline(always)]
    pub(super) fn alu_immediate(&mut self, op: Alu, s: bool, rotated: bool, rd: u8, rn: u8, imm: u32) {
        let carry = if rotated { imm >> 31 == 1 } else { self.flags.c };
        self.alu(op, s, rd, self.reg(rn), imm, carry);
    }

    #[inline(always)]
    pub(super) fn alu_register(&mut self, op: Alu, s: bool, rd: u8, rn: u8, rm: u8, by: Shift) {
        let (operand, carry) = shift(self.reg(rm), by.kind, u32::from(by.amount), self.flags.c);
        self.alu(op, s, rd, self.reg(rn), operand, carry);
    }

    /// Executes one operation. `carry` is that of the second operand, for logical ones.
    #[inline(always)]
    fn alu(&mut self, op: Alu, s: bool, rd: u8, a: u32, b: u32, carry: bool) {
        match op {
            Alu::Mov => self.logical(s, rd, b, carry),
            Alu::Add => self.arithmetic(s, rd, a, b, false),
            Alu::Sub => self.arithmetic(s, rd, a, !b, true),
            Alu::Cmp => {
                self.sum(a, !b, true);
            }
            Alu::And => self.logical(s, rd, a & b, carry),
            Alu::Orr => self.logical(s, rd, a | b, carry),
            Alu::Eor => self.logical(s, rd, a ^ b, carry),
            Alu::Bic => self.logical(s, rd, a & !b, carry),
            Alu::Orn => self.logical(s, rd, a | !b, carry),
            Alu::Mvn => self.logical(s, rd, !b, carry),
            Alu::Adc => self.arithmetic(s, rd, a, b, self.flags.c),
            Alu::Sbc => self.arithmetic(s, rd, a, !b, self.flags.c),
            Alu::Rsb => self.arithmetic(s, rd, !a, b, true),
            Alu::Tst => self.test(a & b, carry),
            Alu::Teq => self.test(a ^ b, carry),
            Alu::Cmn => {
                self.sum(a, b, false);
            }
        }
    }

    fn logical(&mut self, s: bool, rd: u8, result: u32, carry: bool) {
        self.set_reg(rd, result);
        if s {
            self.test(result, carry);
        }
    }

    fn arithmetic(&mut self, s: bool, rd: u8, a: u32, b: u32, carry: bool) {
        if s {
            let sum = self.sum(a, b, carry);
            self.set_reg(rd, sum);
        } else {
            self.set_reg(rd, a.wrapping_add(b).wrapping_add(u32::from(carry)));
        }
    }

    fn test(&mut self, result: u32, carry: bool) {
        self.flags.set_nz(result);
        self.flags.c = carry;
    }

    /// Adds and sets all flags.
    fn sum(&mut self, a: u32, b: u32, carry: bool) -> u32 {
        let (sum, carry, overflow) = add_with_carry(a, b, carry);
        self.flags.set_nz(sum);
        self.flags.c = carry;
        self.flags.v = overflow;
        sum
    }

    pub(super) fn shift_register(&mut self, kind: ShiftKind, s: bool, rd: u8, rn: u8, rm: u8) {
        let amount = self.reg(rm) & 0xFF;
        let (result, carry) = shift(self.reg(rn), kind, amount, self.flags.c);
        self.logical(s, rd, result, carry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_by_a_word_and_more() {
        assert_eq!(shift(0x8000_0001, ShiftKind::Lsl, 32, false), (0, true));
        assert_eq!(shift(0x8000_0001, ShiftKind::Lsl, 33, true), (0, false));
        assert_eq!(shift(0x8000_0001, ShiftKind::Lsr, 32, false), (0, true));
        assert_eq!(shift(0x8000_0001, ShiftKind::Lsr, 255, true), (0, false));
        assert_eq!(shift(0x8000_0001, ShiftKind::Asr, 200, false), (u32::MAX, true));
        assert_eq!(shift(0x8000_0001, ShiftKind::Ror, 32, false), (0x8000_0001, true));
        assert_eq!(shift(0x8000_0001, ShiftKind::Rrx, 1, false), (0x4000_0000, true));
        assert_eq!(shift(2, ShiftKind::Asr, 2, false), (0, true));
    }

    #[test]
    fn sums_with_carry_and_overflow() {
        assert_eq!(add_with_carry(u32::MAX, 0, true), (0, true, false));
        assert_eq!(add_with_carry(0x7FFF_FFFF, 0, true), (0x8000_0000, false, true));
        assert_eq!(add_with_carry(0x8000_0000, 0x8000_0000, false), (0, true, true));
    }
}
