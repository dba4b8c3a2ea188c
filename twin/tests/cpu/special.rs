//! Special registers, stack pointers, and the rules of IT blocks (DDI 0403E B1.4, B5.2, A7.3).

use can_twin::cpu::Stop;

use crate::board::*;

/// MSR `register`, r2; MRS r3, `register`.
fn moved(register: u16, value: u32) -> u32 {
    let mut board = Board::new(&[0xF382, 0x8800 | register, 0xF3EF, 0x8300 | register]);
    board.set(|registers| registers.r[2] = value);
    board.steps(2).r[3]
}

#[test]
fn special_registers_keep_the_bits_that_are_there() {
    let cases = [
        ("APSR", 0, u32::MAX, N | Z | C | V | Q),
        ("PSP", 9, u32::MAX, 0xFFFF_FFFC),
        ("PRIMASK", 16, u32::MAX, 1),
        ("BASEPRI", 17, u32::MAX, 0xF0),
        ("FAULTMASK", 19, u32::MAX, 1),
        ("CONTROL", 20, 0b100, 0b100),
        ("IPSR", 5, u32::MAX, 0),
    ];
    for (name, register, value, expected) in cases {
        assert_eq!(moved(register, value), expected, "{name}");
    }
}

#[test]
fn basepri_max_only_raises_the_priority() {
    // MSR basepri, r2; MSR basepri_max, r3; MRS r4, basepri
    let program = [0xF382, 0x8811, 0xF383, 0x8812, 0xF3EF, 0x8411];
    for (old, new, expected) in [(0x40, 0x20, 0x20), (0x40, 0x60, 0x40), (0, 0x60, 0x60), (0x40, 0, 0x40)] {
        let mut board = Board::new(&program);
        board.set(|registers| (registers.r[2], registers.r[3]) = (old, new));
        assert_eq!(board.steps(3).r[4], expected, "{new:02X} over {old:02X}");
    }
}

#[test]
fn control_selects_the_stack_of_thread_mode() {
    // MSR psp, r2; MSR control, r3; MRS r4, msp; PUSH {r3}; MSR control, r5
    let mut board =
        Board::new(&[0xF382, 0x8809, 0xF383, 0x8814, 0xF3EF, 0x8408, 0xB408, 0xF385, 0x8814, NOP]);
    board.set(|registers| (registers.r[2], registers.r[3], registers.r[5]) = (RAM + 0x1003, 2, 0));
    let registers = board.steps(3);
    assert_eq!((registers.r[13], registers.r[4]), (RAM + 0x1000, STACK));
    assert_eq!(board.steps(1).r[13], RAM + 0xFFC);
    assert_eq!(board.word(RAM + 0xFFC), 2);
    let registers = board.steps(1);
    assert_eq!((registers.r[13], registers.other_sp), (STACK, RAM + 0xFFC));
}

#[test]
fn unprivileged_code_cannot_mask_interrupts() {
    // MSR control, r2; CPSID i; MSR basepri, r2; MRS r3, primask; MSR control, r4; MRS r5, control
    let mut board =
        Board::new(&[0xF382, 0x8814, 0xB672, 0xF382, 0x8811, 0xF3EF, 0x8310, 0xF384, 0x8814, 0xF3EF, 0x8514]);
    board.store(NVIC_ISER, 1);
    board.set(|registers| (registers.r[2], registers.r[3]) = (1, 7));
    let registers = board.steps(6);
    assert_eq!((registers.r[3], registers.r[5]), (0, 1));
    board.raise(0);
    assert_eq!(board.core.exception(), 16);
}

#[test]
fn sixteen_bit_instructions_in_an_it_block_keep_the_flags() {
    // CMP r0, r0; ITE EQ; ADDEQ r1, r1, #1; MOVNE r1, #7; ADDS r2, #0
    let mut board = Board::new(&[0x4280, 0xBF0C, 0x1C49, 0x2107, 0x3200]);
    let registers = board.steps(4);
    assert_eq!((registers.r[1], registers.xpsr & (Z | C)), (1, Z | C));
}

#[test]
fn instructions_that_no_it_block_may_hold_are_unpredictable() {
    // CBZ, IT, CPS, B cond, MOVS of low registers
    for half in [0xB108, 0xBF08, 0xB672, 0xD000, 0x0008] {
        let mut board = Board::new(&[0xBF08, half, NOP]);
        board.step();
        let stop = Stop::Unpredictable { address: CODE + 2, word: u32::from(half) };
        assert_eq!(board.try_step(), Err(stop), "{half:04X}");
    }
}

#[test]
fn instruction_with_a_failed_condition_has_no_effect() {
    // CMP r0, r0; ITT NE; LDRNE r1, [r2]; UDFNE
    let mut board = Board::new(&[0x4280, 0xBF1C, 0x6811, 0xDE00, NOP]);
    board.set(|registers| registers.r[2] = NOWHERE);
    let registers = board.steps(4);
    assert_eq!((registers.r[15], board.core.exception()), (CODE + 8, 0));
}

#[test]
fn table_branch_reads_its_offset() {
    // TBB [pc, r1]; TBH [pc, r1, LSL #1], each followed by its table
    let mut board = Board::new(&[0xE8DF, 0xF001, 0x0802]);
    board.set(|registers| registers.r[1] = 1);
    assert_eq!(board.steps(1).r[15], CODE + 4 + 2 * 8);
    let mut board = Board::new(&[0xE8DF, 0xF011, 0x0002, 0x0120]);
    board.set(|registers| registers.r[1] = 1);
    assert_eq!(board.steps(1).r[15], CODE + 4 + 2 * 0x120);
}

#[test]
fn exclusive_stores_of_every_size_need_their_load() {
    // LDREXB r2, [r0]; STREXB r3, r1, [r0]; LDREXH r2, [r0]; CLREX; STREXH r4, r1, [r0]
    let mut board =
        Board::new(&[0xE8D0, 0x2F4F, 0xE8C0, 0x1F43, 0xE8D0, 0x2F5F, 0xF3BF, 0x8F2F, 0xE8C0, 0x1F54]);
    board.set_r0_r1(RAM + 0x10, 0x1234_5678);
    let registers = board.steps(5);
    assert_eq!((registers.r[3], registers.r[4], board.word(RAM + 0x10)), (0, 1, 0x78));
}
