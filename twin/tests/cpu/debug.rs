//! Cycle counter and debug registers (DDI 0403E C1.6, C1.8). Neither Unicorn nor QEMU models them.

use can_twin::cpu::Stop;

use crate::board::*;

// Cycle counter (C1.8).

#[test]
fn cycle_counter_is_written_and_wraps() {
    // The second one is LDR r3, [r0].
    let mut board = Board::new(&[LDR, NOP, NOP, 0x6803]);
    board.start_cycle_counter();
    board.store(DWT_CYCCNT, u32::MAX - 1);
    board.set(|registers| registers.r[0] = DWT_CYCCNT);
    let registers = board.steps(4);
    assert!(registers.r[2] >= u32::MAX - 1 || registers.r[2] < 4, "{:08X}", registers.r[2]);
    assert_eq!(registers.r[3].wrapping_sub(registers.r[2]), 4);
    assert!(registers.r[3] < 8);
}

#[test]
fn cycle_counter_stands_without_trcena() {
    let mut board = Board::new(&[NOP; 16]);
    board.store(DWT_CTRL, 1);
    board.store(DWT_CYCCNT, 7);
    board.steps(10);
    assert_eq!(board.load(DWT_CYCCNT), 7);
    board.store(DEMCR, TRCENA);
    board.store(DWT_CTRL, 0);
    let stopped = board.load(DWT_CYCCNT);
    board.steps(5);
    assert_eq!(board.load(DWT_CYCCNT), stopped);
}

#[test]
fn cycle_counter_counts_entry_and_return() {
    let mut board = Board::with_interrupts(&[NOP, NOP], &[0, 0]);
    board.handler(16, &[BX_LR]);
    board.start_cycle_counter();
    let mut idle = board.clone();
    board.pulse();
    board.step();
    assert_eq!(board.load(DWT_CYCCNT) - idle.load(DWT_CYCCNT), 12 + 12);
}

#[test]
fn cycle_counter_is_all_of_the_dwt() {
    let mut board = Board::new(&[STR]);
    assert_eq!(board.load(DWT_CTRL), 4 << 28, "four comparators");
    // PCSAMPLENA
    board.set_r0_r1(DWT_CTRL, 1 << 12 | 1);
    let stop = Stop::Unmodelled { instruction: CODE, address: DWT_CTRL, write: true };
    assert_eq!(board.try_step(), Err(stop));
}

// Debug registers (C1.6).

#[test]
fn dhcsr_reports_a_reset_once() {
    let mut board = Board::new(&[NOP]);
    let (ready, retired, reset) = (1 << 16, 1 << 24, 1 << 25);
    assert_eq!(board.load(DHCSR), ready | retired | reset);
    assert_eq!(board.load(DHCSR), ready | retired);
    // C_DEBUGEN by the program, with the key.
    board.store(DHCSR, 0xA05F_0001);
    assert_eq!(board.load(DHCSR), ready | retired, "a program cannot attach a debugger");
}

#[test]
fn demcr_outlives_a_reset() {
    let mut board = Board::new(&[NOP]);
    board.store(DEMCR, TRCENA | MON_REQ | MON_EN);
    board.core.reset();
    board.step();
    assert_eq!(board.load(DEMCR), TRCENA | MON_REQ | MON_EN);
}

#[test]
fn vector_catch_is_not_modelled() {
    let mut board = Board::new(&[STR]);
    // VC_HARDERR
    board.set_r0_r1(DEMCR, 1 << 10);
    assert_eq!(board.try_step(), Err(Stop::Unmodelled { instruction: CODE, address: DEMCR, write: true }));
}

#[test]
fn monitor_that_is_pended_waits_for_its_priority() {
    let mut board = Board::with_interrupts(&[NOP], &[0x40, 0]);
    board.handler(16, &[NOP, BX_LR]);
    board.store(SHPR3, 0x80);
    board.pulse();
    board.store(DEMCR, MON_EN | MON_PEND);
    assert_eq!(board.load(DEMCR), MON_EN | MON_PEND);
    board.steps(2);
    assert_eq!(board.core.exception(), 12, "chained");
    assert_eq!(board.load(DEMCR), MON_EN);
}

#[test]
fn pended_monitor_can_be_taken_back() {
    let mut board = Board::new(&[CPSID_I, NOP]);
    board.step();
    board.store(DEMCR, MON_EN | MON_PEND);
    board.store(DEMCR, MON_EN);
    assert_eq!(board.load(ICSR) >> 12 & 0x1FF, 0);
}

/// Given DebugMonitor enabled, and a priority that it cannot preempt. When BKPT runs. Then HardFault takes it with DEBUGEVT.
#[test]
fn breakpoint_that_the_monitor_cannot_take_is_a_hard_fault() {
    let mut board = Board::with_interrupts(&[NOP], &[0x40, 0]);
    board.handler(16, &[BKPT]);
    board.store(SHPR3, 0x40);
    board.store(DEMCR, MON_EN);
    board.core.set_irq(0, true);
    board.steps(2);
    assert_eq!(board.core.exception(), 3);
    assert_eq!((board.load(HFSR), board.load(DFSR)), (DEBUGEVT, 1 << 1));
    board.store(DFSR, 1 << 1);
    assert_eq!(board.load(DFSR), 0, "written ones clear");
}
