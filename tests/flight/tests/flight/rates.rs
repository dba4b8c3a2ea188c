//! Slower buses: one of the rates of the standard, and the slowest. The others fly in `tests/interop/tests/images/rates.rs`.

use flight::rates::{assert_carries_a_slave, assert_flies, at};
use flight::{Craft, MASTER_AND_THREE, STANDARD};
use twin::bxcan::Side;

/// Verifies: ECSS 5.4.2a.3
/// Verifies: ECSS 5.4.3a
#[test]
fn spacecraft_at_125_kbit_per_second_survives_a_cut() {
    assert_flies(125);
}

/// CAN_BTR (RM0090 32.9.2): SJW - 1, TS2 - 1, TS1 - 1 and prescaler - 1 at bits 24, 20, 16 and 0.
const fn btr(prescaler: u32, ts1: u32, ts2: u32, sjw: u32) -> u32 {
    (sjw - 1) << 24 | (ts2 - 1) << 20 | (ts1 - 1) << 16 | (prescaler - 1)
}

/// Given images for two bit rates, then both controllers of each board have the time quanta, the sample point and the jump width that
/// docs/decisions/clocks-and-bit-timing.md derives: 14 quanta and 85.7 %, or 16 quanta and 87.5 %.
///
/// Verifies: ECSS 5.4.3a, 5.4.3c
#[test]
fn controllers_have_the_bit_timing_of_their_network() {
    for (images, expected) in [(STANDARD.clone(), btr(3, 11, 2, 1)), (at(125, "standard"), btr(21, 13, 2, 1))]
    {
        let mut craft = Craft::with(&MASTER_AND_THREE[..2], &images);
        craft.fly_to(1_000);
        for (id, board) in craft.twin.boards() {
            for side in [Side::Can1, Side::Can2] {
                assert_eq!(board.can_btr(side), expected, "{id:?} {side:?}: {:08X}h", board.can_btr(side));
            }
        }
    }
}

#[test]
fn a_bus_of_10_kbit_per_second_carries_a_slave() {
    assert_carries_a_slave(10);
}
