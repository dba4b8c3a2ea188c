//! Known instruction and interrupt vectors.
//!
//! Programs are assembled by hand; the comments give the mnemonics. Expected values come from the ARMv7-M Architecture
//! Reference Manual (DDI 0403E), not from a run.

use std::sync::Arc;

use super::*;
use crate::accelerator::FlashTiming;
use crate::link::Link;
use crate::model::{Model, Part};
use crate::peripherals::Peripherals;

const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0000;
const STACK: u32 = RAM + 0x1000;
/// Where programs start, after a vector table with all 82 interrupts.
const CODE: u32 = FLASH + 0x200;
/// Where handlers start.
const HANDLER: u32 = FLASH + 0x400;
const TIM2_IRQ: u16 = 28;
const NVIC_ISER0: u32 = 0xE000_E100;
const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;

/// Flash with a program at [`CODE`], a handler at [`HANDLER`] for every exception but reset.
fn core(program: &[u16], handler: &[u16]) -> CortexM4 {
    let mut flash = vec![0xFF; 0x600];
    let mut put = |address: u32, bytes: &[u8]| {
        let at = (address - FLASH) as usize;
        flash[at..at + bytes.len()].copy_from_slice(bytes);
    };
    put(FLASH, &STACK.to_le_bytes());
    put(FLASH + 4, &(CODE | 1).to_le_bytes());
    for vector in 2..98 {
        put(FLASH + vector * 4, &(HANDLER | 1).to_le_bytes());
    }
    for (base, code) in [(CODE, program), (HANDLER, handler)] {
        for (k, halfword) in code.iter().enumerate() {
            put(base + 2 * k as u32, &halfword.to_le_bytes());
        }
    }
    let link = Arc::new(Link::new(Peripherals::new(Model::PYBOARD_V11, 0), FlashTiming::AsSet));
    let mut core = CortexM4::new(Part::Stm32f405, &flash, link);
    core.step();
    assert_eq!(core.pc(), CODE, "the reset sequence takes the vector");
    core
}

fn run(core: &mut CortexM4, steps: usize) -> Registers {
    for _ in 0..steps {
        core.step();
    }
    core.registers()
}

fn word(core: &CortexM4, address: u32) -> u32 {
    let mut bytes = [0; 4];
    core.read_memory(address, &mut bytes).unwrap();
    u32::from_le_bytes(bytes)
}

/// `MOVW r7, #low; MOVT r7, #high; MOVW r6, ..; MOVT r6, ..; STR r6, [r7]`: 5 steps that enable one interrupt.
const ENABLE_TIM2: [u16; 9] = [
    0xF24E, 0x1700, // MOVW r7, #0xE100
    0xF2CE, 0x0700, // MOVT r7, #0xE000
    0xF04F, 0x5680, // MOV.W r6, #0x10000000
    0x603E, // STR r6, [r7]
    0xBF00, 0xBF00, // NOP; NOP
];
const ENABLE_STEPS: usize = 6;

#[test]
fn the_enabling_preamble_writes_iser0() {
    // The preamble of the tests below is itself a vector: 1 << 28 at E000E100h.
    let mut core = core(&ENABLE_TIM2, &[0xBF00]);
    let registers = run(&mut core, ENABLE_STEPS);
    assert_eq!((registers.r[7], registers.r[6]), (NVIC_ISER0, 1 << TIM2_IRQ));
}

#[test]
fn adds_and_subs_set_the_flags() {
    let cases: [(u16, u32, u32, u32, u32); 6] = [
        // ADDS r2, r0, r1
        (0x1842, 1, 2, 3, 0),
        (0x1842, 0xFFFF_FFFF, 1, 0, Z | C),
        (0x1842, 0x7FFF_FFFF, 1, 0x8000_0000, N | V),
        // SUBS r2, r0, r1
        (0x1A42, 5, 5, 0, Z | C),
        (0x1A42, 3, 5, 0xFFFF_FFFE, N),
        (0x1A42, 0x8000_0000, 1, 0x7FFF_FFFF, C | V),
    ];
    for (instruction, a, b, result, flags) in cases {
        // LDR r0, [pc, #4]; LDR r1, [pc, #8]; <instruction>; B .; literals
        let literals = [a as u16, (a >> 16) as u16, b as u16, (b >> 16) as u16];
        let mut program = vec![0x4801, 0x4902, instruction, 0xE7FE];
        program.extend(literals);
        let mut core = core(&program, &[]);
        let registers = run(&mut core, 3);
        assert_eq!(registers.r[2], result, "{instruction:04X} {a:X} {b:X}");
        assert_eq!(registers.xpsr & (N | Z | C | V), flags, "{instruction:04X} {a:X} {b:X}");
    }
}

#[test]
fn multiplication_division_and_bit_fields() {
    let mut core = core(
        &[
            0xF04F, 0x30FF, // MOV.W r0, #0xFFFFFFFF
            0x2103, // MOVS r1, #3
            0xFBA0, 0x2301, // UMULL r2, r3, r0, r1
            0xFBB0, 0xF4F1, // UDIV r4, r0, r1
            0xF3C0, 0x1507, // UBFX r5, r0, #4, #8
            0xFAB1, 0xF681, // CLZ r6, r1
            0xFA91, 0xF7A1, // RBIT r7, r1
        ],
        &[],
    );
    let registers = run(&mut core, 7);
    assert_eq!((registers.r[3], registers.r[2]), (2, 0xFFFF_FFFD));
    assert_eq!(registers.r[4], 0x5555_5555);
    assert_eq!(registers.r[5], 0xFF);
    assert_eq!(registers.r[6], 30);
    assert_eq!(registers.r[7], 0xC000_0000);
}

#[test]
fn stores_loads_and_the_exclusive_monitor() {
    let mut core = core(
        &[
            0xF04F, 0x5000, // MOV.W r0, #0x20000000
            0x212A, // MOVS r1, #42
            0x6001, // STR r1, [r0]
            0xE850, 0x2F00, // LDREX r2, [r0]
            0xE840, 0x1300, // STREX r3, r1, [r0]
            0xE840, 0x1400, // STREX r4, r1, [r0]: no LDREX before
            0x7842, // LDRB r2, [r0, #1]
        ],
        &[],
    );
    let registers = run(&mut core, 7);
    assert_eq!(word(&core, RAM), 42);
    assert_eq!((registers.r[3], registers.r[4], registers.r[2]), (0, 1, 0));
}

#[test]
fn single_precision_arithmetic_runs_once_cpacr_allows() {
    let mut core = core(
        &[
            0xF64E, 0x5088, // MOVW r0, #0xED88 (CPACR)
            0xF2CE, 0x0000, // MOVT r0, #0xE000
            0xF44F, 0x0170, // MOV.W r1, #0xF00000
            0x6001, // STR r1, [r0]
            0xEEB7, 0x0A00, // VMOV.F32 s0, #1.0
            0xEEB0, 0x1A08, // VMOV.F32 s2, #3.0
            0xEE80, 0x0A01, // VDIV.F32 s0, s0, s2
            0xEE10, 0x2A10, // VMOV r2, s0
        ],
        &[],
    );
    assert_eq!(run(&mut core, 8).r[2], (1.0_f32 / 3.0).to_bits());
}

#[test]
fn an_interrupt_stacks_eight_words_and_returns() {
    let mut program = ENABLE_TIM2.to_vec();
    program.extend([0x2011, 0xBF00, 0xE7FE]); // MOVS r0, #0x11; NOP; B .
    // MOVS r0, #0x55; MOVS r4, #0x66; BX lr
    let mut core = core(&program, &[0x2055, 0x2466, 0x4770]);
    run(&mut core, ENABLE_STEPS + 1);
    core.set_irq(TIM2_IRQ, true);
    let entered = run(&mut core, 1);
    assert_eq!(core.pc(), HANDLER);
    assert_eq!(entered.xpsr & 0x1FF, u32::from(TIM2_IRQ) + 16);
    assert_eq!(entered.r[14], 0xFFFF_FFF9);
    assert_eq!(entered.r[13], STACK - 32);
    assert_eq!(core.return_address(), Some(CODE + 20));
    core.set_irq(TIM2_IRQ, false);
    let returned = run(&mut core, 3);
    assert_eq!(returned.r[15], CODE + 20);
    assert_eq!((returned.r[0], returned.r[4]), (0x11, 0x66), "r0 was stacked, r4 was not");
    assert_eq!(returned.r[13], STACK);
}

#[test]
fn a_line_still_high_at_return_enters_the_handler_again() {
    let mut core = core(&ENABLE_TIM2, &[0x4770]);
    run(&mut core, ENABLE_STEPS - 1);
    core.set_irq(TIM2_IRQ, true);
    run(&mut core, 1);
    assert_eq!(core.pc(), HANDLER);
    run(&mut core, 2);
    assert_eq!(core.registers().xpsr & 0x1FF, u32::from(TIM2_IRQ) + 16);
}

/// Interrupts an IT block after each of its instructions and wants the same result every time.
#[test]
fn an_interrupt_inside_an_it_block_changes_nothing() {
    let mut program = ENABLE_TIM2.to_vec();
    program.extend([
        0x2005, // MOVS r0, #5
        0x2805, // CMP r0, #5
        0xBF07, // ITTEE EQ
        0x2101, // MOVEQ r1, #1
        0x2202, // MOVEQ r2, #2
        0x2103, // MOVNE r1, #3
        0x2204, // MOVNE r2, #4
        0xE7FE, // B .
    ]);
    let at_it = ENABLE_STEPS + 2;
    for interrupted_after in 0..=5 {
        // CMP r0, r0 would leave Z set; CMP r0, sp clears it, so that a lost ITSTATE shows: the return restores flags.
        let mut core = core(&program, &[0x4568, 0x4770]);
        run(&mut core, at_it + interrupted_after);
        core.set_irq(TIM2_IRQ, true);
        run(&mut core, 1);
        assert_eq!(core.pc(), HANDLER);
        core.set_irq(TIM2_IRQ, false);
        let registers = run(&mut core, 12);
        assert_eq!((registers.r[1], registers.r[2]), (1, 2), "interrupted after {interrupted_after} steps");
    }
}

/// The handler returns from inside an IT block of its own while it had interrupted one.
#[test]
fn a_conditional_return_restores_the_interrupted_it_block() {
    let mut program = ENABLE_TIM2.to_vec();
    program.extend([
        0x2005, // MOVS r0, #5
        0x2805, // CMP r0, #5
        0xBF07, // ITTEE EQ
        0x2101, // MOVEQ r1, #1
        0x2202, // MOVEQ r2, #2
        0x2103, // MOVNE r1, #3
        0x2204, // MOVNE r2, #4
        0xE7FE, // B .
    ]);
    // CMP r0, r0; PUSH {r4, lr}; IT EQ; POPEQ {r4, pc}
    let handler = [0x4280, 0xB510, 0xBF08, 0xBD10];
    for interrupted_after in 1..=4 {
        let mut core = core(&program, &handler);
        run(&mut core, ENABLE_STEPS + 2 + interrupted_after);
        core.set_irq(TIM2_IRQ, true);
        run(&mut core, 1);
        core.set_irq(TIM2_IRQ, false);
        let registers = run(&mut core, 16);
        assert_eq!((registers.r[1], registers.r[2]), (1, 2), "interrupted after {interrupted_after} steps");
    }
}

#[test]
fn wfe_sleeps_until_enabled_interrupt_and_sev_lets_it_through() {
    let mut program = ENABLE_TIM2.to_vec();
    program.extend([0xBF40, 0xBF20, 0xBF20, 0xE7FE]); // SEV; WFE; WFE; B .
    let mut core = core(&program, &[0x4770]);
    run(&mut core, ENABLE_STEPS);
    assert!(!core.step().asleep, "SEV");
    assert!(!core.step().asleep, "the first WFE consumes the event");
    assert!(core.step().asleep, "the second sleeps");
    core.set_irq(TIM2_IRQ + 1, true);
    assert!(core.step().asleep, "an interrupt that is not enabled does not wake");
    core.set_irq(TIM2_IRQ, true);
    assert!(!core.step().asleep);
    assert_eq!(core.pc(), HANDLER);
}

#[test]
fn undefined_instruction_hard_faults_and_closed_loop_is_stuck() {
    let mut core = core(&[0xDE00], &[0xE7FE]); // UDF #0; handler: B .
    let step = core.step();
    assert!(step.hard_fault);
    assert_eq!(core.return_address(), Some(CODE));
    assert!(core.step().stuck);
}

#[test]
fn a_fault_inside_hard_fault_locks_up() {
    let mut core = core(&[0xDE00], &[0xDE00]);
    run(&mut core, 2);
    assert!(core.is_locked_up());
}

#[test]
fn a_load_from_nowhere_is_reported() {
    let mut core = core(&[0xF04F, 0x40C0, 0x6801], &[]); // MOV.W r0, #0x60000000; LDR r1, [r0]
    run(&mut core, 1);
    assert!(core.step().hard_fault);
    assert_eq!(core.take_bus_fault(), Some(0x6000_0000));
    assert_eq!(core.return_address(), Some(CODE + 4));
}

#[test]
fn sysresetreq_is_a_request_until_the_reset() {
    let mut core = core(
        &[
            0xF64E, 0x500C, // MOVW r0, #0xED0C (AIRCR)
            0xF2CE, 0x0000, // MOVT r0, #0xE000
            0x2104, // MOVS r1, #4
            0xF2C0, 0x51FA, // MOVT r1, #0x5FA
            0x6001, // STR r1, [r0]
        ],
        &[],
    );
    run(&mut core, 4);
    assert!(core.step().reset_request);
    core.reset();
    core.step();
    assert_eq!(core.pc(), CODE);
    assert!(!core.step().reset_request);
}

#[test]
fn ram_after_power_on_is_not_zero() {
    let core = core(&[], &[]);
    assert_ne!(word(&core, RAM), 0);
}
