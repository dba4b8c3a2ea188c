//! 32-bit loads and stores of one register, and memory hints (A5.3.7 to A5.3.10).

use super::{bad, bit, bits, reg, unless};
use crate::cpu::instruction::{Hint, Index, Indexed, Instruction, Reg, Size};

const SP: Reg = 13;
const PC: Reg = 15;
/// Preloads and unallocated memory hints do nothing (A5.3.8, A5.3.9).
const MEMORY_HINT: Instruction = Instruction::Hint { hint: Hint::Nop };

pub fn decode(h1: u32, h2: u32) -> Instruction {
    let size = match (bits(h1, 5, 2), bit(h1, 8)) {
        (0b00, false) => Size::Byte,
        (0b00, true) => Size::SignedByte,
        (0b01, false) => Size::Half,
        (0b01, true) => Size::SignedHalf,
        (0b10, false) => Size::Word,
        _ => return Instruction::Undefined,
    };
    match bit(h1, 4) {
        true => load(size, h1, h2),
        // Bit 8 is the sign of a load.
        false if bit(h1, 8) => Instruction::Undefined,
        false => store(size, h1, h2),
    }
}

/// The address of a load or store.
enum Address {
    Immediate(Indexed),
    Register { rm: Reg, shift: u8 },
}

/// `None`: UNDEFINED.
fn address(h1: u32, h2: u32) -> Option<Address> {
    let rn = reg(h1, 0);
    if bit(h1, 7) {
        let offset = bits(h2, 0, 12) as i16;
        return Some(Address::Immediate(Indexed { index: Index::Offset, rn, offset }));
    }
    if !bit(h2, 11) {
        return (bits(h2, 6, 5) == 0)
            .then(|| Address::Register { rm: reg(h2, 0), shift: bits(h2, 4, 2) as u8 });
    }
    let magnitude = bits(h2, 0, 8) as i16;
    let offset = if bit(h2, 9) { magnitude } else { -magnitude };
    let index = match bits(h2, 8, 3) {
        0b110 => Index::Unprivileged,
        0b100 => Index::Offset,
        0b101 | 0b111 => Index::Pre,
        0b001 | 0b011 => Index::Post,
        _ => return None,
    };
    Some(Address::Immediate(Indexed { index, rn, offset }))
}

fn store(size: Size, h1: u32, h2: u32) -> Instruction {
    let (rn, rt) = (reg(h1, 0), reg(h2, 12));
    if rn == PC {
        return Instruction::Undefined;
    }
    let forbidden_rt = rt == PC || (rt == SP && size != Size::Word);
    match address(h1, h2) {
        None => Instruction::Undefined,
        Some(Address::Register { rm, shift }) => {
            unless(forbidden_rt || bad(rm), Instruction::StoreRegister { size, rt, rn, rm, shift })
        }
        Some(Address::Immediate(at)) => {
            let forbidden = forbidden_rt
                || (at.index == Index::Unprivileged && rt == SP)
                || (at.index.writes_base() && rn == rt);
            unless(forbidden, Instruction::Store { size, rt, at })
        }
    }
}

fn load(size: Size, h1: u32, h2: u32) -> Instruction {
    let (rn, rt) = (reg(h1, 0), reg(h2, 12));
    let is_word = size == Size::Word;
    // A load of less than a word to PC is a hint.
    let hint = rt == PC && !is_word;
    let forbidden_rt = rt == SP && !is_word;
    if rn == PC {
        let magnitude = bits(h2, 0, 12) as i16;
        let offset = if bit(h1, 7) { magnitude } else { -magnitude };
        let load = Instruction::LoadLiteral { size, rt, offset };
        return if hint { MEMORY_HINT } else { unless(forbidden_rt, load) };
    }
    match address(h1, h2) {
        None => Instruction::Undefined,
        Some(Address::Register { rm, .. }) if hint => unless(bad(rm), MEMORY_HINT),
        Some(Address::Register { rm, shift }) => {
            unless(forbidden_rt || bad(rm), Instruction::LoadRegister { size, rt, rn, rm, shift })
        }
        // Of the forms with 8 bits of offset the one that subtracts is a hint.
        Some(Address::Immediate(at)) if hint && at.index == Index::Offset => MEMORY_HINT,
        Some(Address::Immediate(at)) => {
            let forbidden = hint
                || forbidden_rt
                || (at.index == Index::Unprivileged && bad(rt))
                || (at.index.writes_base() && rn == rt);
            unless(forbidden, Instruction::Load { size, rt, at })
        }
    }
}
