//! Edges of CAN_RX through TIM5 and DMA1 into a ring in RAM, and the watchdog: one board each.

use can_twin::board::{BoardConfig, EmulatedBoard, Fittings, State};
use can_twin::bxcan::Side;
use can_twin::crystal::Crystal;
use can_twin::mmio::Refusal;
use can_twin::wire::time::Time;

use super::programs::*;

const STREAM2: u32 = DMA1 + 0x40;
/// Two rings of four words.
const RING1: u32 = RAM + 0x100;
const RING2: u32 = RAM + 0x200;
/// Address at which the interrupt handler stores LISR.
const SEEN: u32 = RAM + 0x300;
const RAM_AT_POWER_ON: u32 = 0xA5A5_A5A5;

/// Returns a board that sleeps while the lines at PA0 and PA1 are captured. The handler of stream 2, interrupt 13,
/// stores LISR.
fn observer([one, other]: [u32; 2]) -> BoardConfig {
    let program =
        [store(NVIC_ISER0, 1 << 13), capture(12, [(0, 2, one), (1, 4, other)]), SLEEP.to_vec()].concat();
    let handler = [&copy(DMA1, SEEN)[..], &store(DMA1 + 0x08, 0x3D << 16), &RETURN].concat();
    board("observer", image(&program, &handler))
}

fn asleep(config: BoardConfig) -> EmulatedBoard {
    flown(config, Time::from_ms(5))
}

/// The quantum of a spacecraft.
const QUANTUM: Time = Time::from_us(20);

/// Runs in quanta and passes the edges of each quantum to the board after it, as a spacecraft does.
fn fly(board: &mut EmulatedBoard, quantum: Time, edges: &[(Side, Time, bool)], until: Time) {
    let mut left = edges.iter().peekable();
    let mut now = board.now();
    while now < until {
        now = (now + quantum).min(until);
        board.run_until(now).unwrap();
        while let Some(&(side, at, level)) = left.next_if(|&&(_, at, _)| at <= now) {
            board.can_rx_edges(side, [(at, level)]);
        }
    }
}

fn edges(side: Side, instants: &[Time]) -> Vec<(Side, Time, bool)> {
    instants.iter().enumerate().map(|(n, &at)| (side, at, n % 2 == 1)).collect()
}

#[test]
fn dma_moves_the_captures_of_both_lines_while_the_core_sleeps() {
    let mut board = asleep(observer([RING1, RING2]));
    let awake = board.counters().instructions;
    let instants = [6_000, 6_001, 6_003].map(Time::from_us);
    let mut both = edges(Side::Can1, &instants);
    both.extend(edges(Side::Can2, &[Time::from_us(6_010), Time::from_us(6_090)]));
    fly(&mut board, QUANTUM, &both, Time::from_ms(7));
    assert_eq!(board.counters().instructions, awake, "nobody woke up");
    // 84 counts per microsecond.
    let [a, b, c, d] = words::<4>(&board, RING1);
    assert_eq!([b - a, c - b, d], [84, 168, RAM_AT_POWER_ON]);
    let [e, f, g] = words::<3>(&board, RING2);
    assert_eq!([e - a, f - e, g], [840, 80 * 84, RAM_AT_POWER_ON]);
}

#[test]
fn a_full_ring_interrupts_and_starts_again() {
    let mut board = asleep(observer([RING1, RING2]));
    let instants: Vec<_> = (0..5).map(|n| Time::from_us(6_000 + 7 * n)).collect();
    fly(&mut board, QUANTUM, &edges(Side::Can1, &instants), Time::from_ms(7));
    let [fifth, second, third, fourth] = words::<4>(&board, RING1);
    assert_eq!([third - second, fourth - third, fifth - fourth], [7 * 84; 3]);
    // HTIF2 and TCIF2.
    assert_eq!(words::<1>(&board, SEEN), [3 << 20]);
}

#[test]
fn captures_do_not_depend_on_the_length_of_the_quantum() {
    let ring = |quantum: Time| {
        let mut board = asleep(BoardConfig { crystal: Crystal::ppm(37.5), ..observer([RING1, RING2]) });
        let all = edges(Side::Can1, &[Time(2_016_001), Time(2_016_400), Time(2_020_007)]);
        fly(&mut board, quantum, &all, Time(2_100_000));
        words::<3>(&board, RING1)
    };
    let reference = ring(Time(1));
    assert_eq!(ring(Time::from_us(3)), reference);
    assert_eq!(ring(Time::from_us(20)), reference);
}

#[test]
fn the_crystals_error_shows_in_the_captures() {
    let span = |ppm: f64| {
        let mut board = asleep(BoardConfig { crystal: Crystal::ppm(ppm), ..observer([RING1, RING2]) });
        let instants = [Time::from_ms(6), Time::from_ms(1006)];
        fly(&mut board, QUANTUM, &edges(Side::Can1, &instants), Time::from_ms(1010));
        let [a, b] = words::<2>(&board, RING1);
        b.wrapping_sub(a)
    };
    // A second of 84 MHz, 50 ppm more or less.
    assert!(span(0.0).abs_diff(84_000_000) <= 1);
    assert!(span(50.0).abs_diff(84_004_200) <= 1);
    assert!(span(-50.0).abs_diff(83_995_800) <= 1);
}

#[test]
fn without_the_wires_nothing_is_captured() {
    let fittings = Fittings { capture_wires: false, ..Fittings::default() };
    let mut board = asleep(BoardConfig { fittings, ..observer([RING1, RING2]) });
    fly(&mut board, QUANTUM, &edges(Side::Can1, &[Time::from_ms(6)]), Time::from_ms(7));
    assert_eq!(words::<1>(&board, RING1), [RAM_AT_POWER_ON]);
}

/// RM0090 2.3.1 and 10.3.2: DMA does not reach CCM; the stream stops with TEIF2 (LISR bit 19).
#[test]
fn a_ring_in_ccm_is_a_transfer_error() {
    let mut board = asleep(observer([0x1000_0000, RING2]));
    fly(&mut board, QUANTUM, &edges(Side::Can1, &[Time::from_ms(6)]), Time::from_ms(7));
    assert_eq!((words(&board, 0x1000_0000), words(&board, SEEN)), ([RAM_AT_POWER_ON], [1 << 19]));
}

#[test]
fn a_stream_that_is_not_modelled_is_refused() {
    // Double buffers.
    let program = [store(RCC + 0x30, 1 << 21), store(STREAM2, 1 << 18 | 1)].concat();
    let error = refused(board("lost", image(&program, &STOP)), Time::from_us(50));
    assert_eq!((error.address, error.refusal), (STREAM2, Refusal::Unmodelled));
}

/// Returns a program that copies RCC_CSR, clears its flags, starts a watchdog of 1 ms (PR 0, RLR 7) and continues with
/// `rest`.
fn guarded(rest: &[u16]) -> Vec<u16> {
    [
        &copy(RCC + 0x74, RAM)[..],
        &store(RCC + 0x74, 1 << 24),
        &store(IWDG, 0x5555),
        &store(IWDG + 0x04, 0),
        &store(IWDG + 0x08, 7),
        &store(IWDG, 0xCCCC),
        &store(IWDG, 0xAAAA),
        rest,
    ]
    .concat()
}

#[test]
fn an_unfed_watchdog_resets_a_core_in_any_state() {
    // Spinning, asleep, in an endless fault handler, locked up.
    for (rest, handler) in [(&STOP[..], 0xE7FE), (&SLEEP, 0xE7FE), (&[0xDE00], 0xE7FE), (&[0xDE00], 0xDE00)] {
        let mut board = flown(board("guarded", image(&guarded(rest), &[handler])), Time::from_us(990));
        assert_eq!((board.counters().watchdog_resets, words::<1>(&board, RAM)), (0, [0x0E00_0000]));
        board.run_until(Time::from_us(3_100)).unwrap();
        // IWDGRSTF and PINRSTF (RM0090 7.3.21).
        assert_eq!(
            (board.counters().watchdog_resets, words::<1>(&board, RAM)),
            (3, [0x2400_0000]),
            "{rest:X?}"
        );
    }
}

#[test]
fn a_fed_watchdog_lets_the_program_live() {
    let feed = [&store(IWDG, 0xAAAA)[..], &[0xE7F5]].concat(); // B to its beginning
    let board = flown(board("fed", image(&guarded(&feed), &STOP)), Time::from_ms(50));
    assert_eq!((board.counters().watchdog_resets, board.state()), (0, &State::Running));
}

#[test]
fn a_slow_lsi_resets_late() {
    let fittings = Fittings { lsi_hz: 17_000, ..Fittings::default() };
    let config = BoardConfig { fittings, ..board("guarded", image(&guarded(&STOP), &STOP)) };
    // 4 * 8 cycles at 17 kHz: 1882 us.
    let mut board = flown(config, Time::from_us(1_870));
    assert_eq!(board.counters().watchdog_resets, 0);
    board.run_until(Time::from_us(1_900)).unwrap();
    assert_eq!(board.counters().watchdog_resets, 1);
}
