//! Faults, escalation, lock-up and stops (DDI 0403E B1.5.14, B1.5.15).

use crate::board::{Board, CODE, FLASH, HANDLERS, PERIPHERAL, RAM, STACK};
use twin_core::{Stop, Width};

const CCR: u32 = 0xE000_ED14;
const SHCSR: u32 = 0xE000_ED24;
const CFSR: u32 = 0xE000_ED28;
const HFSR: u32 = 0xE000_ED2C;
const DFSR: u32 = 0xE000_ED30;
const MMFAR: u32 = 0xE000_ED34;
const BFAR: u32 = 0xE000_ED38;
const VTOR: u32 = 0xE000_ED08;
const DEMCR: u32 = 0xE000_EDFC;
const ALL_FAULTS: u32 = 7 << 16;
const NOP: u16 = 0xBF00;
const FORCED: u32 = 1 << 30;
const VECTTBL: u32 = 1 << 1;
const DEBUGEVT: u32 = 1 << 31;

/// Runs the first instruction of a program with MemManage, BusFault and UsageFault enabled. r0 is given, r1 is 4.
fn fault(program: &[u16], r0: u32, ccr: u32) -> Board {
    let mut board = Board::new(program);
    board.store(SHCSR, ALL_FAULTS);
    board.store(CCR, 0x200 | ccr);
    board.set(|registers| (registers.r[0], registers.r[1]) = (r0, 4));
    board.step();
    board
}

/// Exception, CFSR, stacked return address.
fn outcome(mut board: Board) -> (u16, u32, u32) {
    (board.core.exception(), board.load(CFSR), board.word(STACK - 8))
}

#[test]
fn usage_faults_stack_the_instruction_and_say_why() {
    let cases: [(&str, &[u16], u32, u32, u32); 8] = [
        ("UDF", &[0xDE00], 0, 0, 1 << 16),
        ("a gap of the 32-bit space", &[0xF7F0, 0xA000], 0, 0, 1 << 16),
        ("MCR p15", &[0xEE00, 0x0F10], 0, 0, 1 << 19),
        ("VADD with the FPU off", &[0xEE30, 0x0A81], 0, 0, 1 << 19),
        ("LDRD unaligned", &[0xE9D0, 0x2300], RAM + 2, 0, 1 << 24),
        ("LDM unaligned", &[0xC806], RAM + 1, 0, 1 << 24),
        ("LDR unaligned with UNALIGN_TRP", &[0x6802], RAM + 1, 1 << 3, 1 << 24),
        ("UDIV by zero with DIV_0_TRP", &[0xFBB1, 0xF2F0], 0, 1 << 4, 1 << 25),
    ];
    for (name, program, r0, ccr, bits) in cases {
        assert_eq!(outcome(fault(program, r0, ccr)), (6, bits, CODE), "{name}");
    }
}

#[test]
fn branch_to_an_even_address_faults_at_its_target() {
    let mut board = fault(&[0x4700], CODE + 0x20, 0); // BX r0
    assert_eq!(board.core.exception(), 0);
    board.step();
    assert_eq!(outcome(board), (6, 1 << 17, CODE + 0x20));
}

#[test]
fn unaligned_access_goes_bytewise() {
    let mut board = Board::new(&[0x6802, 0x6001]); // LDR r2, [r0]; STR r1, [r0]
    board.memory.poke(RAM, Width::Word, 0x4433_2211);
    board.memory.poke(RAM + 4, Width::Word, 0x8877_6655);
    board.set(|registers| (registers.r[0], registers.r[1]) = (RAM + 3, 0xDDCC_BBAA));
    assert_eq!(board.step().cycles, 2);
    assert_eq!(board.registers().r[2], 0x7766_5544);
    assert_eq!(board.memory.accesses.len(), 2 + 4);
    board.step();
    assert_eq!((board.word(RAM), board.word(RAM + 4)), (0xAA33_2211, 0x88DD_CCBB));
}

#[test]
fn refused_accesses_raise_bus_faults_with_their_address() {
    let mut board = fault(&[0x6802], 0x6000_0000, 0); // LDR r2, [r0]
    assert_eq!(board.load(BFAR), 0x6000_0000);
    assert_eq!(outcome(board), (5, 1 << 9 | 1 << 15, CODE));

    let mut board = fault(&[0x6001], FLASH, 0); // STR r1, [r0]
    assert_eq!(board.load(BFAR), FLASH);
    assert_eq!(outcome(board), (5, 1 << 9 | 1 << 15, CODE));

    let mut board = fault(&[0x4700], 0x6000_0001, 0); // BX r0
    board.step();
    assert_eq!(outcome(board), (5, 1 << 8, 0x6000_0000));
}

#[test]
fn code_does_not_run_from_peripherals() {
    let mut board = fault(&[0x4700], PERIPHERAL | 1, 0); // BX r0
    board.step();
    assert_eq!(outcome(board), (4, 1, PERIPHERAL));
}

#[test]
fn base_register_survives_a_fault_with_write_back() {
    // LDR r2, [r0], #4; LDM r0!, {r1, r2}
    for program in [&[0xF850_u16, 0x2B04][..], &[0xC806]] {
        let board = fault(program, RAM + 0x4000 - if program.len() == 1 { 4 } else { 0 }, 0);
        assert_eq!(board.core.exception(), 5);
        assert!(board.registers().r[0] >= RAM + 0x3FFC);
        assert_eq!(board.registers().r[1], 4);
    }
}

#[test]
fn fault_that_is_not_enabled_becomes_hard_fault() {
    let mut board = Board::new(&[0xDE00]);
    board.step();
    assert_eq!((board.load(HFSR), board.load(CFSR)), (FORCED, 1 << 16));
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (3, CODE));
    board.store(HFSR, FORCED);
    board.store(CFSR, u32::MAX);
    assert_eq!((board.load(HFSR), board.load(CFSR)), (0, 0), "written ones clear");
}

#[test]
fn fault_in_the_usage_handler_becomes_hard_fault() {
    let mut board = fault(&[0xDE00], 0, 0);
    board.handler(6, &[0xDE00]);
    board.core.invalidate(HANDLERS..HANDLERS + 0x400);
    board.step();
    assert_eq!(board.core.exception(), 3);
    assert_eq!(board.registers().r[14], 0xFFFF_FFF1);
}

#[test]
fn fault_in_hard_fault_locks_up_until_nmi() {
    let mut board = Board::new(&[0xDE00]);
    board.handler(3, &[0xDE00]);
    board.steps(2);
    assert!(board.core.is_locked_up());
    assert_eq!(board.registers().r[15], 0xFFFF_FFFE);
    assert_eq!(board.step().cycles, 1);
    board.core.set_irq(0, true);
    board.step();
    assert!(board.core.is_locked_up());
    board.core.set_nmi(true);
    board.step();
    assert!(!board.core.is_locked_up());
    assert_eq!((board.core.exception(), board.word(board.registers().r[13] + 24)), (2, 0xFFFF_FFFE));
}

#[test]
fn reset_vector_that_cannot_be_read_locks_up() {
    let mut board = Board::new(&[NOP]);
    board.store(VTOR, 0x6000_0000);
    board.core.set_irq(0, true);
    board.store(0xE000_E100, 1);
    board.step();
    assert!(board.core.is_locked_up(), "neither the vector nor that of HardFault answers");
    board.core.reset();
    board.core.set_irq(0, false);
    board.step();
    assert!(!board.core.is_locked_up(), "VTOR is back at the flash");
}

#[test]
fn vector_that_cannot_be_read_raises_hard_fault() {
    let mut board = Board::new(&[NOP]);
    // The table begins 64 bytes before the end of RAM: HardFault has a vector, interrupts have none.
    board.store(VTOR, RAM + 0x3F80);
    board.memory.poke(RAM + 0x3F80 + 12, Width::Word, HANDLERS | 1);
    board.memory.poke(RAM + 0x3F80 + 4 * 31, Width::Word, HANDLERS | 1);
    board.store(0xE000_E100, 1 << 16);
    board.core.set_irq(16, true);
    board.step();
    assert_eq!((board.core.exception(), board.load(HFSR)), (3, VECTTBL));
}

#[test]
fn refused_stacking_is_taken_instead_of_the_interrupt() {
    let mut board = Board::new(&[NOP]);
    board.store(SHCSR, ALL_FAULTS);
    board.store(0xE000_E100, 1);
    board.store(0xE000_E400, 0x80);
    board.set(|registers| registers.r[13] = 0x6000_0020);
    board.core.set_irq(0, true);
    board.step();
    assert_eq!(board.core.exception(), 5);
    board.set(|registers| registers.r[13] = STACK);
    assert_eq!(board.load(CFSR), 1 << 12, "STKERR");
    assert_eq!(board.load(0xE000_E200), 1, "the interrupt is still pending");
}

/// Given an unaligned access whose last bytes have no memory. When it is refused. Then BFAR has the first address without memory.
#[test]
fn unaligned_access_reports_where_memory_ends() {
    // LDR r2, [r0]; STRH r1, [r0]
    for (code, before) in [(0x6802, 2), (0x8001, 1)] {
        let mut board = fault(&[code], RAM + 0x4000 - before, 0);
        assert_eq!((board.core.exception(), board.load(BFAR)), (5, RAM + 0x4000), "{code:04X}");
    }
}

/// Given a stack without memory. When an access faults. Then its handler runs although the stacking for it fails as well.
#[test]
fn refused_stacking_for_the_same_fault_runs_its_handler() {
    // LDR r2, [r0], with BusFault enabled, and disabled so that it becomes HardFault
    for (enabled, exception, hfsr) in [(ALL_FAULTS, 5, 0), (0, 3, FORCED)] {
        let mut board = Board::new(&[0x6802]);
        board.store(SHCSR, enabled);
        board.set(|registers| (registers.r[0], registers.r[13]) = (0x6000_0000, 0x6000_0100));
        board.step();
        assert!(!board.core.is_locked_up());
        assert_eq!(board.core.exception(), exception);
        board.set(|registers| registers.r[13] = STACK);
        assert_eq!(board.load(CFSR), 1 << 9 | 1 << 12 | 1 << 15, "PRECISERR, STKERR, BFARVALID");
        assert_eq!((board.load(HFSR), board.load(BFAR)), (hfsr, 0x6000_0000));
        assert_eq!(board.load(SHCSR) >> 12 & 7, 0, "nothing is pending");
    }
}

#[test]
fn refused_unstacking_enters_bus_fault() {
    let mut board = Board::new(&[NOP]);
    board.store(SHCSR, ALL_FAULTS);
    board.store(0xE000_E100, 1);
    board.handler(16, &[0x4770]);
    board.core.set_irq(0, true);
    board.step();
    board.core.set_irq(0, false);
    board.set(|registers| registers.r[13] = 0x6000_0000);
    board.step();
    assert_eq!((board.core.exception(), board.registers().r[13]), (5, 0x6000_0000));
    board.set(|registers| registers.r[13] = STACK);
    assert_eq!(board.load(CFSR), 1 << 11, "UNSTKERR");
}

#[test]
fn breakpoint_halts_with_a_debugger_and_faults_without() {
    let mut board = Board::new(&[0xBE03]);
    let mut debugged = board.clone();
    debugged.core.attach_debugger();
    let stop = Stop::Breakpoint { address: CODE, immediate: 3 };
    assert_eq!(debugged.try_step(), Err(stop));
    assert_eq!(debugged.try_step(), Err(stop));
    assert_eq!(debugged.registers().r[15], CODE);

    board.step();
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (3, CODE));
    assert_eq!((board.load(HFSR), board.load(DFSR)), (DEBUGEVT, 1 << 1));

    let mut monitored = Board::new(&[0xBE03]);
    monitored.store(DEMCR, 1 << 16);
    monitored.step();
    assert_eq!(monitored.core.exception(), 12);
}

#[test]
fn unprivileged_code_has_no_system_registers() {
    let mut board = Board::new(&[0xF382, 0x8814, 0x6802, NOP]); // MSR control, r2; LDR r2, [r0]
    board.store(SHCSR, ALL_FAULTS);
    board.set(|registers| (registers.r[0], registers.r[2]) = (CFSR, 1));
    board.steps(2);
    assert_eq!(board.core.exception(), 5);
    assert_eq!(board.load(BFAR), CFSR);
}

#[test]
fn register_that_is_not_modelled_stops_with_its_address() {
    let mut board = Board::new(&[0x6802, 0x6001]);
    board.set(|registers| registers.r[0] = 0xE000_2000);
    let stop = |write, instruction| Err(Stop::Unmodelled { instruction, address: 0xE000_2000, write });
    assert_eq!(board.try_step(), stop(false, CODE));
    board.set(|registers| registers.r[15] = CODE + 2);
    assert_eq!(board.try_step(), stop(true, CODE + 2));
}

#[test]
fn memory_fault_address_is_kept_by_the_program() {
    let mut board = Board::new(&[NOP]);
    board.store(MMFAR, 0x1234_5678);
    assert_eq!(board.load(MMFAR), 0x1234_5678);
}

#[test]
fn branch_in_the_middle_of_an_it_block_is_unpredictable() {
    let mut board = Board::new(&[0xBF04, 0xE7FE, NOP]); // ITT EQ; B .; NOP
    board.step();
    assert_eq!(board.try_step(), Err(Stop::Unpredictable { address: CODE + 2, word: 0xE7FE }));
}
