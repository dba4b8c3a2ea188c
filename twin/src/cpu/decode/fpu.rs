//! Coprocessor space and FPv4-SP (A5.3.18, A6.4 to A6.7).

use super::{bad, bit, bits, reg, unless};
use crate::cpu::instruction::{FpBinary, FpConvert, FpUnary, Instruction, Reg};

const PC: Reg = 15;

/// Instructions of all coprocessors; 10 and 11 are the FPU.
pub fn coprocessor(h1: u32, h2: u32) -> Instruction {
    let op1 = bits(h1, 4, 6);
    if op1 & 0b11_0000 == 0b11_0000 || op1 <= 1 {
        return Instruction::Undefined;
    }
    if bits(h2, 9, 3) != 0b101 {
        return Instruction::NoCoprocessor;
    }
    let double = bit(h2, 8);
    match op1 {
        _ if bit(h1, 12) => Instruction::FpUndefined,
        0b00_0100 | 0b00_0101 => move_pair(h1, h2, double),
        0b00_0000..=0b01_1111 => load_store(h1, h2, double),
        _ if bit(h2, 4) => transfer(h1, h2, double),
        _ if double => Instruction::FpUndefined,
        _ => data_processing(h1, h2),
    }
}

/// Number of a single register: four bits and the lowest one.
fn single(value: u32, low: u32, last: bool) -> Reg {
    reg(value, low) << 1 | u8::from(last)
}

fn data_processing(h1: u32, h2: u32) -> Instruction {
    let (d, n, m) = (single(h2, 12, bit(h1, 6)), single(h1, 0, bit(h2, 7)), single(h2, 0, bit(h2, 5)));
    let binary = |op| Instruction::FpBinary { op, d, n, m };
    let (fused, negate_product) = (bit(h1, 7), bit(h2, 6));
    let accumulate =
        |negate_addend| Instruction::FpAccumulate { fused, negate_addend, negate_product, d, n, m };
    match (fused, bits(h1, 4, 2), negate_product) {
        (false, 0b00, _) => accumulate(false),
        (_, 0b01, _) => accumulate(true),
        (false, 0b10, false) => binary(FpBinary::Mul),
        (false, 0b10, true) => binary(FpBinary::NegMul),
        (false, _, false) => binary(FpBinary::Add),
        (false, _, true) => binary(FpBinary::Sub),
        (true, 0b00, false) => binary(FpBinary::Div),
        (true, 0b00, true) => Instruction::FpUndefined,
        (true, 0b10, _) => accumulate(false),
        (true, _, false) => {
            let value = expand(bits(h1, 0, 4) << 4 | bits(h2, 0, 4));
            unless(bit(h2, 7) || bit(h2, 5), Instruction::FpImmediate { d, value })
        }
        (true, _, true) => one_operand(h1, h2, d, m),
    }
}

/// Constant of 8 bits (A6.4.1).
fn expand(imm8: u32) -> u32 {
    let exponent = if bit(imm8, 6) { 0x7C } else { 0x80 };
    bits(imm8, 7, 1) << 31 | (exponent | bits(imm8, 4, 2)) << 23 | bits(imm8, 0, 4) << 19
}

/// The encodings with `opc1` 1x11 and `opc3` x1 (A6.5).
fn one_operand(h1: u32, h2: u32, d: Reg, m: Reg) -> Instruction {
    let top = bit(h2, 7);
    let unary = |op| Instruction::FpUnary { op, d, m };
    let convert = |op| Instruction::FpConvert { op, d, m };
    let opc2 = bits(h1, 0, 4);
    match (opc2, top) {
        (0b0000, false) => unary(FpUnary::Mov),
        (0b0000, true) => unary(FpUnary::Abs),
        (0b0001, false) => unary(FpUnary::Neg),
        (0b0001, true) => unary(FpUnary::Sqrt),
        (0b0010, _) => convert(FpConvert::FromHalf { top }),
        (0b0011, _) => convert(FpConvert::ToHalf { top }),
        (0b0100, _) => Instruction::FpCompare { quiet_raises: top, zero: false, d, m },
        (0b0101, _) => unless(m != 0, Instruction::FpCompare { quiet_raises: top, zero: true, d, m: 0 }),
        (0b1000, _) => convert(FpConvert::FromInteger { signed: top }),
        (0b1100 | 0b1101, _) => convert(FpConvert::ToInteger { signed: opc2 == 0b1101, to_zero: top }),
        (0b1010 | 0b1011 | 0b1110 | 0b1111, word) => {
            let (size, imm5) = (if word { 32 } else { 16 }, reg(h2, 0) << 1 | u8::from(bit(h2, 5)));
            let signed = !bit(h1, 0);
            let fraction = size - imm5.min(size);
            let op = match bit(h1, 2) {
                true => FpConvert::ToFixed { signed, word, fraction },
                false => FpConvert::FromFixed { signed, word, fraction },
            };
            unless(imm5 > size, Instruction::FpConvert { op, d, m: d })
        }
        _ => Instruction::FpUndefined,
    }
}

/// VLDR, VSTR, VLDM, VSTM (A6.5).
fn load_store(h1: u32, h2: u32, double: bool) -> Instruction {
    let (p, u, w, load) = (bit(h1, 8), bit(h1, 7), bit(h1, 5), bit(h1, 4));
    let (rn, imm8) = (reg(h1, 0), bits(h2, 0, 8));
    let high = bit(h1, 6);
    if double && high {
        // There is no D16.
        return Instruction::FpUndefined;
    }
    let d = if double { reg(h2, 12) * 2 } else { single(h2, 12, high) };
    if p && !w {
        let magnitude = (imm8 * 4) as i16;
        let offset = if u { magnitude } else { -magnitude };
        let count = if double { 2 } else { 1 };
        return unless(!load && rn == PC, Instruction::FpTransfer { load, d, count, rn, offset });
    }
    let (decrement, writeback) = match (p, u, w) {
        (false, true, _) => (false, w),
        (true, false, true) => (true, true),
        _ => return Instruction::FpUndefined,
    };
    let forbidden = rn == PC || imm8 == 0 || (double && imm8 % 2 == 1) || u32::from(d) + imm8 > 32;
    let count = imm8 as u8;
    unless(forbidden, Instruction::FpMultiple { load, d, count, rn, decrement, writeback })
}

/// Transfers of 64 bits (A6.7).
fn move_pair(h1: u32, h2: u32, double: bool) -> Instruction {
    if bits(h2, 6, 2) != 0 || !bit(h2, 4) || (double && bit(h2, 5)) {
        return Instruction::FpUndefined;
    }
    let (rt, rt2, to_core) = (reg(h2, 12), reg(h1, 0), bit(h1, 4));
    let m = if double { reg(h2, 0) * 2 } else { single(h2, 0, bit(h2, 5)) };
    let forbidden = bad(rt) || bad(rt2) || m == 31 || (to_core && rt == rt2);
    unless(forbidden, Instruction::FpMovePair { to_core, rt, rt2, m })
}

/// Transfers of 32 bits (A6.6).
fn transfer(h1: u32, h2: u32, double: bool) -> Instruction {
    let (to_core, rt) = (bit(h1, 4), reg(h2, 12));
    let zeros = bits(h2, 0, 4) == 0;
    match (bits(h1, 5, 3), double) {
        (0b000, false) => {
            let n = single(h1, 0, bit(h2, 7));
            let forbidden = bad(rt) || !zeros || bits(h2, 5, 2) != 0;
            unless(forbidden, Instruction::FpMoveCore { to_core, rt, n })
        }
        (0b111, false) => {
            let forbidden = bits(h1, 0, 4) != 1 || bits(h2, 5, 3) != 0 || !zeros || rt == 13;
            if to_core {
                unless(forbidden, Instruction::FpStatusRead { rt })
            } else {
                unless(forbidden || rt == PC, Instruction::FpStatusWrite { rt })
            }
        }
        // One half of a double register.
        (half @ (0b000 | 0b001), true) if bits(h2, 5, 2) == 0 && !bit(h2, 7) => {
            let n = reg(h1, 0) * 2 + half as u8;
            unless(bad(rt) || !zeros, Instruction::FpMoveCore { to_core, rt, n })
        }
        _ => Instruction::FpUndefined,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_expand_as_in_table_a6_2() {
        assert_eq!(expand(0x70), 1.0_f32.to_bits());
        assert_eq!(expand(0x08), 3.0_f32.to_bits());
        assert_eq!(expand(0xF8), (-1.5_f32).to_bits());
        assert_eq!(expand(0x3F), 31.0_f32.to_bits());
        assert_eq!(expand(0x40), 0.125_f32.to_bits());
    }
}
