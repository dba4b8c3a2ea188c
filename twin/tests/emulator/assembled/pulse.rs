//! A pulse at a pin, started by TIM5 and output by TIM3, and the true instants of its edges.

use can_twin::board::{BoardConfig, Edge, EmulatedBoard};
use can_twin::crystal::Crystal;
use can_twin::mmio::Refusal;
use can_twin::pin::Pin;
use can_twin::wire::time::Time;

use super::programs::*;

const PULSE: Pin = Pin::new('B', 1);

/// Returns a program that outputs a pulse of 840 counts, 10 us, a millisecond after the start of TIM5.
fn pulser() -> Vec<u16> {
    [
        run_at_168_mhz(),
        store(RCC + 0x30, 1 << 1),
        store(RCC + 0x40, 1 << 1 | 1 << 3),
        store(GPIOB + 0x20, 2 << 4),
        store(GPIOB, 0x280 | 2 << 2),
        store(TIM3 + 0x2C, 840),
        store(TIM3 + 0x40, 1),
        store(TIM3 + 0x1C, 0b111 << 12),
        store(TIM3 + 0x20, 1 << 12),
        store(TIM3 + 0x08, 2 << 4 | 0b110),
        store(TIM3, 1 << 3),
        store(TIM5 + 0x04, 0b110 << 4),
        store(TIM5 + 0x3C, 84_000),
        store(TIM5 + 0x1C, 0b001 << 4),
        store(TIM5, 1),
    ]
    .concat()
}

fn edges(config: BoardConfig, quantum: Time) -> (EmulatedBoard, Vec<Edge>) {
    let mut board = powered(config);
    let mut now = board.now();
    while now < Time::from_ms(8) {
        now += quantum;
        board.run_until(now).unwrap();
    }
    let edges = board.take_edges();
    (board, edges)
}

fn flown(ppm: f64, rest: &[u16], quantum: Time) -> (EmulatedBoard, Vec<Edge>) {
    let program = [&pulser()[..], rest].concat();
    edges(BoardConfig { crystal: Crystal::ppm(ppm), ..board("pulser", image(&program, &STOP)) }, quantum)
}

/// Given a core that sleeps, runs, or is stopped every microsecond, when TIM5 matches, then the pin rises five counts later.
#[test]
fn pin_rises_five_counts_after_the_match_and_falls_by_itself() {
    for (rest, quantum) in
        [(&SLEEP[..], Time::from_ms(8)), (&STOP, Time::from_ms(8)), (&STOP, Time::from_us(1))]
    {
        let (board, edges) = flown(0.0, rest, quantum);
        let [rise, fall] = edges[..] else { panic!("{edges:?}") };
        assert_eq!((rise.pin, rise.high, fall.pin, fall.high), (PULSE, true, PULSE, false));
        // Counts and ticks have one ratio, 4.
        assert_eq!(fall.at.since(rise.at), Time(4 * 840));
        assert_eq!((rise.fraction, fall.fraction), (0.0, 0.0));
        assert_eq!(board.capture_clock(rise.at), 84_005.0);
        assert_eq!(rise.ns(), rise.at.0 as f64 / 0.336);
    }
}

/// 50 ppm fast: 840 counts last 10 us / 1.00005 = 3359.832 ticks.
#[test]
fn edges_have_fractions_of_a_tick() {
    let (_, edges) = flown(50.0, &SLEEP, Time::from_ms(8));
    let [rise, fall] = edges[..] else { panic!("{edges:?}") };
    let width = (fall.ns() - rise.ns()) * 0.336;
    assert!((width - 3_359.832_008).abs() < 1e-5, "{width} ticks");
}

/// Given a pulse of TIM5 itself at PA2, then the program reads its level.
#[test]
fn tim5_drives_its_own_pins() {
    let program = [
        run_at_168_mhz(),
        store(RCC + 0x30, 1),
        store(RCC + 0x40, 1 << 3),
        store(GPIOA + 0x20, 2 << 8),
        store(GPIOA, 0xA800_0000 | 2 << 4),
        copy(GPIOA + 0x10, RAM),
        store(TIM5 + 0x1C, 0b101 << 4),
        store(TIM5 + 0x20, 1 << 8),
        copy(GPIOA + 0x10, RAM + 4),
        SLEEP.to_vec(),
    ]
    .concat();
    let (board, edges) = edges(board("driver", image(&program, &STOP)), Time::from_ms(8));
    assert_eq!(
        edges.iter().map(|edge| (edge.pin, edge.high)).collect::<Vec<_>>(),
        [(Pin::new('A', 2), true)]
    );
    let levels = board.read_memory(RAM, 8).unwrap();
    assert_eq!((levels[0] & 4, levels[4] & 4), (0, 4));
}

#[test]
fn a_trigger_from_elsewhere_is_refused() {
    // ITR0 of TIM3 is TIM1.
    let program = [store(RCC + 0x40, 1 << 1), store(TIM3 + 0x08, 0b110)].concat();
    let error = refused(board("lost", image(&program, &STOP)), Time::from_us(50));
    assert_eq!((error.address, error.refusal), (TIM3 + 0x08, Refusal::Unmodelled));
}
