//! Exceptions: entry, return, priorities, masks, chaining, sleep (DDI 0403E B1.5). Programs are assembled by hand.

use can_twin::cpu::{Stop, Width};

use crate::board::*;

/// Exception number of interrupt 0.
const IRQ: u16 = 16;

fn handler(exception: u16) -> u32 {
    HANDLERS + 32 * u32::from(exception)
}

#[test]
fn entry_stacks_eight_words_and_return_restores_them() {
    let mut board = Board::with_interrupts(&[NOP, NOP], &[0; 8]);
    board.handler(16, &[0x2055, BX_LR]); // MOVS r0, #0x55; BX lr
    board.set(|registers| {
        registers.r[..13].copy_from_slice(&[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13]);
        registers.r[14] = 0x1234;
        registers.xpsr |= C | V | 0xA << 16;
    });
    let before = board.registers();
    assert_eq!(board.raise(0).cycles, 12);
    let entered = board.registers();
    assert_eq!((entered.r[15], board.core.exception()), (handler(IRQ), IRQ));
    assert_eq!((entered.r[13], entered.r[14]), (STACK - 32, 0xFFFF_FFF9));
    let frame: Vec<u32> = (0..8).map(|word| board.word(STACK - 32 + 4 * word)).collect();
    assert_eq!(frame, [1, 2, 3, 4, 13, 0x1234, CODE, before.xpsr]);
    board.core.set_irq(0, false);
    board.step();
    assert_eq!(board.step().cycles, 12, "the instruction that returns included");
    assert_eq!(board.registers(), before);
}

#[test]
fn stack_that_is_not_aligned_gets_padding() {
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.set(|registers| registers.r[13] = STACK - 4);
    board.handler(16, &[BX_LR]);
    board.core.set_irq(0, true);
    assert_eq!(board.steps(1).r[13], STACK - 40);
    assert_eq!(board.word(STACK - 40 + 28) >> 9 & 1, 1);
    board.core.set_irq(0, false);
    assert_eq!(board.steps(1).r[13], STACK - 4);

    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.store(CCR, 0);
    board.set(|registers| registers.r[13] = STACK - 4);
    board.core.set_irq(0, true);
    assert_eq!(board.steps(1).r[13], STACK - 36);
}

#[test]
fn thread_on_the_process_stack_stacks_there() {
    // MSR psp, r2; MSR control, r3
    let mut board = Board::with_interrupts(&[0xF382, 0x8809, 0xF383, 0x8814, NOP], &[0; 8]);
    board.set(|registers| (registers.r[2], registers.r[3]) = (RAM + 0x1000, 2));
    board.handler(16, &[BX_LR]);
    assert_eq!(board.steps(2).r[13], RAM + 0x1000);
    board.core.set_irq(0, true);
    let entered = board.steps(1);
    assert_eq!((entered.r[13], entered.other_sp), (STACK, RAM + 0x1000 - 32));
    assert_eq!(entered.r[14], 0xFFFF_FFFD);
    board.core.set_irq(0, false);
    let returned = board.steps(1);
    assert_eq!((returned.r[13], returned.other_sp), (RAM + 0x1000, STACK));
}

#[test]
fn waiting_exception_is_chained_without_stacking() {
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.handler(16, &[BX_LR]);
    board.handler(17, &[BX_LR]);
    board.store(NVIC_ISPR, 0b11);
    board.step();
    assert_eq!(board.core.exception(), IRQ);
    board.bus.accesses.clear();
    assert_eq!(board.step().cycles, 1 + 6);
    assert_eq!(board.core.exception(), IRQ + 1);
    assert_eq!(board.registers().r[14], 0xFFFF_FFF9);
    // The vector, and nothing of the stack.
    assert_eq!(board.bus.accesses, [(FLASH + 4 * 17, Width::Word, false)]);
    assert_eq!(board.steps(1).r[13], STACK);
}

#[test]
fn priority_decides_and_number_breaks_ties() {
    let mut board = Board::with_interrupts(&[NOP], &[0x40, 0x20, 0x20, 0x10, 0, 0, 0, 0]);
    board.store(NVIC_ISPR, 0b0111);
    board.step();
    assert_eq!(board.core.exception(), IRQ + 1);
    board.raise(2);
    assert_eq!(board.core.exception(), IRQ + 1, "an equal priority does not preempt");
    board.raise(3);
    assert_eq!((board.core.exception(), board.registers().r[14]), (IRQ + 3, 0xFFFF_FFF1));
    assert_eq!(board.load(ICSR) & 0x1FF, u32::from(IRQ) + 3);
    assert_eq!(board.load(ICSR) >> 12 & 0x1FF, u32::from(IRQ) + 2, "VECTPENDING");
}

#[test]
fn subpriority_orders_but_does_not_preempt() {
    let mut board = Board::with_interrupts(&[NOP], &[0x30, 0x20, 0, 0, 0, 0, 0, 0]);
    board.store(AIRCR, 0x05FA_0500); // PRIGROUP 5: two bits of group
    assert_eq!(board.load(AIRCR), 0xFA05_0500);
    board.store(NVIC_ISPR, 0b01);
    board.step();
    board.raise(1);
    assert_eq!(board.core.exception(), IRQ, "the same group");
    let mut board = Board::with_interrupts(&[NOP], &[0x30, 0x20, 0, 0, 0, 0, 0, 0]);
    board.store(AIRCR, 0x05FA_0500);
    board.store(NVIC_ISPR, 0b11);
    board.step();
    assert_eq!(board.core.exception(), IRQ + 1);
}

#[test]
fn masks_hold_exceptions_back() {
    let mut board = Board::with_interrupts(&[CPSID_I, NOP, CPSIE_I, NOP], &[0x40; 8]);
    board.step();
    board.core.set_irq(0, true);
    assert_eq!(board.steps(2).r[15], CODE + 6);
    board.step();
    assert_eq!(board.core.exception(), IRQ, "right after CPSIE");

    // MSR basepri, r2; NOP
    let mut board = Board::with_interrupts(&[0xF382, 0x8811, NOP, NOP], &[0x40, 0x30, 0, 0, 0, 0, 0, 0]);
    board.set(|registers| registers.r[2] = 0x40);
    board.step();
    board.core.set_irq(0, true);
    assert_eq!(board.steps(1).r[15], CODE + 6);
    board.raise(1);
    assert_eq!(board.core.exception(), IRQ + 1);

    let mut board = Board::with_interrupts(&[CPSID_F, NOP, NOP], &[0; 8]);
    board.step();
    board.core.set_irq(0, true);
    assert_eq!(board.steps(1).r[15], CODE + 4);
    board.core.set_nmi(true);
    board.step();
    assert_eq!(board.core.exception(), 2);
}

#[test]
fn line_that_stays_high_pends_again_on_return() {
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.handler(16, &[BX_LR]);
    board.core.set_irq(0, true);
    board.steps(2);
    assert_eq!(board.core.exception(), IRQ, "chained to itself");
    board.core.set_irq(0, false);
    board.step();
    assert_eq!(board.core.exception(), 0);
}

#[test]
fn rising_edge_in_the_handler_pends_again() {
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.handler(16, &[NOP, BX_LR]);
    board.pulse();
    board.core.set_irq(0, true);
    board.core.set_irq(0, false);
    board.steps(2);
    assert_eq!(board.core.exception(), IRQ);
}

#[test]
fn pending_bit_of_a_high_line_cannot_be_cleared() {
    let mut board = Board::new(&[NOP]);
    board.core.set_irq(5, true);
    board.store(NVIC_ICPR, u32::MAX);
    assert_eq!(board.load(NVIC_ISPR), 1 << 5);
    board.core.set_irq(5, false);
    assert_eq!(board.load(NVIC_ISPR), 1 << 5, "it stays pending");
    board.store(NVIC_ICPR, u32::MAX);
    assert_eq!(board.load(NVIC_ISPR), 0);
}

/// Interrupts an IT block after each of its instructions.
#[test]
fn interrupt_in_an_it_block_changes_nothing() {
    // MOVS r0, #5; CMP r0, #5; ITTEE EQ; MOVEQ r1, #1; MOVEQ r2, #2; MOVNE r1, #3; MOVNE r2, #4
    let program = [0x2005, 0x2805, 0xBF07, 0x2101, 0x2202, 0x2103, 0x2204, NOP];
    for after in 0..=7 {
        let mut board = Board::with_interrupts(&program, &[0; 8]);
        // CMP r0, r0; PUSH {r4, lr}; IT EQ; POPEQ {r4, pc}
        board.handler(16, &[0x4280, 0xB510, 0xBF08, 0xBD10]);
        board.steps(after);
        board.pulse();
        let registers = board.steps(4 + 7 - after);
        assert_eq!((registers.r[1], registers.r[2]), (1, 2), "after {after}");
        assert_eq!(registers.r[15], CODE + 14, "after {after}");
    }
}

#[test]
fn restored_ici_continues_load_multiple() {
    // LDM r0!, {r1, r2, r3, r4}
    let mut board = Board::with_interrupts(&[0xC81E, NOP], &[0; 8]);
    board.handler(16, &[BX_LR]);
    board.bus.memory.poke_words(RAM + 0x100, 10..14);
    board.set(|registers| registers.r[..5].copy_from_slice(&[RAM + 0x100, 1, 2, 3, 4]));
    board.pulse();
    // The frame says that r3 comes next.
    let xpsr = board.word(STACK - 4);
    board.bus.memory.poke(STACK - 4, Width::Word, xpsr | 3 << 12);
    let registers = board.steps(2);
    assert_eq!(registers.r[..5], [RAM + 0x110, 1, 2, 12, 13]);
    assert_eq!(registers.xpsr & 0x0600_FC00, 0);

    // The same in front of another instruction.
    let mut board = Board::new(&[NOP]);
    board.set(|registers| registers.xpsr |= 3 << 12);
    board.step();
    assert_eq!(board.load(CFSR), 1 << 17, "INVSTATE");
}

#[test]
fn wfe_falls_through_after_an_exception() {
    let mut board = Board::with_interrupts(&[WFE, WFE, NOP], &[0; 8]);
    board.handler(16, &[BX_LR]);
    assert!(board.step().asleep);
    assert!(board.step().asleep);
    assert!(!board.raise(0).asleep);
    board.core.set_irq(0, false);
    board.step();
    assert!(!board.step().asleep, "entry and return have set the event register");
    assert_eq!(board.registers().r[15], CODE + 4);
}

#[test]
fn sev_lets_one_wfe_through() {
    let mut board = Board::new(&[SEV, WFE, WFE, NOP]);
    assert!(!board.step().asleep);
    assert!(!board.step().asleep);
    assert!(board.step().asleep);
    board.core.send_event();
    assert!(!board.step().asleep);
    assert_eq!(board.registers().r[15], CODE + 8);
}

#[test]
fn sevonpend_wakes_by_an_interrupt_that_is_not_enabled() {
    let mut board = Board::new(&[WFE, NOP]);
    assert!(board.raise(3).asleep);
    assert!(board.step().asleep);
    let mut board = Board::new(&[WFE, NOP]);
    board.store(SCR, 1 << 4);
    assert!(board.step().asleep);
    assert!(!board.raise(3).asleep);
}

#[test]
fn wfi_wakes_by_an_interrupt_that_primask_holds_back() {
    let mut board = Board::with_interrupts(&[CPSID_I, WFI, NOP], &[0x40; 8]);
    board.step();
    assert!(board.step().asleep);
    assert!(!board.raise(0).asleep);
    assert_eq!((board.core.exception(), board.registers().r[15]), (0, CODE + 6));

    // BASEPRI holds it back as well, and does not wake.
    let mut board = Board::with_interrupts(&[0xF382, 0x8811, WFI, NOP], &[0x40; 8]);
    board.set(|registers| registers.r[2] = 0x40);
    board.step();
    assert!(board.step().asleep);
    assert!(board.raise(0).asleep);
}

#[test]
fn sleep_on_exit_sleeps_after_the_last_handler() {
    let mut board = Board::with_interrupts(&[NOP, NOP], &[0; 8]);
    board.handler(16, &[BX_LR]);
    board.store(SCR, 1 << 1 | 1 << 2);
    board.pulse();
    assert!(board.step().asleep);
    assert!(board.core.sleeps_deeply());
    assert_eq!(board.registers().r[15], CODE);
}

#[test]
fn svc_enters_its_handler_after_the_instruction() {
    let mut board = Board::new(&[0xDF07, NOP]); // SVC #7
    assert_eq!(board.step().cycles, 1 + 12);
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (11, CODE + 2));
}

#[test]
fn svc_that_cannot_preempt_becomes_hard_fault() {
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.handler(16, &[0xDF07]);
    board.core.set_irq(0, true);
    board.steps(2);
    assert_eq!(board.core.exception(), 3);
    assert_eq!(board.word(STACK - 32 - 8), handler(IRQ), "the SVC itself");
    assert_eq!(board.load(HFSR), FORCED);
}

/// Given an IT block with SVC first. When SVC becomes HardFault. Then the frame has the state of the SVC, which runs again.
#[test]
fn svc_that_becomes_hard_fault_keeps_its_it_state() {
    // CPSID i; ITT EQ; SVCEQ #0; MOVEQ r5, #1
    let mut board = Board::new(&[CPSID_I, 0xBF04, 0xDF00, 0x2501]);
    board.set(|registers| registers.xpsr |= Z);
    board.steps(3);
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (3, CODE + 4));
    assert_eq!(board.word(STACK - 4) & 0x0600_FC00, 0x0000_0400, "ITSTATE 04h: EQ, two instructions");
}

#[test]
fn pendsv_waits_for_handlers_of_higher_priority() {
    let mut board = Board::with_interrupts(&[NOP], &[0x40; 8]);
    board.store(SHPR3, 0x00FF_0000);
    assert_eq!(board.load(SHPR3), 0x00F0_0000, "4 bits");
    board.store(SHPR2, 0x8000_0000);
    board.handler(16, &[BX_LR]);
    board.raise(0);
    board.store(ICSR, 1 << 28);
    board.core.set_irq(0, false);
    board.step();
    assert_eq!(board.core.exception(), 14);
}

#[test]
fn software_trigger_pends_an_interrupt() {
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.store(STIR, 5);
    board.step();
    assert_eq!(board.core.exception(), IRQ + 5);
}

#[test]
fn exc_return_that_names_no_mode_raises_invpc() {
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.handler(16, &[BX_R0]);
    board.set(|registers| registers.r[0] = 0xFFFF_FFF5);
    board.core.set_irq(0, true);
    board.steps(2);
    assert_eq!(board.core.exception(), 3);
    assert_eq!(board.load(CFSR), 1 << 18);

    // To Thread mode with an exception number in the frame.
    let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
    board.handler(16, &[BX_LR]);
    board.raise(0);
    let xpsr = board.word(STACK - 4);
    board.bus.memory.poke(STACK - 4, Width::Word, xpsr | 16);
    board.core.set_irq(0, false);
    board.step();
    assert_eq!(board.core.exception(), 3);
    assert_eq!(board.load(CFSR), 1 << 18);
    assert_eq!(board.registers().r[13], STACK - 32, "the frame is still there");
}

/// Given a handler that loads a reserved EXC_RETURN to PC. When the core stops with the instruction. Then no register has changed.
#[test]
fn unpredictable_exc_return_stops_before_the_pop() {
    // POP {r4, pc}; LDR pc, [sp], #8
    for program in [&[0xBD10_u16][..], &[0xF85D, 0xFB08]] {
        let mut board = Board::with_interrupts(&[NOP], &[0; 8]);
        board.handler(16, program);
        board.raise(0);
        board.bus.memory.poke_words(STACK - 32, [0xF000_0000; 2]);
        let before = board.registers();
        let word = program.iter().fold(0, |word, &half| word << 16 | u32::from(half));
        assert_eq!(board.try_step(), Err(Stop::Unpredictable { address: handler(IRQ), word }));
        assert_eq!(board.registers(), before);
    }
}

#[test]
fn exclusive_store_fails_after_an_exception() {
    // LDREX r2, [r0]; STREX r3, r1, [r0]
    let mut board = Board::with_interrupts(&[0xE850, 0x2F00, 0xE840, 0x1300], &[0; 8]);
    board.handler(16, &[BX_LR]);
    board.set_r0_r1(RAM + 0x100, 7);
    board.step();
    let mut undisturbed = board.clone();
    assert_eq!((undisturbed.steps(1).r[3], undisturbed.word(RAM + 0x100)), (0, 7));
    board.pulse();
    board.step();
    assert_eq!((board.steps(1).r[3], board.word(RAM + 0x100)), (1, 0));
}

#[test]
fn reset_request_stops_the_core_and_reset_starts_it_again() {
    let mut board = Board::with_interrupts(&[STR, NOP], &[0; 8]);
    board.set_r0_r1(AIRCR, 0x05FA_0004);
    assert_eq!(board.try_step(), Err(Stop::ResetRequest));
    board.core.reset();
    assert_eq!(board.step().cycles, 2);
    assert_eq!(board.registers().r[15], CODE);
    assert_eq!(board.load(NVIC_ISER), 0);
}

#[test]
fn clone_continues_exactly_as_the_original() {
    // ADDS r0, #1; STR r0, [r1]; B .-4
    let mut board = Board::with_interrupts(&[0x3001, 0x6008, 0xE7FC], &[0; 8]);
    board.handler(16, &[0x3401, BX_LR]); // ADDS r4, #1
    board.set(|registers| registers.r[1] = RAM);
    board.steps(10);
    let mut copy = board.clone();
    for (step, side) in [&mut board, &mut copy].into_iter().enumerate() {
        for k in 0..50 {
            side.core.set_irq(0, k % 7 == 3);
            side.step();
        }
        assert!(side.registers().r[4] > 0, "copy {step}");
    }
    assert_eq!(board, copy);
}

#[test]
fn run_ends_with_its_budget_or_with_sleep() {
    let mut board = Board::new(&[NOP, NOP, NOP, WFI, NOP]);
    let run = board.core.run(&mut board.bus, 2);
    assert_eq!((run.steps, run.asleep, run.stop), (2, false, None));
    let run = board.core.run(&mut board.bus, 100);
    assert_eq!((run.steps, run.asleep, run.stop), (2, true, None));
}

#[test]
fn waits_of_the_bus_count() {
    let mut board = Board::new(&[NOP]);
    let before = board.core.cycle();
    board.bus.waits = 5;
    assert_eq!(board.step().cycles, 6);
    assert_eq!(board.core.cycle(), before + 6);
}

#[test]
fn changed_code_runs_at_once_in_ram_and_in_flash_if_invalidated() {
    let mut board = Board::new(&[0x2001, 0xE7FD]); // MOVS r0, #1; B .-2
    board.bus.memory.poke_code(RAM + 0x100, &[0x2001]);
    board.set(|registers| registers.r[15] = RAM + 0x100);
    assert_eq!(board.steps(1).r[0], 1);
    board.bus.memory.poke_code(RAM + 0x100, &[0x2002]);
    board.set(|registers| registers.r[15] = RAM + 0x100);
    assert_eq!(board.steps(1).r[0], 2);

    board.set(|registers| registers.r[15] = CODE);
    board.step();
    board.bus.memory.poke_code(CODE, &[0x2003]);
    assert_eq!(board.steps(2).r[0], 1);
    board.bus.is_settled = false;
    assert_eq!(board.steps(2).r[0], 3, "a cache in front of the flash shows something else");
    board.bus.is_settled = true;
    assert_eq!(board.steps(2).r[0], 1);
    board.core.invalidate(CODE..CODE + 2);
    assert_eq!(board.steps(2).r[0], 3);
}
