//! Faults, escalation, lock-up and stops (DDI 0403E B1.5.14, B1.5.15).

use can_twin::cpu::{Stop, Width};

use crate::board::*;

/// Runs the first instruction of a program with MemManage, BusFault and UsageFault enabled. r0 is given, r1 is 4.
fn fault(program: &[u16], r0: u32, ccr: u32) -> Board {
    let mut board = Board::new(program);
    board.store(SHCSR, ALL_FAULTS);
    board.store(CCR, 0x200 | ccr);
    board.set_r0_r1(r0, 4);
    board.step();
    board
}

/// Name, program, r0, bits of CCR; then exception, CFSR and stacked return address.
type Case = (&'static str, &'static [u16], u32, u32, (u16, u32, u32));

/// A jump by BX R0 faults at its target, everything else where it stands. Where BFAR is valid it has the address in r0.
#[test]
fn faults_stack_their_instruction_and_say_why() {
    let refused = BFARVALID | 1 << 9;
    let cases: [Case; 13] = [
        ("UDF", &[UDF], 0, 0, (6, UNDEFINSTR, CODE)),
        ("a gap of the 32-bit space", &[0xF7F0, 0xA000], 0, 0, (6, UNDEFINSTR, CODE)),
        ("MCR p15", &[0xEE00, 0x0F10], 0, 0, (6, 1 << 19, CODE)),
        ("VADD with the FPU off", &[0xEE30, 0x0A81], 0, 0, (6, 1 << 19, CODE)),
        ("LDRD unaligned", &[0xE9D0, 0x2300], RAM + 2, 0, (6, 1 << 24, CODE)),
        ("LDM unaligned", &[0xC806], RAM + 1, 0, (6, 1 << 24, CODE)),
        ("LDR unaligned with UNALIGN_TRP", &[LDR], RAM + 1, 1 << 3, (6, 1 << 24, CODE)),
        ("UDIV by zero with DIV_0_TRP", &[0xFBB1, 0xF2F0], 0, 1 << 4, (6, 1 << 25, CODE)),
        ("BX to an even address", &[BX_R0], CODE + 0x20, 0, (6, 1 << 17, CODE + 0x20)),
        ("LDR from nowhere", &[LDR], NOWHERE, 0, (5, refused, CODE)),
        ("STR to flash", &[STR], FLASH, 0, (5, refused, CODE)),
        ("BX to nowhere", &[BX_R0], NOWHERE | 1, 0, (5, 1 << 8, NOWHERE)),
        ("BX to a peripheral", &[BX_R0], PERIPHERAL | 1, 0, (4, 1, PERIPHERAL)),
    ];
    for (name, program, r0, ccr, expected) in cases {
        let mut board = fault(program, r0, ccr);
        if program == [BX_R0] {
            assert_eq!(board.core.exception(), 0, "{name}");
            board.step();
        }
        if board.load(CFSR) & BFARVALID != 0 {
            assert_eq!(board.load(BFAR), r0, "{name}");
        }
        let outcome = (board.core.exception(), board.load(CFSR), board.word(STACK - 8));
        assert_eq!(outcome, expected, "{name}");
    }
}

#[test]
fn unaligned_access_goes_bytewise() {
    let mut board = Board::new(&[LDR, STR]);
    board.bus.memory.poke_words(RAM, [0x4433_2211, 0x8877_6655]);
    board.set_r0_r1(RAM + 3, 0xDDCC_BBAA);
    assert_eq!(board.step().cycles, 2);
    assert_eq!(board.registers().r[2], 0x7766_5544);
    assert_eq!(board.bus.accesses.len(), 2 + 4);
    board.step();
    assert_eq!((board.word(RAM), board.word(RAM + 4)), (0xAA33_2211, 0x88DD_CCBB));
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
    let mut board = Board::new(&[UDF]);
    board.step();
    assert_eq!((board.load(HFSR), board.load(CFSR)), (FORCED, 1 << 16));
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (3, CODE));
    board.store(HFSR, FORCED);
    board.store(CFSR, u32::MAX);
    assert_eq!((board.load(HFSR), board.load(CFSR)), (0, 0), "written ones clear");
}

#[test]
fn fault_in_the_usage_handler_becomes_hard_fault() {
    let mut board = fault(&[UDF], 0, 0);
    board.handler(6, &[UDF]);
    board.core.invalidate(HANDLERS..HANDLERS + 0x400);
    board.step();
    assert_eq!(board.core.exception(), 3);
    assert_eq!(board.registers().r[14], 0xFFFF_FFF1);
}

#[test]
fn fault_in_hard_fault_locks_up_until_nmi() {
    let mut board = Board::new(&[UDF]);
    board.handler(3, &[UDF]);
    board.steps(2);
    assert!(board.core.is_locked_up());
    assert_eq!(board.registers().r[15], 0xFFFF_FFFE);
    assert_eq!(board.step().cycles, 1);
    board.raise(0);
    assert!(board.core.is_locked_up());
    board.core.set_nmi(true);
    board.step();
    assert!(!board.core.is_locked_up());
    assert_eq!((board.core.exception(), board.word(board.registers().r[13] + 24)), (2, 0xFFFF_FFFE));
}

#[test]
fn reset_vector_that_cannot_be_read_locks_up() {
    let mut board = Board::new(&[NOP]);
    board.store(VTOR, NOWHERE);
    board.core.set_irq(0, true);
    board.store(NVIC_ISER, 1);
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
    board.bus.memory.poke(RAM + 0x3F80 + 12, Width::Word, HANDLERS | 1);
    board.bus.memory.poke(RAM + 0x3F80 + 4 * 31, Width::Word, HANDLERS | 1);
    board.store(NVIC_ISER, 1 << 16);
    board.raise(16);
    assert_eq!((board.core.exception(), board.load(HFSR)), (3, VECTTBL));
}

#[test]
fn refused_stacking_is_taken_instead_of_the_interrupt() {
    let mut board = Board::with_interrupts(&[NOP], &[0x80]);
    board.store(SHCSR, ALL_FAULTS);
    board.set(|registers| registers.r[13] = 0x6000_0020);
    board.raise(0);
    assert_eq!(board.core.exception(), 5);
    board.set(|registers| registers.r[13] = STACK);
    assert_eq!(board.load(CFSR), 1 << 12, "STKERR");
    assert_eq!(board.load(NVIC_ISPR), 1, "the interrupt is still pending");
}

/// Given an unaligned access whose last bytes have no memory. When it is refused. Then BFAR has the first address without memory.
#[test]
fn unaligned_access_reports_where_memory_ends() {
    // LDR r2, [r0]; STRH r1, [r0]
    for (code, before) in [(LDR, 2), (0x8001, 1)] {
        let mut board = fault(&[code], RAM + 0x4000 - before, 0);
        assert_eq!((board.core.exception(), board.load(BFAR)), (5, RAM + 0x4000), "{code:04X}");
    }
}

/// Given a stack without memory. When an access faults. Then its handler runs although the stacking for it fails as well.
#[test]
fn refused_stacking_for_the_same_fault_runs_its_handler() {
    // LDR r2, [r0], with BusFault enabled, and disabled so that it becomes HardFault
    for (enabled, exception, hfsr) in [(ALL_FAULTS, 5, 0), (0, 3, FORCED)] {
        let mut board = Board::new(&[LDR]);
        board.store(SHCSR, enabled);
        board.set(|registers| (registers.r[0], registers.r[13]) = (NOWHERE, 0x6000_0100));
        board.step();
        assert!(!board.core.is_locked_up());
        assert_eq!(board.core.exception(), exception);
        board.set(|registers| registers.r[13] = STACK);
        assert_eq!(board.load(CFSR), 1 << 9 | 1 << 12 | 1 << 15, "PRECISERR, STKERR, BFARVALID");
        assert_eq!((board.load(HFSR), board.load(BFAR)), (hfsr, NOWHERE));
        assert_eq!(board.load(SHCSR) >> 12 & 7, 0, "nothing is pending");
    }
}

#[test]
fn refused_unstacking_enters_bus_fault() {
    let mut board = Board::with_interrupts(&[NOP], &[0]);
    board.store(SHCSR, ALL_FAULTS);
    board.handler(16, &[BX_LR]);
    board.pulse();
    board.set(|registers| registers.r[13] = NOWHERE);
    board.step();
    assert_eq!((board.core.exception(), board.registers().r[13]), (5, NOWHERE));
    board.set(|registers| registers.r[13] = STACK);
    assert_eq!(board.load(CFSR), 1 << 11, "UNSTKERR");
}

#[test]
fn breakpoint_halts_with_a_debugger_and_faults_without() {
    let mut board = Board::new(&[BKPT]);
    let mut debugged = board.clone();
    debugged.core.attach_debugger();
    let stop = Stop::Breakpoint { address: CODE, immediate: 3 };
    assert_eq!(debugged.try_step(), Err(stop));
    assert_eq!(debugged.try_step(), Err(stop));
    assert_eq!(debugged.registers().r[15], CODE);

    board.step();
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (3, CODE));
    assert_eq!((board.load(HFSR), board.load(DFSR)), (DEBUGEVT, 1 << 1));

    let mut monitored = Board::new(&[BKPT]);
    monitored.store(DEMCR, MON_EN);
    monitored.step();
    assert_eq!(monitored.core.exception(), 12);
}

#[test]
fn unprivileged_code_has_no_system_registers() {
    let mut board = Board::new(&[0xF382, 0x8814, LDR, NOP]); // MSR control, r2; LDR r2, [r0]
    board.store(SHCSR, ALL_FAULTS);
    board.set(|registers| (registers.r[0], registers.r[2]) = (CFSR, 1));
    board.steps(2);
    assert_eq!(board.core.exception(), 5);
    assert_eq!(board.load(BFAR), CFSR);
}

#[test]
fn register_that_is_not_modelled_stops_with_its_address() {
    let mut board = Board::new(&[LDR, STR]);
    board.set(|registers| registers.r[0] = 0xE000_0E00);
    let stop = |write, instruction| Err(Stop::Unmodelled { instruction, address: 0xE000_0E00, write });
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
