//! Shows that the vectors of Unicorn reach each kind of instruction that the decoder knows.
//!
//! A *kind* is a variant of [`Instruction`] with its operation, size, index and flags, and without registers and constants.

use std::collections::HashMap;
use std::mem::{Discriminant, discriminant};

use super::{narrow, wide};
use crate::cpu::instruction::{Block, FpConvert, Hint, Instruction as I};

const VECTORS: &[u8] = include_bytes!("../../../tests/vectors/unicorn.bin");
/// Low four bits that make different kinds, of the first and of the second half-word: registers 0, 1 and 15, hints, bits that have to be
/// ones.
const NIBBLES: [&[u16]; 2] = [&[0, 1, 15], &[0, 1, 2, 3, 4, 15]];
/// First half-words whose low four bits are part of the operation: those of the FPU.
const FPU: std::ops::Range<u16> = 0xEC00..0xF000;
/// First half-words whose second one names a special register with its low four bits.
const SPECIAL: std::ops::Range<u16> = 0xF380..0xF400;

/// The variant, and what else makes the kind.
type Kind = (Discriminant<I>, [u8; 3]);

/// Returns the kind of an instruction. Parts that a variant does not need are zero.
fn kind(instruction: I) -> Kind {
    let parts = match instruction {
        I::AluImmediate { op, s, rotated, .. } => [op as u8, s as u8, rotated as u8],
        I::AluRegister { op, s, shift, .. } => [op as u8, s as u8, shift.kind as u8],
        I::ShiftRegister { kind, s, .. } => [kind as u8, s as u8, 0],
        I::Adr { offset, .. } => [(offset < 0) as u8, 0, 0],
        I::BitFieldExtract { signed, .. } => [signed as u8, 0, 0],
        I::Saturate { signed, shift, .. } => [signed as u8, shift.kind as u8, 0],
        I::Saturate16 { signed, .. } => [signed as u8, 0, 0],
        I::Extend { kind, rn, rotation, .. } => [kind as u8, (rn == 15) as u8, rotation],
        I::Reverse { kind, .. } => [kind as u8, 0, 0],
        I::Parallel { lanes, treatment, signed, .. } => [lanes as u8, treatment as u8, signed as u8],
        I::SaturatingAdd { op, .. } => [op as u8, 0, 0],
        I::Pack { top, .. } => [top as u8, 0, 0],
        I::AbsoluteDifferences { ra, .. } => [(ra == 15) as u8, 0, 0],
        I::Multiply { s, .. } => [s as u8, 0, 0],
        I::MultiplyAccumulate { subtract, .. } => [subtract as u8, 0, 0],
        I::MultiplyLong { op, .. } => [op as u8, 0, 0],
        I::Divide { signed, .. } => [signed as u8, 0, 0],
        I::MultiplyHalves { ra, n_top, m_top, .. } => [(ra == 15) as u8, n_top as u8, m_top as u8],
        I::MultiplyWordHalf { ra, m_top, .. } => [(ra == 15) as u8, m_top as u8, 0],
        I::MultiplyDual { subtract, exchange, ra, .. } => [subtract as u8, exchange as u8, (ra == 15) as u8],
        I::MultiplyHigh { subtract, round, ra, .. } => [subtract as u8, round as u8, (ra == 15) as u8],
        I::MultiplyHalvesLong { n_top, m_top, .. } => [n_top as u8, m_top as u8, 0],
        I::MultiplyDualLong { subtract, exchange, .. } => [subtract as u8, exchange as u8, 0],
        I::Load { size, rt, at } => [size as u8, at.index as u8, (rt == 15) as u8],
        I::LoadRegister { size, rt, .. } => [size as u8, (rt == 15) as u8, 0],
        I::LoadLiteral { size, rt, .. } => [size as u8, (rt == 15) as u8, 0],
        I::Store { size, at, .. } => [size as u8, at.index as u8, 0],
        I::StoreRegister { size, .. } => [size as u8, 0, 0],
        I::Dual { load, at, .. } => [load as u8, at.index as u8, (at.rn == 15) as u8],
        I::Multiple { load, block: Block { list, decrement, writeback, .. } } => {
            [if load { 1 + (list >> 15) as u8 } else { 0 }, decrement as u8, writeback as u8]
        }
        I::LoadExclusive { size, .. } => [size as u8, 0, 0],
        I::StoreExclusive { size, .. } => [size as u8, 0, 0],
        I::BranchIf { condition, .. } => [condition.0, 0, 0],
        I::CompareBranch { non_zero, .. } => [non_zero as u8, 0, 0],
        I::TableBranch { half, .. } => [half as u8, 0, 0],
        I::IfThen { state } => [state >> 4, state.trailing_zeros() as u8, 0],
        I::Hint { hint } => [hint as u8, 0, 0],
        I::ChangeState { disable, primask, faultmask } => [disable as u8, primask as u8, faultmask as u8],
        I::MoveFromSpecial { register, .. } => [register, 0, 0],
        I::MoveToSpecial { register, mask, .. } => [register, mask, 0],
        I::FpBinary { op, .. } => [op as u8, 0, 0],
        I::FpAccumulate { fused, negate_addend, negate_product, .. } => {
            [fused as u8, negate_addend as u8, negate_product as u8]
        }
        I::FpUnary { op, .. } => [op as u8, 0, 0],
        I::FpCompare { quiet_raises, zero, .. } => [quiet_raises as u8, zero as u8, 0],
        I::FpConvert { op, .. } => match op {
            FpConvert::FromInteger { signed } => [0, signed as u8, 0],
            FpConvert::ToInteger { signed, to_zero } => [1, signed as u8, to_zero as u8],
            FpConvert::FromFixed { signed, word, .. } => [2, signed as u8, word as u8],
            FpConvert::ToFixed { signed, word, .. } => [3, signed as u8, word as u8],
            FpConvert::FromHalf { top } => [4, top as u8, 0],
            FpConvert::ToHalf { top } => [5, top as u8, 0],
        },
        I::FpMoveCore { to_core, .. } => [to_core as u8, 0, 0],
        I::FpMovePair { to_core, .. } => [to_core as u8, 0, 0],
        I::FpStatusRead { rt } => [(rt == 15) as u8, 0, 0],
        I::FpTransfer { load, count, rn, .. } => [load as u8, count, (rn == 15) as u8],
        I::FpMultiple { load, decrement, writeback, .. } => [load as u8, decrement as u8, writeback as u8],
        _ => [0; 3],
    };
    (discriminant(&instruction), parts)
}

/// Returns the reason for which Unicorn does not judge the kind of an instruction, and the place of its tests.
fn reason(instruction: I) -> Option<&'static str> {
    Some(match instruction {
        I::Undefined | I::NoCoprocessor | I::FpUndefined => "a UsageFault: tests/faults.rs, tests/fpu.rs",
        I::Unpredictable => "a stop: tests/totality.rs",
        I::SupervisorCall => "an exception: tests/exceptions.rs",
        I::Breakpoint { .. } => "a stop or an exception: tests/faults.rs",
        I::Hint { hint } if hint != Hint::Nop => "sleep and event register: tests/exceptions.rs",
        I::ChangeState { .. } => "masks: tests/exceptions.rs, tests/special.rs",
        I::MoveFromSpecial { register: 4.., .. } | I::MoveToSpecial { register: 4.., .. } => {
            "masks and stack pointers: tests/special.rs"
        }
        _ => return None,
    })
}

/// All kinds that the decoder answers with, each with one instruction.
fn known() -> HashMap<Kind, I> {
    let mut known = HashMap::new();
    let mut last = None;
    let mut add = |instruction: I| {
        let kind = kind(instruction);
        if last != Some(kind) {
            last = Some(kind);
            known.entry(kind).or_insert(instruction);
        }
    };
    for half in 0..0xE800 {
        add(narrow(half).instruction);
    }
    let [firsts, seconds] = NIBBLES;
    for first in (0xE800..=0xFFFF).filter(|first| FPU.contains(first) || firsts.contains(&(first & 0xF))) {
        let all = SPECIAL.contains(&first);
        for second in (0..=0xFFFF).filter(|second| all || seconds.contains(&(second & 0xF))) {
            add(wide(first, second).instruction);
        }
    }
    known
}

/// Reads the parts of the file of vectors that a count of instructions needs.
struct Reader(&'static [u8]);

impl Reader {
    fn take(&mut self, count: usize) -> &'static [u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn number(&mut self, bytes: usize) -> usize {
        self.take(bytes).iter().rev().fold(0, |number, &byte| number << 8 | usize::from(byte))
    }

    /// Returns the half-words of the next vector.
    fn code(&mut self) -> Vec<u16> {
        let halves = self.number(1);
        self.take(4);
        let code =
            self.take(2 * halves).chunks(2).map(|half| u16::from_le_bytes([half[0], half[1]])).collect();
        // Registers, flags, FPU and memory afterwards.
        for mask_bytes in [2, 4] {
            let changed = self.number(mask_bytes).count_ones() as usize;
            self.take(4 * changed);
        }
        self.take(12);
        for _ in 0..self.number(1) {
            self.take(2);
            let length = self.number(1);
            self.take(length);
        }
        code
    }
}

/// Kinds in the vectors, and the number of instructions of each.
fn judged() -> HashMap<Kind, usize> {
    let mut reader = Reader(VECTORS);
    let vectors = reader.number(4);
    reader.take(8);
    let mut judged = HashMap::new();
    for _ in 0..vectors {
        let code = reader.code();
        let mut halves = code.as_slice();
        while let [first, rest @ ..] = halves {
            let decoded = if super::is_wide(*first) { wide(*first, rest[0]) } else { narrow(*first) };
            *judged.entry(kind(decoded.instruction)).or_default() += 1;
            halves = &halves[usize::from(decoded.size) / 2..];
        }
    }
    assert!(reader.0.is_empty());
    judged
}

/// Given the committed vectors. When their instructions are decoded. Then each kind is among them, but those that Unicorn cannot judge.
#[test]
fn vectors_reach_each_kind_of_instruction() {
    let (known, judged) = (known(), judged());
    assert!(judged.keys().all(|kind| known.contains_key(kind)), "the scan of encodings finds all kinds");
    let (mut missing, mut excused) = (Vec::new(), 0);
    for (kind, example) in &known {
        match (judged.get(kind), reason(*example)) {
            (Some(_), None) => {}
            (None, Some(_)) => excused += 1,
            (None, None) => missing.push(format!("{example:?}")),
            (Some(count), Some(reason)) => {
                panic!("{example:?} is in {count} vectors, and is left out because of {reason}")
            }
        }
    }
    let instructions: usize = judged.values().sum();
    let least = judged.values().min().unwrap_or(&0);
    println!(
        "{} kinds, {} in the vectors ({instructions} instructions, at least {least} of each), {excused} left out",
        known.len(),
        judged.len()
    );
    assert!(missing.is_empty(), "in no vector:\n{}", missing.join("\n"));
}
