//! 16-bit instructions (A5.2).

use super::{bit, bits, immediate_shift, reg, sign_extend, unless};
use crate::cpu::instruction::{
    Alu, Block, Condition, Extension, Index, Indexed, Instruction, Reg, Reverse, Shift, ShiftKind, Size,
};

const SP: Reg = 13;
const PC: Reg = 15;

pub fn decode(h: u32) -> Instruction {
    match bits(h, 11, 5) {
        0b00000..=0b00010 => shift(h),
        0b00011 => add_subtract(h),
        0b00100..=0b00111 => immediate(h),
        0b01000 if bit(h, 10) => high_registers(h),
        0b01000 => data_processing(h),
        0b01001 => {
            Instruction::LoadLiteral { size: Size::Word, rt: low(h, 8), offset: (bits(h, 0, 8) * 4) as i16 }
        }
        0b01010 | 0b01011 => register_offset(h),
        0b01100..=0b10001 => immediate_offset(h),
        0b10010 | 0b10011 => transfer(bit(h, 11), Size::Word, low(h, 8), SP, bits(h, 0, 8) * 4),
        0b10100 => Instruction::Adr { rd: low(h, 8), offset: (bits(h, 0, 8) * 4) as i16 },
        0b10101 => alu_immediate(Alu::Add, false, low(h, 8), SP, bits(h, 0, 8) * 4),
        0b10110 | 0b10111 => miscellaneous(h),
        0b11000 | 0b11001 => multiple(h),
        0b11010 | 0b11011 => conditional(h),
        // 0b11100; the rest begin a 32-bit instruction.
        _ => Instruction::Branch { offset: sign_extend(bits(h, 0, 11) << 1, 12) },
    }
}

fn low(h: u32, at: u32) -> Reg {
    bits(h, at, 3) as Reg
}

fn alu_immediate(op: Alu, s: bool, rd: Reg, rn: Reg, imm: u32) -> Instruction {
    Instruction::AluImmediate { op, s, rotated: false, rd, rn, imm }
}

fn alu_register(op: Alu, s: bool, rd: Reg, rn: Reg, rm: Reg) -> Instruction {
    Instruction::AluRegister { op, s, rd, rn, rm, shift: Shift::NONE }
}

fn transfer(load: bool, size: Size, rt: Reg, rn: Reg, offset: u32) -> Instruction {
    let at = Indexed { index: Index::Offset, rn, offset: offset as i16 };
    if load { Instruction::Load { size, rt, at } } else { Instruction::Store { size, rt, at } }
}

/// Shift by a constant; LSL by 0 is MOVS (A5.2.1).
fn shift(h: u32) -> Instruction {
    let shift = immediate_shift(bits(h, 11, 2), bits(h, 6, 5));
    Instruction::AluRegister { op: Alu::Mov, s: true, rd: low(h, 0), rn: 0, rm: low(h, 3), shift }
}

fn add_subtract(h: u32) -> Instruction {
    let op = if bit(h, 9) { Alu::Sub } else { Alu::Add };
    if bit(h, 10) {
        alu_immediate(op, true, low(h, 0), low(h, 3), bits(h, 6, 3))
    } else {
        alu_register(op, true, low(h, 0), low(h, 3), low(h, 6))
    }
}

fn immediate(h: u32) -> Instruction {
    let (rd, imm) = (low(h, 8), bits(h, 0, 8));
    let op = [Alu::Mov, Alu::Cmp, Alu::Add, Alu::Sub][bits(h, 11, 2) as usize];
    alu_immediate(op, true, rd, rd, imm)
}

/// Two low registers (A5.2.2).
fn data_processing(h: u32) -> Instruction {
    let (rd, rm) = (low(h, 0), low(h, 3));
    let alu = |op| alu_register(op, true, rd, rd, rm);
    let shift = |kind| Instruction::ShiftRegister { kind, s: true, rd, rn: rd, rm };
    match bits(h, 6, 4) {
        0b0000 => alu(Alu::And),
        0b0001 => alu(Alu::Eor),
        0b0010 => shift(ShiftKind::Lsl),
        0b0011 => shift(ShiftKind::Lsr),
        0b0100 => shift(ShiftKind::Asr),
        0b0101 => alu(Alu::Adc),
        0b0110 => alu(Alu::Sbc),
        0b0111 => shift(ShiftKind::Ror),
        0b1000 => alu(Alu::Tst),
        0b1001 => alu_immediate(Alu::Rsb, true, rd, rm, 0),
        0b1010 => alu(Alu::Cmp),
        0b1011 => alu(Alu::Cmn),
        0b1100 => alu(Alu::Orr),
        0b1101 => Instruction::Multiply { s: true, rd, rn: rd, rm },
        0b1110 => alu(Alu::Bic),
        _ => alu(Alu::Mvn),
    }
}

/// Any registers, and branches to one (A5.2.3).
fn high_registers(h: u32) -> Instruction {
    let rm = reg(h, 3);
    let rd = (bits(h, 7, 1) << 3 | bits(h, 0, 3)) as Reg;
    match (bits(h, 8, 2), rd) {
        (0b00, PC) => unless(rm == PC, Instruction::AddPc { rm }),
        (0b00, _) => alu_register(Alu::Add, false, rd, rd, rm),
        (0b01, rn) => {
            unless(rn == PC || rm == PC || (rn < 8 && rm < 8), alu_register(Alu::Cmp, true, rn, rn, rm))
        }
        (0b10, PC) => Instruction::MovPc { rm },
        (0b10, _) => alu_register(Alu::Mov, false, rd, 0, rm),
        _ if bits(h, 0, 3) != 0 => Instruction::Unpredictable,
        _ if bit(h, 7) => unless(rm == PC, Instruction::BranchLinkExchange { rm }),
        _ => Instruction::BranchExchange { rm },
    }
}

fn register_offset(h: u32) -> Instruction {
    let (rt, rn, rm, shift) = (low(h, 0), low(h, 3), low(h, 6), 0);
    let load = |size| Instruction::LoadRegister { size, rt, rn, rm, shift };
    let store = |size| Instruction::StoreRegister { size, rt, rn, rm, shift };
    match bits(h, 9, 3) {
        0b000 => store(Size::Word),
        0b001 => store(Size::Half),
        0b010 => store(Size::Byte),
        0b011 => load(Size::SignedByte),
        0b100 => load(Size::Word),
        0b101 => load(Size::Half),
        0b110 => load(Size::Byte),
        _ => load(Size::SignedHalf),
    }
}

fn immediate_offset(h: u32) -> Instruction {
    let (size, scale) = match bits(h, 12, 4) {
        0b0110 => (Size::Word, 4),
        0b0111 => (Size::Byte, 1),
        _ => (Size::Half, 2),
    };
    transfer(bit(h, 11), size, low(h, 0), low(h, 3), bits(h, 6, 5) * scale)
}

/// A5.2.5.
fn miscellaneous(h: u32) -> Instruction {
    let (rd, rm) = (low(h, 0), low(h, 3));
    let extend = |kind| Instruction::Extend { kind, rd, rn: PC, rm, rotation: 0 };
    let reverse = |kind| Instruction::Reverse { kind, rd, rm };
    match bits(h, 5, 7) {
        0b000_0000..=0b000_0011 => alu_immediate(Alu::Add, false, SP, SP, bits(h, 0, 7) * 4),
        0b000_0100..=0b000_0111 => alu_immediate(Alu::Sub, false, SP, SP, bits(h, 0, 7) * 4),
        0b001_0000 | 0b001_0001 => extend(Extension::SignedHalf),
        0b001_0010 | 0b001_0011 => extend(Extension::SignedByte),
        0b001_0100 | 0b001_0101 => extend(Extension::Half),
        0b001_0110 | 0b001_0111 => extend(Extension::Byte),
        op if op & 0b010_1000 == 0b000_1000 => Instruction::CompareBranch {
            rn: rd,
            non_zero: bit(h, 11),
            offset: (bits(h, 9, 1) << 6 | bits(h, 3, 5) << 1) as u8,
        },
        0b010_0000..=0b010_1111 => push(h),
        0b011_0011 => {
            let (primask, faultmask) = (bit(h, 1), bit(h, 0));
            unless(
                bits(h, 2, 2) != 0 || !(primask || faultmask),
                Instruction::ChangeState { disable: bit(h, 4), primask, faultmask },
            )
        }
        0b101_0000 | 0b101_0001 => reverse(Reverse::Bytes),
        0b101_0010 | 0b101_0011 => reverse(Reverse::BytesOfHalves),
        0b101_0110 | 0b101_0111 => reverse(Reverse::SignedHalf),
        0b110_0000..=0b110_1111 => pop(h),
        0b111_0000..=0b111_0111 => Instruction::Breakpoint { immediate: bits(h, 0, 8) as u8 },
        0b111_1000..=0b111_1111 => if_then_or_hint(h),
        _ => Instruction::Undefined,
    }
}

fn push(h: u32) -> Instruction {
    let list = (bits(h, 0, 8) | bits(h, 8, 1) << 14) as u16;
    let block = Block { rn: SP, list, decrement: true, writeback: true };
    unless(list == 0, Instruction::Multiple { load: false, block })
}

fn pop(h: u32) -> Instruction {
    let list = (bits(h, 0, 8) | bits(h, 8, 1) << 15) as u16;
    let block = Block { rn: SP, list, decrement: false, writeback: true };
    unless(list == 0, Instruction::Multiple { load: true, block })
}

/// IT and hints (A5.2.5).
fn if_then_or_hint(h: u32) -> Instruction {
    let (condition, mask) = (bits(h, 4, 4), bits(h, 0, 4));
    if mask != 0 {
        let always = condition == 14 && mask.count_ones() != 1;
        return unless(condition == 15 || always, Instruction::IfThen { state: bits(h, 0, 8) as u8 });
    }
    super::hint(condition)
}

fn multiple(h: u32) -> Instruction {
    let (load, rn, list) = (bit(h, 11), low(h, 8), bits(h, 0, 8) as u16);
    let block = Block { rn, list, decrement: false, writeback: !load || list >> rn & 1 == 0 };
    unless(list == 0, Instruction::Multiple { load, block })
}

fn conditional(h: u32) -> Instruction {
    match bits(h, 8, 4) {
        14 => Instruction::Undefined,
        15 => Instruction::SupervisorCall,
        condition => Instruction::BranchIf {
            condition: Condition(condition as u8),
            offset: sign_extend(bits(h, 0, 8) << 1, 9),
        },
    }
}
