//! A program that branches to itself: its iterations are skipped, with the same result as if they had been executed.

use can_twin::board::{Counters, Registers};
use can_twin::wire::time::Time;

use super::programs::*;

const END: Time = Time::from_ms(3);

/// `LDR r1, [r7]; ADDS r1, #1; STR r1, [r7]; BX lr`: a handler that counts interrupts at the address in r7.
const COUNT: [u16; 4] = [0x6839, 0x3101, 0x6039, 0x4770];

/// Returns registers, counters, time and RAM of a board at `END`, after running in stretches of `stretch_ns`
/// nanoseconds.
fn spun(program: &[u16], stretch_ns: u64) -> (Registers, Counters, Time, Vec<u8>) {
    let mut board = powered(board("spins", image(program, &COUNT)));
    let mut until = Time::ZERO;
    while until < END {
        until = (until + Time::from_ns(stretch_ns)).min(END);
        board.run_until(until).unwrap();
    }
    (board.registers(), board.counters(), board.now(), board.read_memory(RAM, 0x400).unwrap())
}

/// Given a program that spins at 168 MHz, with and without SysTick interrupts, when one board runs in stretches that
/// are too short to skip an iteration and another one in long stretches, then both end with the same registers,
/// counters, time and memory.
#[test]
fn skipped_turns_are_those_that_were_executed() {
    let interrupted = [
        run_at_168_mhz(),
        load(7, RAM + 0x100).to_vec(),
        store(DEMCR, 1 << 24),
        store(DWT_CTRL, 1),
        store(SYST_RVR, 4_999),
        store(SYST_CVR, 0),
        store(SYST_CSR, 7),
        STOP.to_vec(),
    ];
    let silent = [run_at_168_mhz(), STOP.to_vec()];
    for program in [interrupted.concat(), silent.concat()] {
        let (executed, skipped) = (spun(&program, 30), spun(&program, 20_000));
        assert_eq!(executed, skipped);
        assert!(executed.1.instructions > 40_000, "{:?}", executed.1);
    }
}

/// Given a loop of one branch, which takes 3 cycles (DDI 0439 table 3-1: 1 + P), at 16 MHz, then a millisecond has
/// 5,333 iterations.
#[test]
fn turns_of_a_millisecond_are_counted() {
    let mut board = flown(board("spins", image(&STOP, &STOP)), Time::from_ms(1));
    let before = board.counters();
    board.run_until(Time::from_ms(2)).unwrap();
    let after = board.counters();
    let turns = after.instructions - before.instructions;
    assert!((5_333..=5_334).contains(&turns), "{turns}");
    assert_eq!(after.cycles_awake - before.cycles_awake, 3 * turns);
}

/// Given a program that reads CYCCNT in the handler of an interrupt that ends its spinning, then the counter has
/// advanced.
#[test]
fn cycle_counter_counts_skipped_turns() {
    // The handler stores CYCCNT: r6 = CYCCNT; r0 = [r6]; r7 is RAM; STR r0, [r7]; B .
    let handler = [0x6830, 0x6038, 0xE7FE];
    let program = [
        store(DEMCR, 1 << 24),
        load(6, CYCCNT).to_vec(),
        load(7, RAM).to_vec(),
        store(SYST_RVR, 9_999),
        store(SYST_CVR, 0),
        store(DWT_CTRL, 1),
        store(SYST_CSR, 7),
        STOP.to_vec(),
    ];
    let counted = word(&flown(board("spins", image(&program.concat(), &handler)), Time::from_ms(2)), RAM);
    // 10,000 cycles of SysTick, between the two stores some instructions, then the exception's entry.
    assert!((10_000..10_100).contains(&counted), "{counted}");
}
