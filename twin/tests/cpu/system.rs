//! System registers: SysTick, cycle counter, debug, MPU, bit-band aliases, identification.

use can_twin::cpu::{Config, Width};

use crate::board::*;

/// Region enabled, 1 KiB; full access.
const REGION: u32 = 9 << 1 | 1;
const FULL: u32 = 0b011 << 24;
const READ_ONLY: u32 = 0b110 << 24;
const EXECUTE_NEVER: u32 = 1 << 28;

fn start_systick(board: &mut Board, reload: u32, control: u32) {
    board.store(SYST_RVR, reload);
    board.store(SYST_CVR, 0);
    board.store(SYST_CSR, control);
}

#[test]
fn systick_interrupts_every_reload_plus_one_cycles() {
    // B .-2 takes 3 cycles, NOP 1.
    let mut board = Board::new(&[NOP, 0xE7FD]);
    board.handler(15, &[0x4770]);
    start_systick(&mut board, 99, 0b111);
    let enabled = board.core.cycle();
    let mut entries = Vec::new();
    while entries.len() < 4 {
        let before = board.core.exception();
        let begun = board.core.cycle();
        board.step();
        if before == 0 && board.core.exception() == 15 {
            entries.push(begun - enabled);
        }
    }
    // The store took place one cycle before the step ended, and an entry waits for the instruction under way.
    for (index, &entry) in (1..).zip(&entries) {
        assert!((index * 100 - 2..index * 100 + 3).contains(&entry), "{entries:?}");
    }
}

#[test]
fn systick_of_the_reference_clock_is_slower() {
    let mut board = Board::new(&[NOP]);
    assert_eq!(board.load(SYST_CALIB), 18_750);
    start_systick(&mut board, 9, 0b011);
    let due = board.core.systick_event();
    assert_eq!(due % 8, 0);
    assert!((73..=80).contains(&(due - board.core.cycle())));
}

#[test]
fn sleeping_core_is_woken_by_systick() {
    let mut board = Board::new(&[0xBF30, NOP]); // WFI
    start_systick(&mut board, 999, 0b111);
    board.start_cycle_counter();
    assert!(board.step().asleep);
    let counted = {
        let mut awake = board.clone();
        awake.load(DWT_CYCCNT)
    };
    board.core.advance_to(board.core.systick_event());
    assert!(!board.step().asleep);
    assert_eq!(board.core.exception(), 15);
    assert!(board.load(DWT_CYCCNT) - counted < 40, "the cycle counter stands still in sleep");
}

#[test]
fn halted_core_lets_systick_and_cycle_counter_stand() {
    let mut board = Board::new(&[NOP]);
    start_systick(&mut board, 999, 0b111);
    board.start_cycle_counter();
    let mut running = board.clone();
    board.core.skip_to(board.core.cycle() + 5000);
    assert_eq!(board.load(DWT_CYCCNT), running.load(DWT_CYCCNT));
    assert_eq!(board.load(SYST_CVR), running.load(SYST_CVR));
    assert_eq!(board.core.exception(), 0);
}

#[test]
fn cycle_counter_counts_the_cycles_of_instructions() {
    // LDR r2, [r0]; NOP; LDR r3, [r0]: 2 + 1 cycles from the beginning of one to that of the other.
    let mut board = Board::new(&[0x6802, NOP, 0x6803]);
    board.start_cycle_counter();
    board.set(|registers| registers.r[0] = DWT_CYCCNT);
    let registers = board.steps(3);
    assert_eq!(registers.r[3] - registers.r[2], 3);
}

#[test]
fn debugger_is_visible_in_dhcsr() {
    let mut board = Board::new(&[NOP]);
    assert_eq!(board.load(DHCSR) & 0x0200_0001, 0x0200_0000, "a reset has been");
    board.core.attach_debugger();
    assert_eq!(board.load(DHCSR) & 0x0200_0001, 1);
    board.store(DHCSR, 0xA05F_0000);
    assert_eq!(board.load(DHCSR) & 1, 1, "C_DEBUGEN is the debugger's");
    board.core.reset();
    board.step();
    assert_eq!(board.load(DHCSR) & 1, 1);
}

#[test]
fn monitor_is_pended_by_demcr() {
    let mut board = Board::new(&[NOP]);
    board.store(DEMCR, MON_EN | MON_PEND);
    board.step();
    assert_eq!(board.core.exception(), 12);
}

#[test]
fn alias_words_read_and_write_single_bits() {
    let mut board = Board::new(&[STR, LDR]);
    board.bus.memory.poke(RAM + 0x40, Width::Word, 0x0000_0100);
    board.set_r0_r1(0x2200_0000 + 0x41 * 32 + 3 * 4, 0xFFFF_FFFF);
    assert_eq!(board.step().cycles, 3);
    assert_eq!(board.word(RAM + 0x40), 0x0000_0900);
    assert_eq!(board.steps(1).r[2], 1);

    let mut board = Board::new(&[STR, LDR]);
    board.bus.memory.poke(PERIPHERAL + 4, Width::Word, u32::MAX);
    board.set_r0_r1(0x4200_0000 + 4 * 32 + 31 * 4, 2);
    board.step();
    assert_eq!(board.word(PERIPHERAL + 4), 0x7FFF_FFFF, "bit 0 of the value counts");
    assert_eq!(board.bus.accesses[board.bus.accesses.len() - 1], (PERIPHERAL + 4, Width::Word, true));
}

/// All faults enabled, a region over the first KiB of RAM, and the background for privileged code.
fn protected(program: &[u16], attributes: u32) -> Board {
    let mut board = Board::new(program);
    board.store(SHCSR, ALL_FAULTS);
    board.store(MPU_RBAR, RAM | 1 << 4 | 3);
    board.store(MPU_RASR, REGION | attributes);
    // Flash for all code, read-only, and the rest of RAM for its stack.
    board.store(MPU_RBAR_A1, 0x0800_0000 | 1 << 4 | 1);
    board.store(MPU_RASR_A1, 19 << 1 | 1 | READ_ONLY);
    board.store(MPU_CTRL, 0b101);
    board
}

#[test]
fn region_refuses_what_it_does_not_permit() {
    let mut board = protected(&[LDR, STR], READ_ONLY | EXECUTE_NEVER);
    assert_eq!(board.load(MPU_TYPE), 8 << 8);
    board.set(|registers| registers.r[0] = RAM + 0x3FC);
    board.step();
    assert_eq!(board.core.exception(), 0);
    board.step();
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (4, CODE + 2));
    assert_eq!((board.load(CFSR), board.load(MMFAR)), (1 << 1 | 1 << 7, RAM + 0x3FC));
}

#[test]
fn execute_never_refuses_code() {
    let mut board = protected(&[BX_R0], FULL | EXECUTE_NEVER);
    board.set(|registers| registers.r[0] = RAM | 1);
    board.steps(2);
    assert_eq!((board.core.exception(), board.word(STACK - 8)), (4, RAM));
    assert_eq!(board.load(CFSR), 1);
}

#[test]
fn unprivileged_load_has_the_rights_of_unprivileged_code() {
    // LDR r2, [r0]; LDRT r2, [r0]
    let mut board = protected(&[0x6802, 0xF850, 0x2E00], 0b001 << 24);
    board.set(|registers| registers.r[0] = RAM);
    board.steps(2);
    assert_eq!((board.core.exception(), board.load(MMFAR)), (4, RAM));
}

#[test]
fn exclusive_store_asks_the_mpu_only_with_a_mark() {
    // STREX r3, r1, [r0]; LDREX r2, [r0]; STREX r3, r1, [r0]
    let program = [0xE840, 0x1300, 0xE850, 0x2F00, 0xE840, 0x1300];
    let mut board = protected(&program, READ_ONLY | EXECUTE_NEVER);
    board.set(|registers| registers.r[0] = RAM);
    assert_eq!((board.steps(1).r[3], board.core.exception()), (1, 0));
    board.steps(2);
    assert_eq!((board.core.exception(), board.load(MMFAR)), (4, RAM));
}

#[test]
fn stack_in_a_refused_region_raises_mstkerr() {
    let mut board = protected(&[NOP], READ_ONLY);
    board.store(NVIC_ISER, 1);
    board.store(NVIC_IPR, 0x80);
    board.set(|registers| registers.r[13] = RAM + 0x100);
    board.raise(0);
    assert_eq!(board.core.exception(), 4);
    assert_eq!(board.load(CFSR), 1 << 4);
}

/// Given a region that begins in the middle of an unaligned word. When it is loaded. Then MMFAR has the first address in the region.
#[test]
fn unaligned_access_reports_the_address_in_the_region() {
    let mut board = protected(&[LDR], 0);
    board.store(MPU_RBAR, (RAM + 0x400) | 1 << 4 | 3);
    board.set(|registers| registers.r[0] = RAM + 0x3FE);
    board.step();
    assert_eq!((board.core.exception(), board.load(MMFAR)), (4, RAM + 0x400));
}

#[test]
fn region_registers_keep_what_is_written() {
    let mut board = Board::new(&[NOP]);
    board.store(MPU_RNR, 5);
    board.store(MPU_RBAR, 0x2000_1000);
    board.store(MPU_RASR, 0xFFFF_FFFF);
    assert_eq!(board.load(MPU_RBAR), 0x2000_1005);
    assert_eq!(board.load(MPU_RASR), 0x173F_FF3F);
}

#[test]
fn parts_of_a_register_can_be_accessed() {
    // STRB r1, [r0]; LDRH r2, [r0]
    let mut board = Board::new(&[0x7001, 0x8802]);
    board.store(NVIC_IPR + 4, 0x4030_2010);
    board.set_r0_r1(NVIC_IPR + 6, 0xFF);
    assert_eq!(board.steps(2).r[2], 0x40F0);
    assert_eq!(board.load(NVIC_IPR + 4), 0x40F0_2010);
}

#[test]
fn identification_is_that_of_a_cortex_m4_r0p1() {
    let mut board = Board::with_config(&[NOP], Config::stm32f4(FLASH_BYTES));
    assert_eq!(board.load(0xE000_ED00), 0x410F_C241);
    assert_eq!(board.load(0xE000_E004), 3, "97 lines");
    assert_eq!(board.load(0xE000_EF40), 0x1011_0021);
}
