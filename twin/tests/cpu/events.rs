//! Event register and continued load and store multiple (DDI 0403E B1.5.10, B1.5.18). Neither Unicorn nor QEMU models
//! them.

use can_twin::cpu::{Stop, Width};

use crate::board::*;

// Event register (B1.5.18).

/// Given PRIMASK. When an enabled interrupt becomes pending. Then WFE goes on sleeping, unless SEVONPEND makes it an event.
#[test]
fn masked_interrupt_is_no_event() {
    for (sevonpend, asleep) in [(0, true), (SEVONPEND, false)] {
        let mut board = Board::with_interrupts(&[CPSID_I, WFE, NOP], &[0x40, 0]);
        board.store(SCR, sevonpend);
        board.step();
        assert!(board.step().asleep);
        board.core.set_irq(0, true);
        assert_eq!(board.step().asleep, asleep, "SEVONPEND {sevonpend}");
        assert_eq!(board.core.exception(), 0);
    }
}

#[test]
fn interrupt_that_is_pending_already_is_no_new_event() {
    let mut board = Board::new(&[WFE, WFE, NOP]);
    board.store(SCR, SEVONPEND);
    assert!(!board.raise(0).asleep, "the event of its pending");
    board.core.set_irq(0, false);
    assert!(board.raise(0).asleep);
}

#[test]
fn wfe_consumes_the_event_of_an_exception() {
    let mut board = Board::with_interrupts(&[NOP, WFE, WFE], &[0, 0]);
    board.handler(16, &[BX_LR]);
    board.pulse();
    board.steps(2);
    assert!(!board.step().asleep);
    assert!(board.step().asleep);
}

/// Given WFE in a handler. When an interrupt of the same priority becomes pending. Then it does not wake; one of higher priority does.
#[test]
fn wfe_wakes_for_what_can_preempt() {
    let mut board = Board::with_interrupts(&[NOP], &[0x40, 0x40]);
    // The first WFE consumes the event of the entry.
    board.handler(16, &[WFE, WFE, NOP]);
    board.core.set_irq(0, true);
    board.steps(2);
    assert!(board.step().asleep);
    assert!(board.raise(1).asleep);
    board.core.set_nmi(true);
    assert!(!board.step().asleep);
    assert_eq!(board.core.exception(), 2);
}

// Continued load and store multiple (B1.5.10).

/// A board at a program whose restored xPSR says that `register` comes next.
fn continued(program: &[u16], register: u32) -> Board {
    let mut board = Board::new(program);
    board.bus.memory.poke_words(RAM + 0x100, 10..14);
    board.set(|registers| {
        registers.r[..5].copy_from_slice(&[RAM + 0x100, 1, 2, 3, 4]);
        registers.xpsr |= register << 12;
    });
    board
}

#[test]
fn restored_ici_continues_store_multiple() {
    // STM r0!, {r1, r2, r3, r4}
    let mut board = continued(&[0xC01E], 3);
    let registers = board.steps(1);
    let stored: Vec<u32> = (0..4).map(|word| board.word(RAM + 0x100 + 4 * word)).collect();
    assert_eq!((stored.as_slice(), registers.r[0]), (&[10, 11, 3, 4][..], RAM + 0x110));
    assert_eq!(registers.xpsr & 0x0600_FC00, 0);
}

#[test]
fn restored_ici_continues_push_and_pop() {
    // PUSH {r1, r2, r3}
    let mut board = continued(&[0xB40E], 2);
    assert_eq!(board.steps(1).r[13], STACK - 12);
    assert_eq!([board.word(STACK - 12), board.word(STACK - 8), board.word(STACK - 4)], [0, 2, 3]);

    // POP {r1, r4, pc}
    let mut board = continued(&[0xBD12], 15);
    board.bus.memory.poke(STACK - 4, Width::Word, CODE | 0x101);
    board.set(|registers| registers.r[13] = STACK - 12);
    let registers = board.steps(1);
    assert_eq!((registers.r[1], registers.r[4], registers.r[13]), (1, 4, STACK));
    assert_eq!(registers.r[15], CODE | 0x100);
}

/// Given ICI with a register that is not in the list, or with the first one. Then the instruction is UNPREDICTABLE.
#[test]
fn ici_that_fits_no_list_is_unpredictable() {
    for register in [1, 5] {
        let mut board = continued(&[0xC81E], register);
        assert_eq!(board.try_step(), Err(Stop::Unpredictable { address: CODE, word: 0xC81E }));
        assert_eq!(board.registers().xpsr >> 12 & 0xF, register);
    }
}

/// Given a continued load of which a word is refused. Then the frame of the fault has the ICI of before.
#[test]
fn fault_of_a_continued_load_keeps_ici() {
    let mut board = continued(&[0xC81E], 3);
    board.set(|registers| registers.r[0] = NOWHERE);
    board.step();
    assert_eq!(board.core.exception(), 3);
    assert_eq!(board.word(STACK - 4) >> 12 & 0xF, 3);
    assert_eq!(board.word(STACK - 32), NOWHERE);
}
