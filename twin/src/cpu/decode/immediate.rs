//! 32-bit data processing with a constant (A5.3.1 to A5.3.3).

use super::{bad, bit, bits, reg, unless};
use crate::cpu::instruction::{Alu, Instruction, Reg, Shift, ShiftKind};

const SP: Reg = 13;
const PC: Reg = 15;

/// Constant of 12 bits: a byte, repeated or rotated, and whether it is rotated (A5.3.2). `None`: UNPREDICTABLE.
fn expand(imm12: u32) -> Option<(u32, bool)> {
    let byte = imm12 & 0xFF;
    match imm12 >> 8 {
        0 => Some((byte, false)),
        1..=3 if byte == 0 => None,
        1 => Some((byte << 16 | byte, false)),
        2 => Some((byte << 24 | byte << 8, false)),
        3 => Some((byte * 0x0101_0101, false)),
        _ => Some(((0x80 | byte & 0x7F).rotate_right(imm12 >> 7), true)),
    }
}

/// The operation of four bits on these registers; `None` is UNDEFINED. Shared with the shifted-register forms.
pub fn operation(op: u32, s: bool, rd: Reg, rn: Reg) -> Option<Alu> {
    Some(match op {
        0b0000 if rd == PC && s => Alu::Tst,
        0b0000 => Alu::And,
        0b0001 => Alu::Bic,
        0b0010 if rn == PC => Alu::Mov,
        0b0010 => Alu::Orr,
        0b0011 if rn == PC => Alu::Mvn,
        0b0011 => Alu::Orn,
        0b0100 if rd == PC && s => Alu::Teq,
        0b0100 => Alu::Eor,
        0b1000 if rd == PC && s => Alu::Cmn,
        0b1000 => Alu::Add,
        0b1010 => Alu::Adc,
        0b1011 => Alu::Sbc,
        0b1101 if rd == PC && s => Alu::Cmp,
        0b1101 => Alu::Sub,
        0b1110 => Alu::Rsb,
        _ => return None,
    })
}

/// Returns whether the manual forbids these registers for the operation. SP may be base and destination of ADD and SUB.
pub fn is_unpredictable(op: Alu, rd: Reg, rn: Reg) -> bool {
    match op {
        Alu::Tst | Alu::Teq => bad(rn),
        Alu::Cmn | Alu::Cmp => rn == PC,
        Alu::Mov | Alu::Mvn => bad(rd),
        Alu::Add | Alu::Sub if rn == SP => rd == PC,
        Alu::Add | Alu::Sub => bad(rd) || rn == PC,
        _ => bad(rd) || bad(rn),
    }
}

/// Data processing with a modified constant (A5.3.1).
pub fn modified(h1: u32, h2: u32) -> Instruction {
    let (s, rn, rd) = (bit(h1, 4), reg(h1, 0), reg(h2, 8));
    let Some(op) = operation(bits(h1, 5, 4), s, rd, rn) else { return Instruction::Undefined };
    let imm12 = bits(h1, 10, 1) << 11 | bits(h2, 12, 3) << 8 | bits(h2, 0, 8);
    match expand(imm12) {
        Some((imm, rotated)) if !is_unpredictable(op, rd, rn) => {
            Instruction::AluImmediate { op, s, rotated, rd, rn, imm }
        }
        _ => Instruction::Unpredictable,
    }
}

/// Data processing with a plain constant (A5.3.3).
pub fn plain(h1: u32, h2: u32) -> Instruction {
    let (rn, rd) = (reg(h1, 0), reg(h2, 8));
    let imm12 = bits(h1, 10, 1) << 11 | bits(h2, 12, 3) << 8 | bits(h2, 0, 8);
    let imm16 = bits(h1, 0, 4) << 12 | imm12;
    match bits(h1, 4, 5) {
        op @ (0b00000 | 0b01010) => {
            let subtract = op != 0;
            if rn == PC {
                let offset = if subtract { -(imm12 as i16) } else { imm12 as i16 };
                return unless(bad(rd), Instruction::Adr { rd, offset });
            }
            let op = if subtract { Alu::Sub } else { Alu::Add };
            unless(
                is_unpredictable(op, rd, rn),
                Instruction::AluImmediate { op, s: false, rotated: false, rd, rn, imm: imm12 },
            )
        }
        0b00100 => unless(
            bad(rd),
            Instruction::AluImmediate { op: Alu::Mov, s: false, rotated: false, rd, rn: 0, imm: imm16 },
        ),
        0b01100 => unless(bad(rd), Instruction::MovTop { rd, imm: imm16 as u16 }),
        op @ (0b10000 | 0b10010 | 0b11000 | 0b11010) => saturate(op, h1, h2),
        op @ (0b10100 | 0b10110 | 0b11100) => bit_field(op, h1, h2),
        _ => Instruction::Undefined,
    }
}

fn saturate(op: u32, h1: u32, h2: u32) -> Instruction {
    let (rn, rd) = (reg(h1, 0), reg(h2, 8));
    let signed = op < 0b11000;
    let amount = (bits(h2, 12, 3) << 2 | bits(h2, 6, 2)) as u8;
    let arithmetic = op & 0b10 != 0;
    let forbidden = bad(rd) || bad(rn) || bit(h1, 10) || bit(h2, 5);
    if arithmetic && amount == 0 {
        let bits = bits(h2, 0, 4) as u8 + u8::from(signed);
        return unless(forbidden || bit(h2, 4), Instruction::Saturate16 { signed, bits, rd, rn });
    }
    let shift = Shift { kind: if arithmetic { ShiftKind::Asr } else { ShiftKind::Lsl }, amount };
    let bits = bits(h2, 0, 5) as u8 + u8::from(signed);
    unless(forbidden, Instruction::Saturate { signed, bits, rd, rn, shift })
}

fn bit_field(op: u32, h1: u32, h2: u32) -> Instruction {
    let (rn, rd) = (reg(h1, 0), reg(h2, 8));
    let lsb = (bits(h2, 12, 3) << 2 | bits(h2, 6, 2)) as u8;
    let last = bits(h2, 0, 5) as u8;
    let forbidden = bad(rd) || bit(h1, 10) || bit(h2, 5);
    if op == 0b10110 {
        let forbidden = forbidden || last < lsb || rn == SP;
        // Only used where `last` is not less.
        let width = last.wrapping_sub(lsb).wrapping_add(1);
        let clear = Instruction::BitFieldClear { rd, lsb, width };
        let insert = Instruction::BitFieldInsert { rd, rn, lsb, width };
        return unless(forbidden, if rn == PC { clear } else { insert });
    }
    unless(
        forbidden || bad(rn) || lsb + last > 31,
        Instruction::BitFieldExtract { signed: op == 0b10100, rd, rn, lsb, width: last + 1 },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modified_constants_as_in_table_a5_11() {
        assert_eq!(expand(0x0AB), Some((0xAB, false)));
        assert_eq!(expand(0x1AB), Some((0x00AB_00AB, false)));
        assert_eq!(expand(0x2AB), Some((0xAB00_AB00, false)));
        assert_eq!(expand(0x3AB), Some((0xABAB_ABAB, false)));
        assert_eq!(expand(0x47F), Some((0xFF00_0000, true)));
        assert_eq!(expand(0xFFF), Some((0x0000_01FE, true)));
        assert_eq!(expand(0x100), None);
    }
}
