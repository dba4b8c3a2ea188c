//! Shows that the vectors of Unicorn reach each kind of instruction that the decoder knows.
//!
//! A *kind* is a variant of [`Instruction`] with its operation, size, index and flags, and without registers and constants.

use std::collections::BTreeMap;

use super::{narrow, wide};
use crate::instruction::{FpConvert, Hint, Instruction as I};

const VECTORS: &[u8] = include_bytes!("../../tests/vectors/unicorn.bin");
/// Low four bits that make different kinds, of the first and of the second half-word: registers 0, 1 and 15, hints, bits that have to be
/// ones.
const NIBBLES: [&[u16]; 2] = [&[0, 1, 15], &[0, 1, 2, 3, 4, 15]];
/// First half-words whose low four bits are part of the operation: those of the FPU.
const FPU: std::ops::Range<u16> = 0xEC00..0xF000;
/// First half-words whose second one names a special register with its low four bits.
const SPECIAL: std::ops::Range<u16> = 0xF380..0xF400;

/// Name of the variant, and what else makes the kind.
type Kind = (&'static str, [u8; 3]);

/// Returns the kind of an instruction. Parts that a variant does not need are zero.
fn kind(instruction: I) -> Kind {
    macro_rules! parts {
        ($name:literal) => {
            ($name, [0, 0, 0])
        };
        ($name:literal, $first:expr) => {
            ($name, [$first as u8, 0, 0])
        };
        ($name:literal, $first:expr, $second:expr) => {
            ($name, [$first as u8, $second as u8, 0])
        };
        ($name:literal, $first:expr, $second:expr, $third:expr) => {
            ($name, [$first as u8, $second as u8, $third as u8])
        };
    }
    match instruction {
        I::Undefined => parts!("Undefined"),
        I::Unpredictable => parts!("Unpredictable"),
        I::NoCoprocessor => parts!("NoCoprocessor"),
        I::AluImmediate { op, s, rotated, .. } => parts!("AluImmediate", op, s, rotated),
        I::AluRegister { op, s, shift, .. } => parts!("AluRegister", op, s, shift.kind),
        I::ShiftRegister { kind, s, .. } => parts!("ShiftRegister", kind, s),
        I::MovPc { .. } => parts!("MovPc"),
        I::AddPc { .. } => parts!("AddPc"),
        I::Adr { offset, .. } => parts!("Adr", offset < 0),
        I::MovTop { .. } => parts!("MovTop"),
        I::BitFieldInsert { .. } => parts!("BitFieldInsert"),
        I::BitFieldClear { .. } => parts!("BitFieldClear"),
        I::BitFieldExtract { signed, .. } => parts!("BitFieldExtract", signed),
        I::Saturate { signed, shift, .. } => parts!("Saturate", signed, shift.kind),
        I::Saturate16 { signed, .. } => parts!("Saturate16", signed),
        I::Extend { kind, rn, rotation, .. } => parts!("Extend", kind, rn == 15, rotation),
        I::Reverse { kind, .. } => parts!("Reverse", kind),
        I::Parallel { lanes, treatment, signed, .. } => parts!("Parallel", lanes, treatment, signed),
        I::SaturatingAdd { op, .. } => parts!("SaturatingAdd", op),
        I::Select { .. } => parts!("Select"),
        I::Pack { top, .. } => parts!("Pack", top),
        I::AbsoluteDifferences { ra, .. } => parts!("AbsoluteDifferences", ra == 15),
        I::Multiply { s, .. } => parts!("Multiply", s),
        I::MultiplyAccumulate { subtract, .. } => parts!("MultiplyAccumulate", subtract),
        I::MultiplyLong { op, .. } => parts!("MultiplyLong", op),
        I::Divide { signed, .. } => parts!("Divide", signed),
        I::MultiplyHalves { ra, n_top, m_top, .. } => parts!("MultiplyHalves", ra == 15, n_top, m_top),
        I::MultiplyWordHalf { ra, m_top, .. } => parts!("MultiplyWordHalf", ra == 15, m_top),
        I::MultiplyDual { subtract, exchange, ra, .. } => {
            parts!("MultiplyDual", subtract, exchange, ra == 15)
        }
        I::MultiplyHigh { subtract, round, ra, .. } => parts!("MultiplyHigh", subtract, round, ra == 15),
        I::MultiplyHalvesLong { n_top, m_top, .. } => parts!("MultiplyHalvesLong", n_top, m_top),
        I::MultiplyDualLong { subtract, exchange, .. } => parts!("MultiplyDualLong", subtract, exchange),
        I::Load { size, rt, at } => parts!("Load", size, at.index, rt == 15),
        I::LoadRegister { size, rt, .. } => parts!("LoadRegister", size, rt == 15),
        I::LoadLiteral { size, rt, .. } => parts!("LoadLiteral", size, rt == 15),
        I::Store { size, at, .. } => parts!("Store", size, at.index),
        I::StoreRegister { size, .. } => parts!("StoreRegister", size),
        I::Dual { load, at, .. } => parts!("Dual", load, at.index, at.rn == 15),
        I::Multiple { load: true, list, decrement, writeback, .. } => {
            parts!("LoadMultiple", list >> 15 == 1, decrement, writeback)
        }
        I::Multiple { decrement, writeback, .. } => parts!("StoreMultiple", decrement, writeback),
        I::LoadExclusive { size, .. } => parts!("LoadExclusive", size),
        I::StoreExclusive { size, .. } => parts!("StoreExclusive", size),
        I::ClearExclusive => parts!("ClearExclusive"),
        I::Branch { .. } => parts!("Branch"),
        I::BranchIf { condition, .. } => parts!("BranchIf", condition.0),
        I::BranchLink { .. } => parts!("BranchLink"),
        I::BranchExchange { .. } => parts!("BranchExchange"),
        I::BranchLinkExchange { .. } => parts!("BranchLinkExchange"),
        I::CompareBranch { non_zero, .. } => parts!("CompareBranch", non_zero),
        I::TableBranch { half, .. } => parts!("TableBranch", half),
        I::IfThen { state } => parts!("IfThen", state >> 4, state.trailing_zeros()),
        I::Hint { hint } => parts!("Hint", hint),
        I::Barrier => parts!("Barrier"),
        I::ChangeState { disable, primask, faultmask } => parts!("ChangeState", disable, primask, faultmask),
        I::MoveFromSpecial { register, .. } => parts!("MoveFromSpecial", register),
        I::MoveToSpecial { register, mask, .. } => parts!("MoveToSpecial", register, mask),
        I::SupervisorCall => parts!("SupervisorCall"),
        I::Breakpoint { .. } => parts!("Breakpoint"),
        I::FpUndefined => parts!("FpUndefined"),
        I::FpBinary { op, .. } => parts!("FpBinary", op),
        I::FpAccumulate { fused, negate_addend, negate_product, .. } => {
            parts!("FpAccumulate", fused, negate_addend, negate_product)
        }
        I::FpUnary { op, .. } => parts!("FpUnary", op),
        I::FpImmediate { .. } => parts!("FpImmediate"),
        I::FpCompare { quiet_raises, zero, .. } => parts!("FpCompare", quiet_raises, zero),
        I::FpConvert { op, .. } => match op {
            FpConvert::FromInteger { signed } => parts!("FpConvert FromInteger", signed),
            FpConvert::ToInteger { signed, to_zero } => parts!("FpConvert ToInteger", signed, to_zero),
            FpConvert::FromFixed { signed, word, .. } => parts!("FpConvert FromFixed", signed, word),
            FpConvert::ToFixed { signed, word, .. } => parts!("FpConvert ToFixed", signed, word),
            FpConvert::FromHalf { top } => parts!("FpConvert FromHalf", top),
            FpConvert::ToHalf { top } => parts!("FpConvert ToHalf", top),
        },
        I::FpMoveCore { to_core, .. } => parts!("FpMoveCore", to_core),
        I::FpMovePair { to_core, .. } => parts!("FpMovePair", to_core),
        I::FpStatusRead { rt } => parts!("FpStatusRead", rt == 15),
        I::FpStatusWrite { .. } => parts!("FpStatusWrite"),
        I::FpTransfer { load, count, rn, .. } => parts!("FpTransfer", load, count, rn == 15),
        I::FpMultiple { load, decrement, writeback, .. } => {
            parts!("FpMultiple", load, decrement, writeback)
        }
    }
}

/// Returns the reason for which Unicorn does not judge a kind, and the place of its tests.
fn reason(&(name, [first, ..]): &Kind) -> Option<&'static str> {
    Some(match name {
        "Undefined" | "NoCoprocessor" | "FpUndefined" => "a UsageFault: tests/faults.rs, tests/fpu.rs",
        "Unpredictable" => "a stop: tests/totality.rs",
        "SupervisorCall" => "an exception: tests/exceptions.rs",
        "Breakpoint" => "a stop or an exception: tests/faults.rs",
        "Hint" if first != Hint::Nop as u8 => "sleep and event register: tests/exceptions.rs",
        "ChangeState" => "masks: tests/exceptions.rs, tests/special.rs",
        "MoveFromSpecial" | "MoveToSpecial" if first > 3 => "masks and stack pointers: tests/special.rs",
        _ => return None,
    })
}

/// All kinds that the decoder answers with, each with one instruction.
fn known() -> BTreeMap<Kind, I> {
    let mut known = BTreeMap::new();
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
fn judged() -> BTreeMap<Kind, usize> {
    let mut reader = Reader(VECTORS);
    let vectors = reader.number(4);
    reader.take(8);
    let mut judged = BTreeMap::new();
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
        match (judged.get(kind), reason(kind)) {
            (Some(_), None) => {}
            (None, Some(_)) => excused += 1,
            (None, None) => missing.push(format!("{example:?}")),
            (Some(count), Some(reason)) => {
                panic!("{kind:?} is in {count} vectors, and is left out because of {reason}")
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
