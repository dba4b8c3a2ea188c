//! Pulses of the boards' driver on emulated boards: each edge is at the requested tick.
//!
//! The program is `pulse` of `firmware/checks`: a pulse every millisecond and 37/256 µs. No other task runs.

use can_twin::board::{BoardConfig, Edge, EmulatedBoard};
use can_twin::crystal::Crystal;
use can_twin::pin::Pin;
use can_twin::wire::time::Time;
use flight::{NUCLEO_F446RE, PYBOARD_V11, STM32F4DISCOVERY, bare, parsed, words};

const PIN: Pin = Pin::new('B', 1);
/// Time between two pulses, in units of 2^-8 µs.
const STEP: u64 = 256_000 + 37;

struct Flown {
    board: EmulatedBoard,
    edges: Vec<Edge>,
    /// First requested instant. The next fields are the pulses made and refused.
    first: u64,
    made: u32,
    refused: u32,
}

fn flown(name: &str, ppm: f64) -> Flown {
    let elf = ecss_can_cli::images::build_check(name, "pulse").unwrap();
    let config = BoardConfig { crystal: Crystal::ppm(ppm), ..bare(name, parsed(&elf)) };
    let mut board = EmulatedBoard::new(config, 0);
    board.power(true);
    board.run_until(Time::from_ms(400)).unwrap();
    let [low, high, made, refused] = words(&board, "REPORT");
    let edges = board.take_edges();
    Flown { board, edges, first: u64::from(low) | u64::from(high) << 32, made, refused }
}

/// Given instants at all fractions of a microsecond, when pulses are requested at them, then each edge is at the
/// nearest count of TIM5 for any crystal, and each pulse lasts 20 µs.
#[test]
fn each_edge_is_at_the_tick_that_was_asked_for() {
    // The discovery board captures by channels 3 and 4 of TIM5, so that channel 1 starts its pulses, and channel 3 those of the others.
    for (name, ppm) in
        [(PYBOARD_V11, 0.0), (PYBOARD_V11, -48.0), (NUCLEO_F446RE, 31.0), (STM32F4DISCOVERY, 17.0)]
    {
        let Flown { board, edges, first, made, refused } = flown(name, ppm);
        let (rises, falls): (Vec<Edge>, Vec<Edge>) = edges.iter().partition(|edge| edge.high);
        assert!(rises.len() > 256 && edges.iter().all(|edge| edge.pin == PIN), "{} rises", rises.len());
        assert!((rises.len() as u32).abs_diff(made) <= 1, "{} rises, {made} told", rises.len());
        assert_eq!(refused, 3, "past, now and too near");
        for (n, rise) in (0..).zip(&rises) {
            let asked = (first + n * STEP) as f64 * 84.0 / 256.0;
            // The tick of the true instant may have begun before the count did.
            let found = board.capture_clock(rise.at + Time(1));
            assert!((found.floor() - asked).abs() <= 0.5 + 1e-9, "{n}: {found} for {asked}");
        }
        for (rise, fall) in rises.iter().zip(&falls) {
            let us = (fall.ns() - rise.ns()) / 1000.0;
            assert!((us * (1.0 + ppm * 1e-6) - 20.0).abs() < 1e-6, "{us} us");
        }
    }
}
