//! Multiple, dual and exclusive loads and stores, and table branches (A5.3.5, A5.3.6).

use super::{bad, bit, bits, reg, unless};
use crate::cpu::instruction::{Block, Index, Indexed, Instruction, Size};

const PC: u8 = 15;

/// Load and store multiple (A5.3.5).
pub fn multiple(h1: u32, h2: u32) -> Instruction {
    let (rn, list, writeback, load) = (reg(h1, 0), h2 as u16, bit(h1, 5), bit(h1, 4));
    let decrement = match bits(h1, 7, 2) {
        0b01 => false,
        0b10 => true,
        _ => return Instruction::Undefined,
    };
    let in_list = |reg: u8| list >> reg & 1 == 1;
    let forbidden = rn == PC || list.count_ones() < 2 || in_list(13) || (writeback && in_list(rn));
    // PC is stored never, and loaded without LR.
    let forbidden_pc = in_list(15) && (!load || in_list(14));
    unless(
        forbidden || forbidden_pc,
        Instruction::Multiple { load, block: Block { rn, list, decrement, writeback } },
    )
}

/// Dual and exclusive loads and stores, table branches (A5.3.6).
pub fn dual(h1: u32, h2: u32) -> Instruction {
    let (p, u, w, load) = (bit(h1, 8), bit(h1, 7), bit(h1, 5), bit(h1, 4));
    if !p && !w {
        return exclusive(h1, h2);
    }
    let (rn, rt, rt2) = (reg(h1, 0), reg(h2, 12), reg(h2, 8));
    let magnitude = (bits(h2, 0, 8) * 4) as i16;
    let offset = if u { magnitude } else { -magnitude };
    let index = match (p, w) {
        (true, false) => Index::Offset,
        (true, true) => Index::Pre,
        _ => Index::Post,
    };
    let forbidden = bad(rt)
        || bad(rt2)
        || (w && (rn == rt || rn == rt2))
        || (load && rt == rt2)
        || (rn == PC && (w || !load));
    unless(forbidden, Instruction::Dual { load, rt, rt2, at: Indexed { index, rn, offset } })
}

/// The encodings of [`dual`] without index and write-back.
fn exclusive(h1: u32, h2: u32) -> Instruction {
    let (rn, rt) = (reg(h1, 0), reg(h2, 12));
    let load = bit(h1, 4);
    let ones = |low| bits(h2, low, 4) == 0b1111;
    if !bit(h1, 7) {
        let offset = (bits(h2, 0, 8) * 4) as u16;
        let rd = reg(h2, 8);
        return if load {
            let instruction = Instruction::LoadExclusive { size: Size::Word, rt, rn, offset };
            unless(bad(rt) || rn == PC || !ones(8), instruction)
        } else {
            let forbidden = bad(rd) || bad(rt) || rn == PC || rd == rn || rd == rt;
            unless(forbidden, Instruction::StoreExclusive { size: Size::Word, rd, rt, rn, offset })
        };
    }
    let size = if bit(h2, 4) { Size::Half } else { Size::Byte };
    let offset = 0;
    match (load, bits(h2, 4, 4)) {
        (true, 0b0000 | 0b0001) => {
            let rm = reg(h2, 0);
            let forbidden = rn == 13 || bad(rm) || !ones(12) || bits(h2, 8, 4) != 0;
            unless(forbidden, Instruction::TableBranch { half: bit(h2, 4), rn, rm })
        }
        (true, 0b0100 | 0b0101) => {
            let forbidden = bad(rt) || rn == PC || !ones(8) || !ones(0);
            unless(forbidden, Instruction::LoadExclusive { size, rt, rn, offset })
        }
        (false, 0b0100 | 0b0101) => {
            let rd = reg(h2, 0);
            let forbidden = bad(rd) || bad(rt) || rn == PC || rd == rn || rd == rt || !ones(8);
            unless(forbidden, Instruction::StoreExclusive { size, rd, rt, rn, offset })
        }
        _ => Instruction::Undefined,
    }
}
