//! 32-bit branches and miscellaneous control (A5.3.4).

use super::{bad, bit, bits, reg, sign_extend, unless};
use crate::cpu::instruction::{Condition, Instruction};

pub fn decode(h1: u32, h2: u32) -> Instruction {
    match (bit(h2, 14), bit(h2, 12)) {
        (true, true) => Instruction::BranchLink { offset: long_offset(h1, h2) },
        (false, true) => Instruction::Branch { offset: long_offset(h1, h2) },
        (false, false) if bits(h1, 7, 3) != 0b111 => conditional(h1, h2),
        (false, false) => control(h1, h2),
        (true, false) => Instruction::Undefined,
    }
}

/// Offset of B (T4) and BL (A7.7.12, A7.7.18).
fn long_offset(h1: u32, h2: u32) -> i32 {
    let s = bits(h1, 10, 1);
    let i1 = !(bits(h2, 13, 1) ^ s) & 1;
    let i2 = !(bits(h2, 11, 1) ^ s) & 1;
    let imm = s << 24 | i1 << 23 | i2 << 22 | bits(h1, 0, 10) << 12 | bits(h2, 0, 11) << 1;
    sign_extend(imm, 25)
}

fn conditional(h1: u32, h2: u32) -> Instruction {
    let imm = bits(h1, 10, 1) << 20
        | bits(h2, 11, 1) << 19
        | bits(h2, 13, 1) << 18
        | bits(h1, 0, 6) << 12
        | bits(h2, 0, 11) << 1;
    Instruction::BranchIf { condition: Condition(bits(h1, 6, 4) as u8), offset: sign_extend(imm, 21) }
}

fn control(h1: u32, h2: u32) -> Instruction {
    if bit(h2, 13) {
        // A7.7.194 UDF, and encodings without a meaning.
        return Instruction::Undefined;
    }
    match bits(h1, 4, 7) {
        0b011_1000 | 0b011_1001 => move_to_special(h1, h2),
        0b011_1010 => hint(h1, h2),
        0b011_1011 => barrier(h1, h2),
        0b011_1110 | 0b011_1111 => {
            let (rd, register) = (reg(h2, 8), bits(h2, 0, 8) as u8);
            unless(
                bad(rd) || !is_special(register) || bits(h1, 0, 5) != 0b01111,
                Instruction::MoveFromSpecial { rd, register },
            )
        }
        _ => Instruction::Undefined,
    }
}

/// Numbers of special registers (B5.1.1).
fn is_special(register: u8) -> bool {
    matches!(register, 0..=3 | 5..=9 | 16..=20)
}

fn move_to_special(h1: u32, h2: u32) -> Instruction {
    let (rn, register, mask) = (reg(h1, 0), bits(h2, 0, 8) as u8, bits(h2, 10, 2) as u8);
    let forbidden = bad(rn)
        || mask == 0
        || (mask != 0b10 && register > 3)
        || !is_special(register)
        || bit(h1, 4)
        || bits(h2, 8, 2) != 0;
    unless(forbidden, Instruction::MoveToSpecial { rn, register, mask })
}

/// A5.3.4, "Hint instructions".
fn hint(h1: u32, h2: u32) -> Instruction {
    if bits(h2, 8, 3) != 0 {
        return Instruction::Undefined;
    }
    unless(bits(h1, 0, 4) != 0b1111 || bit(h2, 11), super::hint(bits(h2, 0, 8)))
}

/// A5.3.4, "Miscellaneous control instructions".
fn barrier(h1: u32, h2: u32) -> Instruction {
    let instruction = match bits(h2, 4, 4) {
        0b0010 if bits(h2, 0, 4) != 0b1111 => Instruction::Unpredictable,
        0b0010 => Instruction::ClearExclusive,
        0b0100..=0b0110 => Instruction::Barrier,
        _ => return Instruction::Undefined,
    };
    unless(bits(h1, 0, 4) != 0b1111 || bits(h2, 8, 4) != 0b1111, instruction)
}
