//! A bit of an acceptance filter flips in a running board (ECSS 6.10d).

use flight::*;

use crate::{minimal, standby};

/// CAN_FA1R, from the registers of CAN1 on: a bit for each bank of two filters that is active.
const FA1R: u32 = 0x21C;
/// The first bank of CAN2.
const CAN2: u32 = 14;

/// All nodes are Operational.
const FLIP_MS: u64 = 3_000;
/// What is wrong is mended within 5 s.
const END_MS: u64 = FLIP_MS + 5_000;

fn active_banks(flight: &Flight, node: u8) -> u32 {
    flight.twin.board(flight.board(node)).can_register(FA1R).unwrap()
}

/// The first and the last active bank of each controller.
fn outer_banks(active: u32) -> u32 {
    let of_one = |banks: u32| 1 << banks.trailing_zeros() | 1 << banks.ilog2();
    of_one(active & ((1 << CAN2) - 1)) | of_one(active & !((1 << CAN2) - 1))
}

/// Clears these bits of each node, and flies on.
fn assert_mended(mut flight: Flight, nodes: &[u8]) {
    flight.fly_to(FLIP_MS);
    let before: Vec<u32> = nodes.iter().map(|node| active_banks(&flight, *node)).collect();
    for (node, active) in nodes.iter().zip(&before) {
        let id = flight.board(*node);
        flight.twin.board_mut(id).set_can_register(FA1R, active & !outer_banks(*active)).unwrap();
        assert_eq!((active ^ active_banks(&flight, *node)).count_ones(), 4, "node {node}");
    }
    flight.fly_to(END_MS);
    let after: Vec<u32> = nodes.iter().map(|node| active_banks(&flight, *node)).collect();
    assert_eq!(after, before, "of nodes {nodes:?}");
}

/// Given a master that commands and slaves that answer, when bits of CAN_FA1R are cleared in each of them, then these are set again
/// within 5 s.
///
/// Verifies: ECSS 6.10d
#[test]
fn flipped_filters_of_master_and_slaves_are_mended() {
    assert_mended(Flight::with(&MASTER_AND_THREE[..3], &STANDARD), &[MASTER, 2, 3]);
}

/// Verifies: ECSS 6.10d
#[test]
fn flipped_filters_of_a_minimal_slave_are_mended() {
    assert_mended(minimal::standard(&[MASTER_AND_THREE[0], minimal::SETUP]), &[minimal::SETUP.node]);
}

/// Given a standby that has sent nothing.
///
/// Verifies: ECSS 6.10d
#[test]
fn flipped_filters_of_a_standby_are_mended() {
    assert_mended(standby::flight(&standby::ALL), &[standby::SECOND]);
}
