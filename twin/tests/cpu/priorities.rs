//! Four bits of priority and PRIGROUP (DDI 0403E B1.5.4). QEMU has eight bits, so these are written from the manual.

use crate::board::*;

#[test]
fn priorities_have_four_bits() {
    let mut board = Board::new(&[NOP]);
    for register in [NVIC_IPR, NVIC_IPR + 92, SHPR1, SHPR2, SHPR3] {
        board.store(register, u32::MAX);
    }
    assert_eq!(board.load(NVIC_IPR), 0xF0F0_F0F0);
    assert_eq!(board.load(NVIC_IPR + 92), 0xF0F0_F0F0);
    assert_eq!(board.load(NVIC_IPR + 96), 0, "interrupt 96 was not written");
    board.store(NVIC_IPR + 96, u32::MAX);
    assert_eq!(board.load(NVIC_IPR + 96), 0x0000_00F0, "there are 97");
}

/// Given interrupt 0 at FFh, which is F0h. When interrupt 1 at F1h becomes pending. Then it waits: the low bits do not exist.
#[test]
fn low_bits_of_a_priority_do_not_order() {
    let mut board = Board::with_interrupts(&[NOP], &[0xFF, 0xF1]);
    board.store(NVIC_ISPR, 0b11);
    board.step();
    assert_eq!(board.core.exception(), 16);
}

/// Given each PRIGROUP. When an interrupt whose priority differs in one bit becomes pending. Then it preempts if the bit is in the group.
#[test]
fn prigroup_splits_the_priority() {
    // Bits of the group among bits 7:4, by PRIGROUP (table B1-5, with 4 bits).
    let groups = [0xF0, 0xF0, 0xF0, 0xF0, 0xE0, 0xC0, 0x80, 0x00];
    for (prigroup, group) in (0..).zip(groups) {
        for bit in [0x80_u8, 0x40, 0x20, 0x10] {
            let mut board = Board::with_interrupts(&[NOP], &[bit, 0]);
            board.store(AIRCR, 0x05FA_0000 | prigroup << 8);
            assert_eq!(board.load(AIRCR), 0xFA05_0000 | prigroup << 8);
            board.store(NVIC_ISPR, 0b01);
            board.step();
            board.store(NVIC_ISPR, 0b10);
            board.step();
            let expected = if group & bit != 0 { 17 } else { 16 };
            assert_eq!(board.core.exception(), expected, "PRIGROUP {prigroup}, bit {bit:02X}");
        }
    }
}

#[test]
fn aircr_without_its_key_changes_nothing() {
    let mut board = Board::new(&[NOP]);
    board.store(AIRCR, 0x05FB_0304);
    assert_eq!(board.load(AIRCR), 0xFA05_0000);
}

/// Given two bits of group. When BASEPRI is set to a value with other bits. Then they are not compared.
#[test]
fn basepri_masks_whole_groups() {
    // MSR basepri, r2; NOP
    let mut board = Board::with_interrupts(&[0xF382, 0x8811, NOP, NOP], &[0x40, 0x30]);
    board.store(AIRCR, 0x05FA_0500);
    board.set(|registers| registers.r[2] = 0x70);
    board.step();
    board.raise(0);
    assert_eq!(board.core.exception(), 0, "40h is in the group of 70h");
    board.raise(1);
    assert_eq!(board.core.exception(), 17);
}
