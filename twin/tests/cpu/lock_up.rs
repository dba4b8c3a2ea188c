//! Lock-up (DDI 0403E B1.5.15). QEMU terminates at a lock-up, so these are written from the manual.

use can_twin::cpu::Width;

use crate::board::*;

const LOCK_UP: u32 = 0xFFFF_FFFE;

/// Locked up, with its PC.
fn is_locked_up(board: &Board) -> bool {
    board.core.is_locked_up() && board.registers().r[15] == LOCK_UP
}

#[test]
fn faults_and_calls_in_hard_fault_lock_up() {
    // UDF; SVC; BKPT without a debugger; LDR from nowhere
    for code in [UDF, SVC, BKPT, 0x6802] {
        let mut board = Board::new(&[UDF]);
        board.handler(3, &[code]);
        board.set(|registers| registers.r[0] = NOWHERE);
        board.steps(2);
        assert!(is_locked_up(&board), "{code:04X}");
        assert_eq!(board.core.exception(), 3);
        // The handler of the NMI reads the state.
        board.core.set_nmi(true);
        board.step();
        assert_eq!(board.load(HFSR), if code == BKPT { FORCED | DEBUGEVT } else { FORCED });
    }
}

#[test]
fn fault_with_faultmask_locks_up() {
    let mut board = Board::new(&[CPSID_F, UDF]);
    board.steps(2);
    assert!(is_locked_up(&board));
    assert_eq!(board.core.exception(), 0);
    board.core.set_nmi(true);
    board.step();
    assert_eq!((board.core.exception(), board.core.is_locked_up()), (2, false));
}

#[test]
fn lock_up_in_nmi_ends_with_reset_alone() {
    let mut board = Board::new(&[NOP]);
    board.handler(2, &[UDF]);
    board.core.set_nmi(true);
    board.steps(2);
    assert!(is_locked_up(&board));
    board.core.set_nmi(false);
    board.core.set_nmi(true);
    board.core.set_irq(0, true);
    board.steps(3);
    assert!(is_locked_up(&board));
    board.core.set_nmi(false);
    board.core.reset();
    board.step();
    assert_eq!((board.core.is_locked_up(), board.registers().r[15]), (false, CODE));
}

#[test]
fn nmi_returns_to_a_lock_up() {
    let mut board = Board::new(&[UDF]);
    board.handler(3, &[UDF]);
    board.handler(2, &[BX_LR]);
    board.steps(2);
    board.core.set_nmi(true);
    board.step();
    board.core.set_nmi(false);
    assert_eq!(board.core.exception(), 2);
    board.steps(2);
    assert!(is_locked_up(&board));
    assert_eq!(board.core.exception(), 3);
}

#[test]
fn nmi_handler_that_mends_the_frame_ends_a_lock_up() {
    let mut board = Board::new(&[UDF]);
    board.handler(3, &[UDF]);
    // ADD r0, pc, #4; STR r0, [sp, #24]; BX lr; NOP; NOP
    board.handler(2, &[0xA001, 0x9006, BX_LR, NOP, NOP]);
    board.steps(2);
    board.core.set_nmi(true);
    board.step();
    board.core.set_nmi(false);
    board.steps(4);
    assert_eq!((board.core.exception(), board.core.is_locked_up()), (3, false));
    assert_eq!(board.registers().r[15], HANDLERS + 2 * 32 + 8 + 2);
}

#[test]
fn hard_fault_without_a_vector_locks_up() {
    let mut board = Board::new(&[UDF]);
    board.store(VTOR, NOWHERE);
    board.step();
    assert!(is_locked_up(&board));
}

#[test]
fn reset_vectors_without_memory_lock_up() {
    let mut board = Board::new(&[NOP]);
    let flash = board.bus.memory.0.iter_mut().find(|piece| piece.from == FLASH).unwrap();
    flash.content.truncate(4);
    board.core.reset();
    board.step();
    assert!(is_locked_up(&board));
    assert_eq!(board.bus.memory.peek(FLASH + 4, Width::Word), None);
}

#[test]
fn locked_up_core_lets_time_pass() {
    let mut board = Board::new(&[CPSID_F, UDF]);
    board.steps(2);
    let before = board.core.cycle();
    let step = board.step();
    assert_eq!((step.cycles, step.asleep), (1, false));
    assert_eq!(board.core.cycle(), before + 1);
}
