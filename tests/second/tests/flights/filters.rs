//! A bit of an acceptance filter flips in a running board (ECSS 6.10d).

use flight::*;
use flight::{minimal, standby};

/// Registers of the filters, from those of CAN1 on. CAN_FMR: bit 0 is FINIT, bits 8 to 13 the first bank of CAN2.
const FMR: u32 = 0x200;
/// CAN_FM1R, CAN_FS1R and CAN_FFA1R: mode, scale and FIFO of each bank.
const FM1R: u32 = 0x204;
const FS1R: u32 = 0x20C;
const FFA1R: u32 = 0x214;
/// CAN_FA1R: a bit for each bank of two filters that is active.
const FA1R: u32 = 0x21C;
/// CAN_F1R1 and CAN_F15R2: two filters of CAN1, and two of CAN2.
const F1R1: u32 = 0x248;
const F15R2: u32 = 0x2BC;
/// The first bank of CAN2.
const CAN2: u32 = 14;

/// Time of the flip, when all nodes are Operational.
const FLIP_MS: u64 = 3_000;
/// Time by which the filters are repaired: within 5 s.
const END_MS: u64 = FLIP_MS + 5_000;

fn active_banks(flight: &Flight, node: u8) -> u32 {
    flight.emulated(node).can_register(FA1R).unwrap()
}

/// Returns the first and the last active bank of each controller.
fn outer_banks(active: u32) -> u32 {
    let of_one = |banks: u32| 1 << banks.trailing_zeros() | 1 << banks.ilog2();
    of_one(active & ((1 << CAN2) - 1)) | of_one(active & !((1 << CAN2) - 1))
}

/// Clears active banks in each node, and asserts that they are repaired.
fn assert_mended(mut flight: Flight, nodes: &[u8]) {
    flight.fly_to(FLIP_MS);
    let before: Vec<u32> = nodes.iter().map(|node| active_banks(&flight, *node)).collect();
    for (node, active) in nodes.iter().zip(&before) {
        flight.emulated_mut(*node).set_can_register(FA1R, active & !outer_banks(*active)).unwrap();
        assert_eq!((active ^ active_banks(&flight, *node)).count_ones(), 4, "node {node}");
    }
    flight.fly_to(END_MS);
    let after: Vec<u32> = nodes.iter().map(|node| active_banks(&flight, *node)).collect();
    assert_eq!(after, before, "of nodes {nodes:?}");
}

/// Given a master that commands and slaves that answer, a minimal slave, or a standby that has sent nothing, when bits of CAN_FA1R are
/// cleared in each of them, then these are set again within 5 s.
///
/// Verifies: ECSS 6.10d
#[test]
fn flipped_filters_of_every_node_are_mended() {
    assert_mended(Flight::with(&MASTER_AND_THREE[..3], &STANDARD), &[MASTER, 2, 3]);
    assert_mended(minimal::standard(&[MASTER_AND_THREE[0], minimal::SETUP]), &[minimal::SETUP.node]);
    assert_mended(standby::flight(&standby::ALL), &[standby::SECOND]);
}

/// Given a master and a slave, when a bit flips in a register of the filters, in a copy of the flight for each, then it
/// is repaired within 5 s.
///
/// Verifies: ECSS 6.10d
#[test]
fn flipped_bits_of_filter_registers_are_mended() {
    let mut flight = Flight::with(&MASTER_AND_THREE[..2], &STANDARD);
    flight.fly_to(FLIP_MS);
    let flips = [(FMR, 0), (FMR, 8), (FM1R, 2), (FS1R, 2), (FFA1R, 16), (F1R1, 7), (F1R1, 23), (F15R2, 6)];
    for (node, (register, bit)) in [MASTER, 2].into_iter().flat_map(|node| flips.map(|flip| (node, flip))) {
        let mut copy = flight.clone();
        let board = copy.emulated_mut(node);
        let [fmr, before] = [FMR, register].map(|register| board.can_register(register).unwrap());
        // The program cannot write most of them while FINIT is clear, but an upset can change them.
        let writes = [(FMR, fmr | 1), (register, before ^ 1 << bit)].into_iter();
        for (register, value) in writes.chain((register != FMR).then_some((FMR, fmr))) {
            board.set_can_register(register, value).unwrap();
        }
        assert_ne!(board.can_register(register), Ok(before));
        copy.fly_to(END_MS);
        let after = copy.emulated(node).can_register(register);
        assert_eq!(after, Ok(before), "node {node}: {register:03X}h, bit {bit}");
    }
}
