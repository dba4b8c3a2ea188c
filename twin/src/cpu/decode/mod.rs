//! Decoding (DDI 0403 chapter A5): half-words to [`Instruction`].
//!
//! Decoding is total. Every encoding is an instruction, [`Instruction::Undefined`] or [`Instruction::Unpredictable`]. An encoding whose
//! bits in parentheses differ from the manual is UNPREDICTABLE.

mod branch;
#[cfg(test)]
mod coverage;
mod dsp;
mod fpu;
mod immediate;
mod load_store;
mod multiply;
mod single;
mod thumb16;

use crate::cpu::instruction::{Decoded, Hint, Instruction, Reg, Shift, ShiftKind};

/// Returns whether the first half-word begins a 32-bit instruction (A5.1).
pub fn is_wide(first: u16) -> bool {
    first >= 0xE800
}

/// Decodes a 16-bit instruction.
pub fn narrow(half: u16) -> Decoded {
    Decoded { instruction: thumb16::decode(u32::from(half)), size: 2 }
}

/// Decodes a 32-bit instruction (A5.3).
pub fn wide(first: u16, second: u16) -> Decoded {
    let (h1, h2) = (u32::from(first), u32::from(second));
    let instruction = match (bits(h1, 11, 2), bits(h1, 4, 7)) {
        (0b01, op) if op & 0b110_0100 == 0 => load_store::multiple(h1, h2),
        (0b01, op) if op & 0b110_0100 == 0b100 => load_store::dual(h1, h2),
        (0b01, op) if op & 0b110_0000 == 0b010_0000 => dsp::shifted_register(h1, h2),
        (0b10, _) if bit(h2, 15) => branch::decode(h1, h2),
        (0b10, op) if op & 0b010_0000 == 0 => immediate::modified(h1, h2),
        (0b10, _) => immediate::plain(h1, h2),
        (0b11, op) if op & 0b110_0000 == 0 => single::decode(h1, h2),
        (0b11, op) if op & 0b111_0000 == 0b010_0000 => dsp::register(h1, h2),
        (0b11, op) if op & 0b111_1000 == 0b011_0000 => multiply::short(h1, h2),
        (0b11, op) if op & 0b111_1000 == 0b011_1000 => multiply::long(h1, h2),
        _ => fpu::coprocessor(h1, h2),
    };
    Decoded { instruction, size: 4 }
}

/// `count` bits of `value` from bit `low` on.
fn bits(value: u32, low: u32, count: u32) -> u32 {
    value >> low & ((1 << count) - 1)
}

fn bit(value: u32, at: u32) -> bool {
    value >> at & 1 == 1
}

/// Four bits as the number of a register.
fn reg(value: u32, low: u32) -> Reg {
    bits(value, low, 4) as Reg
}

/// SP or PC, which most operands must not be ("BadReg" in the manual).
fn bad(reg: Reg) -> bool {
    reg == 13 || reg == 15
}

/// The instruction, unless the manual calls the encoding UNPREDICTABLE.
fn unless(unpredictable: bool, instruction: Instruction) -> Instruction {
    if unpredictable { Instruction::Unpredictable } else { instruction }
}

/// A hint by its number. Those without a meaning are NOPs.
fn hint(number: u32) -> Instruction {
    let hint = match number {
        2 => Hint::WaitForEvent,
        3 => Hint::WaitForInterrupt,
        4 => Hint::SendEvent,
        _ => Hint::Nop,
    };
    Instruction::Hint { hint }
}

/// A shift by a constant as encoded in two bits of kind and five of amount (A7.4.2).
fn immediate_shift(kind: u32, amount: u32) -> Shift {
    let amount = amount as u8;
    match (kind, amount) {
        (0, _) => Shift { kind: ShiftKind::Lsl, amount },
        (1, 0) => Shift { kind: ShiftKind::Lsr, amount: 32 },
        (1, _) => Shift { kind: ShiftKind::Lsr, amount },
        (2, 0) => Shift { kind: ShiftKind::Asr, amount: 32 },
        (2, _) => Shift { kind: ShiftKind::Asr, amount },
        (_, 0) => Shift { kind: ShiftKind::Rrx, amount: 1 },
        _ => Shift { kind: ShiftKind::Ror, amount },
    }
}

/// Extends the low `count` bits of `value` by their sign.
fn sign_extend(value: u32, count: u32) -> i32 {
    (value << (32 - count)) as i32 >> (32 - count)
}
