//! Cycles that a program sees, against figures that ARM publishes for the Cortex-M4 (DDI 0439) with memory without wait states.

use can_twin::board::{BoardConfig, Fittings, FlashTiming};
use can_twin::wire::time::Time;

use super::programs::*;

/// Pends interrupts 0 to 31.
const ISPR0: u32 = 0xE000_E200;

/// Returns the cycles between two reads of CYCCNT with `code` in between, minus those without code.
fn cycles(code: &[u16], handler: &[u16]) -> u32 {
    let measured = |code: &[u16]| {
        let program = [
            store(DEMCR, 1 << 24),
            store(DWT_CTRL, 1),
            store(NVIC_ISER0, 3),
            // r6 = CYCCNT; r4 = [r6]
            load(6, CYCCNT).to_vec(),
            load(7, RAM + 0x100).to_vec(),
            vec![0x6834],
            code.to_vec(),
            // r5 = [r6]; r5 -= r4; RAM = r5
            vec![0x6835, 0x1B2D],
            load(0, RAM).to_vec(),
            vec![0x6005],
            STOP.to_vec(),
        ];
        let fittings = Fittings { flash_timing: FlashTiming::Ideal, ..Fittings::default() };
        let config = BoardConfig { fittings, ..board("cycles", image(&program.concat(), handler)) };
        word(&flown(config, Time::from_ms(5)), RAM)
    };
    measured(code) - measured(&[])
}

/// SUBS and BNE, 1 and 1 + P cycles with P from 1 to 3 (DDI 0439 table 3-1).
#[test]
fn a_delay_loop_takes_4_cycles_a_turn_of_3_to_5_published() {
    // MOVS r0, #n; SUBS r0, #1; BNE .-2
    let turns = |n: u16| cycles(&[0x2000 | n, 0x3801, 0xD1FD], &STOP);
    assert_eq!(turns(200) - turns(100), 100 * 4);
}

/// LDM and STM of 4 registers, 1 + 4 cycles each, SUBS 1, BNE 1 + P: 13 to 15 for 16 bytes (DDI 0439 table 3-1).
#[test]
fn a_copy_loop_takes_14_cycles_a_turn_of_13_to_15_published() {
    // r7 is RAM, r4 the first count. MOV r8, r4; MOV r5, r7; MOVS r4, #n; LDMIA r7!, {r0-r3}; STMIA r5!, {r0-r3};
    // SUBS r4, #1; BNE .-6; MOV r4, r8
    let turns = |n: u16| cycles(&[0x46A0, 0x463D, 0x2400 | n, 0xCF0F, 0xC50F, 0x3C01, 0xD1FB, 0x4644], &STOP);
    assert_eq!(turns(20) - turns(10), 10 * 14);
}

/// An interrupt that returns at once: 12 cycles to enter, 12 to leave. A second one that waits is entered 6 cycles after the
/// first handler instead ("tail-chaining"). ARM gives these for memory without wait states.
#[test]
fn an_interrupt_costs_what_arm_publishes() {
    // r0 = where; MOVS r1, #n; STR r1, [r0]; NOP; NOP
    let stored = |at: u32, n: u16| {
        let code = [&load(0, at)[..], &[0x2100 | n, 0x6001, 0xBF00, 0xBF00]].concat();
        cycles(&code, &RETURN)
    };
    let nothing = stored(RAM + 0x200, 1);
    assert_eq!(stored(ISPR0, 1) - nothing, 12 + 12);
    // The BX of the first handler is the cycle beyond the 6.
    assert_eq!(stored(ISPR0, 3) - nothing, 12 + 1 + 6 + 12);
}

/// Where the twin is slower than a part, which takes 3 cycles for two loads and 2 for two stores (DDI 0439 3.3.2).
#[test]
fn loads_and_stores_do_not_overlap() {
    // LDR r0, [r7]; LDR r1, [r7, #4], and the same as stores.
    assert_eq!(cycles(&[0x6838, 0x6879], &STOP), 4);
    assert_eq!(cycles(&[0x6038, 0x6079], &STOP), 4);
}

/// SVC: its own cycle before the same.
#[test]
fn a_supervisor_call_costs_a_cycle_more() {
    assert_eq!(cycles(&[0xDF00], &RETURN), 1 + 12 + 12);
}

/// SysTick and CYCCNT count the same cycles, interrupts included.
#[test]
fn systick_agrees_with_the_cycle_counter_over_interrupts() {
    let interrupts = (0..40).flat_map(|_| [0x6001, 0xBF00, 0xBF00]).collect::<Vec<u16>>();
    let program = [
        store(DEMCR, 1 << 24),
        store(NVIC_ISER0, 1),
        store(SYST_RVR, 0x00FF_FFFF),
        store(SYST_CVR, 0),
        store(SYST_CSR, 5),
        store(DWT_CTRL, 1),
        load(0, ISPR0).to_vec(),
        load(6, CYCCNT).to_vec(),
        load(7, SYST_CVR).to_vec(),
        // MOVS r1, #1; r4 = [r6]; r5 = [r7]
        vec![0x2101, 0x6834, 0x683D],
        interrupts,
        // r2 = [r6] - r4; r3 = r5 - [r7]
        vec![0x6832, 0x683B, 0x1B12, 0x1AEB],
        load(0, RAM).to_vec(),
        // STMIA r0!, {r2, r3}
        vec![0xC00C],
        STOP.to_vec(),
    ];
    let board = flown(board("cycles", image(&program.concat(), &RETURN)), Time::from_ms(5));
    let [cycles, ticks] = words(&board, RAM);
    assert!(cycles > 40 * 24, "{cycles}");
    assert_eq!(cycles, ticks);
}
