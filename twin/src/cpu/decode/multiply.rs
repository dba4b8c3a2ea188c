//! Multiplies and divides (A5.3.16, A5.3.17).

use super::{bad, bit, bits, reg, unless};
use crate::cpu::instruction::{Instruction, LongMultiply};

/// Results of 32 bits, and absolute differences (A5.3.16).
pub fn short(h1: u32, h2: u32) -> Instruction {
    let (rn, rd, rm, ra) = (reg(h1, 0), reg(h2, 8), reg(h2, 0), reg(h2, 12));
    if bits(h2, 6, 2) != 0 {
        return Instruction::Undefined;
    }
    let (n_top, m_top) = (bit(h2, 5), bit(h2, 4));
    // Bit 5 has to be zero if it selects no half of Rn.
    let instruction = match (bits(h1, 4, 3), n_top) {
        (0b000, false) if !m_top && ra == 15 => Instruction::Multiply { s: false, rd, rn, rm },
        (0b000, false) if m_top && ra == 15 => Instruction::Unpredictable,
        (0b000, false) => Instruction::MultiplyAccumulate { subtract: m_top, rd, rn, rm, ra },
        (0b001, _) => Instruction::MultiplyHalves { rd, rn, rm, ra, n_top, m_top },
        (0b010, false) => Instruction::MultiplyDual { subtract: false, exchange: m_top, rd, rn, rm, ra },
        (0b011, false) => Instruction::MultiplyWordHalf { rd, rn, rm, ra, m_top },
        (0b100, false) => Instruction::MultiplyDual { subtract: true, exchange: m_top, rd, rn, rm, ra },
        (0b101, false) => Instruction::MultiplyHigh { subtract: false, round: m_top, rd, rn, rm, ra },
        (0b110, false) if ra == 15 => Instruction::Unpredictable,
        (0b110, false) => Instruction::MultiplyHigh { subtract: true, round: m_top, rd, rn, rm, ra },
        (0b111, false) if !m_top => Instruction::AbsoluteDifferences { rd, rn, rm, ra },
        _ => return Instruction::Undefined,
    };
    unless(bad(rd) || bad(rn) || bad(rm) || ra == 13, instruction)
}

/// Results of 64 bits, and divides (A5.3.17).
pub fn long(h1: u32, h2: u32) -> Instruction {
    let (rn, low, high, rm) = (reg(h1, 0), reg(h2, 12), reg(h2, 8), reg(h2, 0));
    let (n_top, m_top) = (bit(h2, 5), bit(h2, 4));
    let multiply = |op| Instruction::MultiplyLong { op, low, high, rn, rm };
    let instruction = match (bits(h1, 4, 3), bits(h2, 4, 4)) {
        (0b000, 0b0000) => multiply(LongMultiply::Signed),
        (op @ (0b001 | 0b011), 0b1111) => {
            let divide = Instruction::Divide { signed: op == 0b001, rd: high, rn, rm };
            return unless(bad(high) || bad(rn) || bad(rm) || low != 15, divide);
        }
        (0b010, 0b0000) => multiply(LongMultiply::Unsigned),
        (0b100, 0b0000) => multiply(LongMultiply::SignedAccumulate),
        (0b100, 0b1000..=0b1011) => Instruction::MultiplyHalvesLong { low, high, rn, rm, n_top, m_top },
        (op @ (0b100 | 0b101), 0b1100 | 0b1101) => {
            Instruction::MultiplyDualLong { subtract: op == 0b101, exchange: m_top, low, high, rn, rm }
        }
        (0b110, 0b0000) => multiply(LongMultiply::UnsignedAccumulate),
        (0b110, 0b0110) => multiply(LongMultiply::UnsignedAccumulateBoth),
        _ => return Instruction::Undefined,
    };
    unless(bad(low) || bad(high) || low == high || bad(rn) || bad(rm), instruction)
}
