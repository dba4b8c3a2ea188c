//! 32-bit data processing of registers (A5.3.11, A5.3.12 and A5.3.13 to A5.3.15).

use super::immediate::{is_unpredictable, operation};
use super::{bad, bit, bits, immediate_shift, reg, unless};
use crate::cpu::instruction::{
    Alu, Extension, Instruction, Lanes, Reverse, Saturating, Shift, ShiftKind, Treatment,
};

/// Data processing with a shifted register (A5.3.11).
pub fn shifted_register(h1: u32, h2: u32) -> Instruction {
    let (s, rn, rd, rm) = (bit(h1, 4), reg(h1, 0), reg(h2, 8), reg(h2, 0));
    let shift = immediate_shift(bits(h2, 4, 2), bits(h2, 12, 3) << 2 | bits(h2, 6, 2));
    let op = bits(h1, 5, 4);
    if op == 0b0110 {
        if s || bit(h2, 4) {
            return Instruction::Undefined;
        }
        let top = bit(h2, 5);
        let forbidden = bad(rd) || bad(rn) || bad(rm) || bit(h2, 15);
        return unless(forbidden, Instruction::Pack { top, rd, rn, rm, shift });
    }
    let Some(op) = operation(op, s, rd, rn) else { return Instruction::Undefined };
    let forbidden = match op {
        // Plain MOV may read or write SP, but not both; no other form may.
        Alu::Mov if shift == Shift::NONE && !s => rd == 15 || rm == 15 || (rd == 13 && rm == 13),
        Alu::Add | Alu::Sub if rn == 13 && rd == 13 => {
            bad(rm) || shift.kind != ShiftKind::Lsl || shift.amount > 3
        }
        _ => is_unpredictable(op, rd, rn) || bad(rm),
    };
    unless(forbidden || bit(h2, 15), Instruction::AluRegister { op, s, rd, rn, rm, shift })
}

/// Data processing of registers: shifts, extensions, parallel arithmetic and others (A5.3.12).
pub fn register(h1: u32, h2: u32) -> Instruction {
    if bits(h2, 12, 4) != 0b1111 {
        return Instruction::Undefined;
    }
    let (op1, op2) = (bits(h1, 4, 4), bits(h2, 4, 4));
    match (op1, op2) {
        (0b0000..=0b0111, 0b0000) => {
            let (rn, rd, rm) = (reg(h1, 0), reg(h2, 8), reg(h2, 0));
            let kind = [ShiftKind::Lsl, ShiftKind::Lsr, ShiftKind::Asr, ShiftKind::Ror][(op1 >> 1) as usize];
            let shift = Instruction::ShiftRegister { kind, s: bit(h1, 4), rd, rn, rm };
            unless(bad(rd) || bad(rn) || bad(rm), shift)
        }
        (0b0000..=0b0101, 0b1000..=0b1111) => extend(op1, h1, h2),
        (0b1000..=0b1111, 0b0000..=0b0111) => parallel(h1, h2),
        (0b1000..=0b1011, 0b1000..=0b1011) => miscellaneous(h1, h2),
        _ => Instruction::Undefined,
    }
}

fn extend(op: u32, h1: u32, h2: u32) -> Instruction {
    let (rn, rd, rm) = (reg(h1, 0), reg(h2, 8), reg(h2, 0));
    let kind = match op {
        0b0000 => Extension::SignedHalf,
        0b0001 => Extension::Half,
        0b0010 => Extension::SignedBytes16,
        0b0011 => Extension::Bytes16,
        0b0100 => Extension::SignedByte,
        _ => Extension::Byte,
    };
    let rotation = (bits(h2, 4, 2) * 8) as u8;
    let forbidden = bad(rd) || rn == 13 || bad(rm) || bit(h2, 6);
    unless(forbidden, Instruction::Extend { kind, rd, rn, rm, rotation })
}

/// Parallel addition and subtraction (A5.3.13, A5.3.14).
fn parallel(h1: u32, h2: u32) -> Instruction {
    let (rn, rd, rm) = (reg(h1, 0), reg(h2, 8), reg(h2, 0));
    let lanes = match bits(h1, 4, 3) {
        0b001 => Lanes::Add16,
        0b010 => Lanes::Asx,
        0b110 => Lanes::Sax,
        0b101 => Lanes::Sub16,
        0b000 => Lanes::Add8,
        0b100 => Lanes::Sub8,
        _ => return Instruction::Undefined,
    };
    let treatment = match bits(h2, 4, 2) {
        0b00 => Treatment::Plain,
        0b01 => Treatment::Saturating,
        0b10 => Treatment::Halving,
        _ => return Instruction::Undefined,
    };
    let signed = !bit(h2, 6);
    unless(bad(rd) || bad(rn) || bad(rm), Instruction::Parallel { lanes, treatment, signed, rd, rn, rm })
}

/// Saturating words, reversals, SEL and CLZ (A5.3.15).
fn miscellaneous(h1: u32, h2: u32) -> Instruction {
    let (rn, rd, rm) = (reg(h1, 0), reg(h2, 8), reg(h2, 0));
    // Reversals name their operand twice.
    let reverse = |kind| unless(rn != rm, Instruction::Reverse { kind, rd, rm });
    let saturating = |op| Instruction::SaturatingAdd { op, rd, rn, rm };
    let instruction = match (bits(h1, 4, 2), bits(h2, 4, 2)) {
        (0b00, 0b00) => saturating(Saturating::Add),
        (0b00, 0b01) => saturating(Saturating::DoubleAdd),
        (0b00, 0b10) => saturating(Saturating::Sub),
        (0b00, _) => saturating(Saturating::DoubleSub),
        (0b01, 0b00) => reverse(Reverse::Bytes),
        (0b01, 0b01) => reverse(Reverse::BytesOfHalves),
        (0b01, 0b10) => reverse(Reverse::Bits),
        (0b01, _) => reverse(Reverse::SignedHalf),
        (0b10, 0b00) => Instruction::Select { rd, rn, rm },
        (0b11, 0b00) => reverse(Reverse::CountLeadingZeros),
        _ => return Instruction::Undefined,
    };
    unless(bad(rd) || bad(rn) || bad(rm), instruction)
}
