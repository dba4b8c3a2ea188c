//! The flash patch and breakpoint unit (DDI 0403E C1.11, DDI 0439B 7.3). Neither Unicorn nor QEMU models it.

use can_twin::cpu::{Stop, Width};

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

/// Data in flash that is erased.
const AT: u32 = FLASH + 0x200;

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
    board.bus.memory.poke(CODE_WORD, Width::Word, 0xBF00_0077);
    assert_eq!(restart(&mut board, 2), 0x77);
}

/// Given a replaced word of flash, then words, half-words, bytes and blocks have its parts. An unaligned word has those of flash.
#[test]
fn replaced_data_are_loaded() {
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

/// Given all comparators, then each takes the word of its own place.
#[test]
fn each_comparator_has_its_word() {
    let program: [u16; 12] = std::array::from_fn(|n| movs_r0(n as u16));
    let mut board = Board::new(&program);
    board.bus.memory.poke_words(TABLE, (0..8).map(|n| 0x2010_2020 + 0x1_0001 * n));
    board.store(FP_REMAP, TABLE);
    for n in 0..6 {
        board.store(FP_COMP0 + 4 * n, (CODE + 4 * n) | 1);
    }
    for n in 0..2 {
        board.store(FP_COMP6 + 4 * n, (AT + 4 * n) | 1);
    }
    board.store(FP_CTRL, ON);
    for n in 0..6 {
        let (first, second) = (restart(&mut board, 2 * n + 1), restart(&mut board, 2 * n + 2));
        assert_eq!((first, second), (0x20 + n as u32, 0x10 + n as u32), "{n}");
    }
    assert_eq!([AT, AT + 4, AT + 8].map(|at| board.load(at)), [0x2016_2026, 0x2017_2027, u32::MAX]);
}

#[test]
fn instructions_and_data_have_their_own_comparators() {
    let mut board = Board::new(&[movs_r0(1), NOP]);
    board.bus.memory.poke_words(TABLE, [0x2012_2011; 8]);
    board.store(FP_REMAP, TABLE);
    board.store(FP_COMP0, AT | 1);
    board.store(FP_COMP6, CODE | 1);
    board.store(FP_CTRL, ON);
    assert_eq!((restart(&mut board, 1), board.load(AT)), (1, u32::MAX));
    assert_eq!(board.load(CODE), 0x2012_2011);
}

/// Given instructions that ran with and without replacement, when a comparator is moved, disabled or hit by an upset, then the next
/// run has what it says.
#[test]
fn comparator_change_reaches_decoded_instructions() {
    let mut board = Board::new(&[movs_r0(1), NOP, movs_r0(2), NOP]);
    let both = |board: &mut Board| (restart(board, 1), restart(board, 3));
    assert_eq!(both(&mut board), (1, 2));
    replace(&mut board, CODE, 0xBF00_2011);
    assert_eq!(both(&mut board), (0x11, 2));
    board.store(FP_COMP0, (CODE + 4) | 1);
    assert_eq!(both(&mut board), (1, 0x11));
    board.store(FP_COMP0, CODE + 4);
    assert_eq!(both(&mut board), (1, 2));
    for expected in [0x11, 2] {
        assert!(board.core.flip_system(FP_COMP0, 0));
        assert_eq!(both(&mut board), (1, expected));
    }
}

#[test]
fn control_without_its_key_is_ignored() {
    let mut board = Board::new(&[movs_r0(1), NOP]);
    replace(&mut board, CODE, 0xBF00_2011);
    board.store(FP_CTRL, 0);
    assert_eq!((restart(&mut board, 1), board.load(FP_CTRL)), (0x11, 0x261));
}

/// Given a replaced word of flash, then each kind of load has it. A load that is not aligned has the bytes of flash.
#[test]
fn each_kind_of_load_is_replaced() {
    const WORD: u32 = 0x4433_2211;
    let loads: [(&str, &[u16], u32, u32); 8] = [
        ("LDR literal", &[0x4A00, NOP, WORD as u16, (WORD >> 16) as u16], 0, 0x8877_6655),
        ("LDRD r2, r3", &[0xE9D0, 0x2300], AT, WORD),
        ("LDREX", &[0xE850, 0x2F00], AT, WORD),
        ("LDRSH", &[0xF9B0, 0x2002], AT, 0x4433),
        ("LDR post-indexed", &[0xF850, 0x2B04], AT, WORD),
        ("LDMDB r0, {r1, r2}", &[0xE910, 0x0006], AT + 4, WORD),
        ("LDRH, unaligned", &[0x8802], AT + 1, 0xFFFF),
        ("LDR, unaligned", &[LDR], AT - 1, u32::MAX),
    ];
    for (name, load, address, expected) in loads {
        let mut board = Board::new(load);
        let (place, word) = if address == 0 { (CODE + 4, expected) } else { (AT, WORD) };
        replace(&mut board, place, word);
        board.set_r0_r1(address, 0);
        assert_eq!(board.steps(1).r[2], expected, "{name}");
    }
    // POP {r2}; VLDR s0, [r0]
    let mut board = Board::new(&[0xBC04, 0xED90, 0x0A00]);
    board.store(CPACR, FPU_FOR_ALL);
    replace(&mut board, AT, WORD);
    board.set(|registers| (registers.r[0], registers.r[13]) = (AT, AT));
    let registers = board.steps(2);
    assert_eq!((registers.r[2], registers.s[0]), (WORD, WORD));
}

/// Given an MPU that refuses the words in RAM, then they replace those of flash. Given one that refuses the word of flash, then its
/// load is refused.
#[test]
fn protection_is_that_of_the_original_address() {
    // 1 KiB without access, execute-never; 32 bytes without access.
    for (region, size, fault) in [(RAM, 9 << 1, false), (AT, 4 << 1, true)] {
        let mut board = Board::new(&[movs_r0(1), NOP, LDR]);
        board.store(SHCSR, ALL_FAULTS);
        replace(&mut board, CODE, 0xBF00_2011);
        board.store(FP_COMP6, AT | 1);
        board.store(MPU_RBAR, region | 1 << 4);
        board.store(MPU_RASR, 1 << 28 | size | 1);
        board.store(MPU_CTRL, 0b101);
        assert_eq!(restart(&mut board, 1), 0x11);
        board.set(|registers| (registers.r[0], registers.r[15]) = (AT, CODE + 4));
        let loaded = board.steps(1).r[2];
        assert_eq!((board.core.exception(), loaded), if fault { (4, 0) } else { (0, 0xBF00_2011) });
        assert!(!fault || board.load(MMFAR) == AT);
    }
}

/// Given a debugger and a breakpoint, then the core stops before its instruction. At the second half of an instruction it is
/// UNPREDICTABLE.
#[test]
fn breakpoint_stops_at_an_instruction() {
    let mut board = Board::new(&[movs_r0(1), 0xF240, 0x0055]);
    board.core.attach_debugger();
    board.store(FP_CTRL, ON);
    board.store(FP_COMP0, CODE | BREAKPOINT | 1);
    assert_eq!(board.try_step(), Err(Stop::Breakpoint { address: CODE, immediate: 0 }));
    board.store(FP_COMP0, (CODE + 4) | BREAKPOINT | 1);
    board.step();
    assert_eq!(board.try_step(), Err(Stop::Unpredictable { address: CODE + 2, word: 0xF240_BE00 }));
}

/// Given an unprivileged load under protection, then it has the replaced word.
#[test]
fn unprivileged_load_is_replaced() {
    // LDRT r2, [r0]
    let mut board = Board::new(&[0xF850, 0x2E00]);
    replace(&mut board, AT, 0x4433_2211);
    board.store(MPU_RBAR, AT | 1 << 4);
    board.store(MPU_RASR, 0b011 << 24 | 4 << 1 | 1);
    board.store(MPU_CTRL, 0b101);
    board.set_r0_r1(AT, 0);
    assert_eq!(board.steps(1).r[2], 0x4433_2211);
}

#[test]
fn unpredictable_replacement_is_reported() {
    let mut board = Board::new(&[NOP, NOP]);
    // LDRD r2, r2, [r0]
    replace(&mut board, CODE, 0x2200_E9D0);
    assert_eq!(board.try_step(), Err(Stop::Unpredictable { address: CODE, word: 0xE9D0_2200 }));
}
