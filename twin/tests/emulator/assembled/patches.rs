//! The flash patch unit of the core on a board.

use can_twin::board::State;
use can_twin::wire::time::Time;

use super::programs::*;

const FP_CTRL: u32 = 0xE000_2000;
const FP_REMAP: u32 = 0xE000_2004;
const FP_COMP0: u32 = 0xE000_2008;
/// KEY and ENABLE.
const ON: u32 = 0b11;
const AIRCR: u32 = 0xE000_ED0C;
const SYSRESETREQ: u32 = 0x05FA_0004;

/// Given a program that keeps what it finds in the unit and enables it, then a reset of the chip keeps the unit, and power-on resets it.
#[test]
fn power_on_resets_the_unit_and_a_reset_does_not() {
    const COMPARATOR: u32 = 0x0800_0C00 | 1;
    let program = [
        copy(FP_CTRL, RAM),
        copy(FP_COMP0, RAM + 4),
        store(FP_COMP0, COMPARATOR),
        store(FP_CTRL, ON),
        STOP.to_vec(),
    ];
    let mut board = flown(board("patched", image(&program.concat(), &STOP)), Time::from_us(50));
    assert_eq!(words(&board, RAM), [0x260, 0]);
    board.reset();
    board.run_until(Time::from_us(100)).unwrap();
    assert_eq!(words(&board, RAM), [0x261, COMPARATOR]);
    board.brown_out();
    board.run_until(Time::from_us(150)).unwrap();
    assert_eq!(words(&board, RAM), [0x260, 0]);
    board.power(false);
    board.power(true);
    board.run_until(Time::from_us(200)).unwrap();
    assert_eq!(words(&board, RAM), [0x260, 0]);
}

/// Given a program that asks for a reset once the unit is on, then it finds the unit on.
#[test]
fn system_reset_by_the_program_keeps_the_unit() {
    let program = [
        &load(0, FP_CTRL)[..],
        &load(2, 0x261),
        &[0x6801, 0x4291, 0xD014], // LDR r1, [r0]; CMP r1, r2; BEQ over the reset
        &store(FP_CTRL, ON),
        &store(AIRCR, SYSRESETREQ),
        &STOP,
        &[0xBF00; 2],
        &store(RAM, 0x600D_CAFE),
        &STOP,
    ];
    let board = flown(board("phoenix", image(&program.concat(), &STOP)), Time::from_us(100));
    assert_eq!((board.counters().system_resets, word(&board, RAM)), (1, 0x600D_CAFE));
}

/// Given a fault handler whose first instruction, a branch to itself, is replaced by a store and such a branch, then the handler stores, and
/// the board is stuck behind it.
#[test]
fn replaced_branch_to_itself_does_not_count_as_stuck() {
    let stored = RAM + 8;
    let program = [
        &store(RAM + 0x100, 0xE7FE_6001)[..], // STR r1, [r0]; B .
        &store(FP_REMAP, RAM + 0x100),
        &store(FP_COMP0, HANDLER | 1),
        &store(FP_CTRL, ON),
        &load(0, stored),
        &load(1, 42),
        &[0xDE00], // UDF
    ];
    let board = flown(board("stuck", image(&program.concat(), &STOP)), Time::from_us(100));
    assert_eq!((board.state(), word(&board, stored)), (&State::Stuck, 42));
}
