//! Copies of a spacecraft in flight.

use can_twin::board::{BoardConfig, Counters, EmulatedBoard, Registers};
use can_twin::crystal::Crystal;
use can_twin::spacecraft::Bus;
use can_twin::wire::fault::Fault;
use flight::*;

const RAM: u32 = 0x2000_0000;
const RAM_BYTES: usize = 128 << 10;

/// Time of the fault, after the copy of the flight.
const CUT_MS: u64 = 6_000;
const COPIED_MS: u64 = 5_000;
const END_MS: u64 = 10_000;

/// Returns a flight of a master and three slaves with drifting crystals, and a cut of the nominal bus next to the
/// master.
fn flight() -> Flight {
    let mut flight = Flight::of(&MASTER_AND_THREE, |setup| {
        let drifts = Crystal { drift_ppm_per_s: 0.05, walk_ppb: 2.0, seed: 7, ..Crystal::ppm(setup.ppm) };
        BoardConfig { crystal: drifts, ..setup.with(&STANDARD) }
    });
    let cut = Fault::Cut { position_m: NEXT_TO_MASTER_M };
    flight.twin.wire_mut(Bus::Nominal).schedule(ms(CUT_MS), cut).unwrap();
    flight
}

/// Returns counters, core registers and RAM of all boards.
fn boards(flight: &Flight) -> Vec<(Counters, Registers, Vec<u8>)> {
    let state = |board: &EmulatedBoard| {
        (board.counters(), board.registers(), board.read_memory(RAM, RAM_BYTES).unwrap())
    };
    flight.twin.boards().map(|(_, board)| state(board)).collect()
}

fn assert_equal(flight: &Flight, reference: &Flight, which: &str) {
    assert!(flight.records == reference.records, "{which}: records of the buses");
    assert_eq!(flight.logs, reference.logs, "{which}: logs");
    assert!(boards(flight) == boards(reference), "{which}: counters, registers or RAM");
}

/// Given a flight of 10 s with a fail-over, when it is copied at 5 s, then the copy and the original end as the flight without a copy
/// does.
#[test]
fn copy_and_original_continue_exactly_alike() {
    let mut reference = flight();
    reference.fly_to(END_MS);
    // The fail-over is part of the flight.
    reference.assert_said(2, "bus", ms(CUT_MS));

    let mut original = flight();
    original.fly_to(COPIED_MS);
    let mut copy = original.clone();
    copy.fly_to(END_MS);
    assert_equal(&copy, &reference, "copy");
    assert_eq!(original.twin.now(), ms(COPIED_MS), "the original stood still");
    original.fly_to(END_MS);
    assert_equal(&original, &reference, "original");
}

/// Given two copies, when one of them loses a board, then the other one is not affected.
#[test]
fn copies_share_no_state() {
    let mut original = flight();
    original.fly_to(COPIED_MS);
    let mut untouched = original.clone();
    let mut changed = original.clone();
    let board = changed.board(3);
    changed.twin.power(board, false);
    changed.emulated_mut(3).set_temperature(80.0);
    changed.emulated_mut(3).write_flash(0x0800_0000, &[0; 512]).unwrap();
    changed.fly_to(END_MS);
    assert!(!changed.is_operational(3, Bus::Redundant));
    original.fly_to(END_MS);
    untouched.fly_to(END_MS);
    assert_equal(&untouched, &original, "copy");
}
