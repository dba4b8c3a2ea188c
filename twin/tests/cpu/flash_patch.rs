//! The flash patch and breakpoint unit (DDI 0403E C1.11, DDI 0439B 7.3). Neither Unicorn nor QEMU models it.

use can_twin::cpu::Width;

use crate::board::*;

const FP_CTRL: u32 = 0xE000_2000;
const FP_REMAP: u32 = 0xE000_2004;
const FP_COMP0: u32 = 0xE000_2008;
const FP_COMP6: u32 = 0xE000_2020;
/// KEY and ENABLE.
const ON: u32 = 0b11;
const KEY: u32 = 0b10;
/// REPLACE: BKPT in place of both half-words.
const BREAKPOINT: u32 = 0b11 << 30;

/// Words of the comparators 0 and 6.
const TABLE: u32 = RAM + 0x100;
const CODE_WORD: u32 = TABLE;
const DATA_WORD: u32 = TABLE + 4 * 6;

/// MOVS r0, #n.
const fn movs_r0(n: u16) -> u16 {
    0x2000 | n
}

/// Replaces a word for instructions and for data.
fn replace(board: &mut Board, address: u32, word: u32) {
    for place in [CODE_WORD, DATA_WORD] {
        board.bus.memory.poke(place, Width::Word, word);
    }
    board.store(FP_REMAP, TABLE);
    board.store(FP_COMP0, address | 1);
    board.store(FP_COMP6, address | 1);
    board.store(FP_CTRL, ON);
}

/// Runs some steps from the beginning.
fn restart(board: &mut Board, steps: usize) -> u32 {
    board.set(|registers| registers.r[15] = CODE);
    board.steps(steps).r[0]
}

/// Given instructions that have run before, when the unit replaces them, then the others run, from the next step on; also after a change
/// of the word in RAM. Those in flash run again without the unit.
#[test]
fn replaced_instructions_run() {
    let mut board = Board::new(&[movs_r0(1), movs_r0(2), movs_r0(3), movs_r0(4)]);
    assert_eq!(restart(&mut board, 2), 2);
    replace(&mut board, CODE, 0x2012_2011);
    assert_eq!(restart(&mut board, 1), 0x11);
    assert_eq!(restart(&mut board, 2), 0x12);
    assert_eq!(restart(&mut board, 3), 3, "the next word stays");
    board.bus.memory.poke(CODE_WORD, Width::Word, 0x2014_2013);
    assert_eq!(restart(&mut board, 2), 0x14);
    board.store(FP_CTRL, KEY);
    assert_eq!(restart(&mut board, 2), 2);
}

#[test]
fn second_half_of_an_instruction_can_be_replaced() {
    // MOVW r0, #55h across two words.
    let mut board = Board::new(&[NOP, 0xF240, 0x0055, NOP]);
    assert_eq!(restart(&mut board, 2), 0x55);
    replace(&mut board, CODE + 4, 0xBF00_0066);
    assert_eq!(restart(&mut board, 2), 0x66);
}

/// Given a replaced word of flash, then words, half-words, bytes and blocks have its parts. An unaligned word has those of flash.
#[test]
fn replaced_data_are_loaded() {
    const AT: u32 = FLASH + 0x200;
    // LDR, LDRH, LDRB to r2; LDM to r1 and r2.
    let loads = [
        (0x6802, AT, 0x4433_2211),
        (0x8802, AT + 2, 0x4433),
        (0x7802, AT + 1, 0x22),
        (0xC806, AT - 4, 0x4433_2211),
    ];
    for (load, address, expected) in loads {
        let mut board = Board::new(&[load]);
        replace(&mut board, AT, 0x4433_2211);
        board.set_r0_r1(address, 0);
        assert_eq!(board.steps(1).r[2], expected, "{load:04X}");
    }
    let mut board = Board::new(&[LDR]);
    replace(&mut board, AT, 0x4433_2211);
    board.set_r0_r1(AT + 2, 0);
    assert_eq!(board.steps(1).r[2], u32::MAX);
}

/// Given a replaced entry of the vector table, then the exception runs the handler of the one in flash.
#[test]
fn vectors_are_not_replaced() {
    let mut board = Board::with_interrupts(&[NOP], &[0]);
    replace(&mut board, FLASH + 4 * 16, CODE | 1);
    board.pulse();
    assert_eq!(board.core.pc(), HANDLERS + 32 * 16);
}

/// Given an enabled unit, then a reset of the system keeps it.
#[test]
fn unit_outlives_a_reset() {
    let mut board = Board::new(&[movs_r0(1), NOP]);
    replace(&mut board, CODE, 0xBF00_2011);
    board.core.reset();
    board.step();
    assert_eq!(board.load(FP_CTRL), 0x261);
    assert_eq!(restart(&mut board, 1), 0x11);
}

/// Given a breakpoint on an instruction, then a core without debugger takes it as a HardFault.
#[test]
fn breakpoint_is_taken() {
    let mut board = Board::new(&[movs_r0(1)]);
    board.store(FP_COMP0, CODE | BREAKPOINT | 1);
    board.store(FP_CTRL, ON);
    board.step();
    assert_eq!((board.core.exception(), board.load(HFSR)), (3, DEBUGEVT));
}
