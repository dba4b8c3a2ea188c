//! Context of the FPU: access, lazy and immediate stacking, modes of a new context (DDI 0403E B1.5.7).

use crate::board::*;

const LSPACT: u32 = 1;
/// VADD.F32 s0, s1, s2
const VADD: [u16; 2] = [0xEE30, 0x0A81];

/// A program that begins a context of the FPU.
const BEGIN: [u16; 4] = [VADD[0], VADD[1], NOP, NOP];

/// A board whose program may use the FPU; interrupt 0 is enabled, with this handler. s0 to s31 are 1.0 to 32.0.
fn with_fpu(program: &[u16], handler: &[u16]) -> Board {
    let mut board = Board::with_interrupts(program, &[0]);
    board.store(CPACR, FPU_FOR_ALL);
    board.handler(16, handler);
    board.set(|registers| {
        for (register, value) in registers.s.iter_mut().zip(1_u16..) {
            *register = f32::from(value).to_bits();
        }
    });
    board
}

#[test]
fn context_without_fpu_instructions_has_a_basic_frame() {
    let mut board = with_fpu(&BEGIN, &[BX_LR]);
    board.core.set_irq(0, true);
    assert_eq!((board.steps(1).r[13], board.registers().r[14]), (STACK - 0x20, 0xFFFF_FFF9));
}

#[test]
fn lazy_entry_reserves_room_and_stores_nothing() {
    let mut board = with_fpu(&BEGIN, &[BX_LR]);
    board.step();
    board.core.set_irq(0, true);
    board.bus.accesses.clear();
    assert_eq!(board.step().cycles, 12);
    assert_eq!((board.registers().r[13], board.registers().r[14]), (STACK - 0x68, 0xFFFF_FFE9));
    assert_eq!(board.bus.accesses.iter().filter(|(_, _, write)| *write).count(), 8);
    assert_eq!(board.load(FPCCR) & LSPACT, 1);
    assert_eq!(board.load(FPCAR), STACK - 0x48);
    board.core.set_irq(0, false);
    assert_eq!(board.step().cycles, 12);
    assert_eq!((board.registers().r[13], board.registers().s[0]), (STACK, 5.0_f32.to_bits()));
    assert_eq!(board.load(FPCCR) & LSPACT, 0);
}

#[test]
fn first_fpu_instruction_of_a_handler_stores_the_registers() {
    let mut board = with_fpu(&BEGIN, &[VADD[0], VADD[1], BX_LR]);
    board.step();
    let before = board.registers();
    board.pulse();
    board.set(|registers| registers.s[1] = 100.0_f32.to_bits());
    // The handler's own register change is stored, and comes back.
    assert_eq!(board.step().cycles, 1 + 17);
    assert_eq!(board.word(STACK - 0x48), before.s[0]);
    assert_eq!(board.word(STACK - 0x48 + 4), 100.0_f32.to_bits());
    assert_eq!(board.registers().s[0], 103.0_f32.to_bits());
    assert_eq!(board.load(FPCCR) & LSPACT, 0);
    assert_eq!(board.step().cycles, 12 + 17);
    assert_eq!(board.registers().s[0], before.s[0]);
    assert_eq!(board.registers().r, before.r);
}

#[test]
fn immediate_stacking_stores_at_entry() {
    let mut board = with_fpu(&BEGIN, &[BX_LR]);
    board.store(FPCCR, 1 << 31);
    board.step();
    assert_eq!(board.raise(0).cycles, 12 + 17);
    assert_eq!(board.word(STACK - 0x48), 5.0_f32.to_bits());
    assert_eq!(board.load(FPCCR), 1 << 31);
}

#[test]
fn handler_begins_with_the_default_modes() {
    // VMRS r4, FPSCR
    let mut board = with_fpu(&BEGIN, &[0xEEF1, 0x4A10, BX_LR]);
    board.store(FPDSCR, u32::MAX);
    assert_eq!(board.load(FPDSCR), 0x07C0_0000);
    board.step();
    board.set(|registers| registers.fpscr = 0xF000_0001);
    board.core.set_irq(0, true);
    board.steps(2);
    assert_eq!(board.registers().r[4], 0xF7C0_0001);
    board.core.set_irq(0, false);
    board.step();
    assert_eq!(board.registers().fpscr, 0xF000_0001);
}

#[test]
fn refused_lazy_store_raises_lsperr() {
    let mut board = with_fpu(&BEGIN, &[VADD[0], VADD[1], BX_LR]);
    board.store(SHCSR, ALL_FAULTS);
    board.store(NVIC_IPR, 0x80);
    board.step();
    board.raise(0);
    board.store(FPCAR, NOWHERE);
    board.step();
    assert_eq!(board.core.exception(), 5);
    assert_eq!(board.load(CFSR), 1 << 13);
    assert_eq!(board.load(FPCCR) & LSPACT, 1, "it is tried again");
}

/// Given a handler whose deferred stacking fails. When the priority of the fault does not suffice. Then the fault waits as BusFault.
#[test]
fn refused_lazy_store_of_low_priority_becomes_pending() {
    let mut board = with_fpu(&BEGIN, &[VADD[0], VADD[1], BX_LR]);
    board.store(SHCSR, ALL_FAULTS);
    board.store(SHPR1, 0x8000); // BusFault: 80h, below interrupt 0
    board.step();
    board.pulse();
    board.store(FPCAR, NOWHERE);
    board.step();
    assert_eq!((board.core.exception(), board.registers().r[15]), (16, HANDLERS + 32 * 16 + 4));
    assert_eq!((board.load(CFSR), board.load(HFSR)), (1 << 13, 0));
    assert_eq!((board.load(SHCSR) >> 14 & 1, board.load(FPCCR) & LSPACT), (1, 0));
    board.step();
    assert_eq!(board.core.exception(), 5, "chained");
}

/// Given BusFault disabled at entry (FPCCR.BFRDY is 0) and enabled afterwards. When the deferred stacking fails. Then HardFault takes it.
#[test]
fn refused_lazy_store_escalates_as_at_entry() {
    let mut board = with_fpu(&BEGIN, &[VADD[0], VADD[1], BX_LR]);
    board.store(NVIC_IPR, 0x80);
    board.step();
    board.raise(0);
    board.store(SHCSR, ALL_FAULTS);
    board.store(FPCAR, NOWHERE);
    board.step();
    assert_eq!((board.core.exception(), board.load(HFSR), board.load(CFSR)), (3, 1 << 30, 1 << 13));
}

/// Given thread code with a context, and a region over its frame. When HardFault uses the FPU. Then the MPU refuses the deferred store,
/// because FPCCR.HFRDY says that it protected the frame at entry, and the fault waits.
#[test]
fn deferred_store_is_protected_as_at_entry() {
    let mut board = with_fpu(&[VADD[0], VADD[1], 0xDE00], &[]);
    board.handler(3, &VADD);
    board.store(SHCSR, 1 << 16);
    board.steps(2);
    board.store(MPU_RBAR, RAM | 1 << 4);
    board.store(MPU_RASR, 13 << 1 | 1); // 16 KiB without access
    board.store(MPU_CTRL, 0b101);
    assert_eq!(board.step().cycles, 1 + 17);
    assert_eq!((board.core.exception(), board.load(CFSR)), (3, 1 << 16 | 1 << 5), "UNDEFINSTR, MLSPERR");
    assert_eq!(board.load(SHCSR) >> 13 & 1, 1, "MemManage is pending");
}

#[test]
fn unprivileged_code_may_be_refused_the_fpu() {
    // MSR control, r2; VADD
    let mut board = Board::new(&[0xF382, 0x8814, VADD[0], VADD[1]]);
    board.store(CPACR, FPU_FOR_PRIVILEGED);
    board.store(SHCSR, ALL_FAULTS);
    board.set(|registers| registers.r[2] = 1);
    board.steps(2);
    assert_eq!((board.core.exception(), board.load(CFSR)), (6, 1 << 19));
}

/// Given unprivileged code with a context. When its handler returns and CPACR has become privileged only. Then the return raises NOCP.
#[test]
fn return_checks_the_rights_of_its_target() {
    // VADD; MSR control, r2
    let program = [VADD[0], VADD[1], 0xF382, 0x8814, NOP];
    let mut board = with_fpu(&program, &[VADD[0], VADD[1], BX_LR]);
    board.store(SHCSR, ALL_FAULTS);
    board.set(|registers| registers.r[2] = 0b101);
    board.steps(2);
    board.core.set_irq(0, true);
    board.steps(2);
    board.core.set_irq(0, false);
    board.store(CPACR, FPU_FOR_PRIVILEGED);
    board.step();
    assert_eq!((board.core.exception(), board.load(CFSR)), (6, 1 << 19));
}

/// Given a context and no access to the FPU. When entry stores the registers at once. Then CFSR says NOCP.
#[test]
fn immediate_stacking_without_access_raises_nocp() {
    let mut board = with_fpu(&BEGIN, &[BX_LR]);
    board.store(FPCCR, 1 << 31);
    board.store(SHCSR, ALL_FAULTS);
    board.store(NVIC_IPR, 0x80);
    board.step();
    board.store(CPACR, 0);
    board.raise(0);
    assert_eq!((board.core.exception(), board.load(CFSR)), (6, 1 << 19));
}

#[test]
fn undefined_encoding_begins_no_context() {
    // The encoding next to VDIV.
    let mut board = with_fpu(&[0xEE80, 0x0A40], &[]);
    board.store(SHCSR, ALL_FAULTS);
    board.step();
    assert_eq!((board.core.exception(), board.load(CFSR)), (6, 1 << 16));
    assert_eq!(board.registers().r[14], 0xFFFF_FFF9);
}

#[test]
fn comparison_moves_its_flags_to_apsr() {
    // VCMP.F32 s0, s1; VMRS APSR_nzcv, FPSCR
    let mut board = with_fpu(&[0xEEB4, 0x0A60, 0xEEF1, 0xFA10], &[]);
    let registers = board.steps(2);
    assert_eq!(registers.xpsr & 0xF000_0000, 1 << 31, "1 is less than 2");
}

#[test]
fn loads_and_stores_of_many_registers_need_alignment() {
    // VLDM r0!, {s4-s7}
    let mut board = with_fpu(&[0xECB0, 0x2A04, NOP], &[]);
    board.bus.memory.poke_words(RAM + 0x100, 7..11);
    let mut unaligned = board.clone();
    board.set(|registers| registers.r[0] = RAM + 0x100);
    let registers = board.steps(1);
    assert_eq!((registers.r[0], &registers.s[4..8]), (RAM + 0x110, &[7, 8, 9, 10][..]));
    unaligned.set(|registers| registers.r[0] = RAM + 0x102);
    unaligned.step();
    assert_eq!(unaligned.load(CFSR), 1 << 24);
}
