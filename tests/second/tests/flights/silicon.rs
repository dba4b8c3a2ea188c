//! Effects of real boards that a core with ideal memory does not have: a broken oscillator, a removed probe, slow
//! flash.

use can_twin::board::{Fittings, FlashTiming};
use can_twin::bxcan::Side;
use can_twin::pin::Pin;
use can_twin::spacecraft::Bus;
use can_twin::wire::frame::WireFrame;
use can_twin::wire::time::Time;
use flight::*;

/// Given a slave whose HSE does not start, when it is powered, then it stays on HSI and off both buses, logs that, and
/// its LEDs alternate.
///
/// Verifies: ECSS 6.10f
#[test]
fn board_without_oscillator_stays_silent_and_says_so() {
    for (name, sync, state) in [
        (PYBOARD_V11, Pin::new('B', 4), Pin::new('A', 15)),
        (NUCLEO_F446RE, Pin::new('A', 5), Pin::new('A', 6)),
    ] {
        let [master, slave, mut broken, _] = MASTER_AND_THREE;
        (broken.board, broken.power_on_ms) = (name, 20);
        let fittings = |node| Fittings { hse_starts: node != broken.node, ..Fittings::default() };
        let mut flight = Flight::fitted(&[master, slave, broken], fittings);
        flight.fly_to(1_200);
        flight.assert_said(broken.node, "HSE does not start", ms(20));
        flight.assert_operational([slave.node], Bus::Nominal);
        flight.assert_absent(broken.node, ms(0));
        let board = flight.emulated_mut(broken.node);
        assert_eq!([Side::Can1, Side::Can2].map(|side| board.can_stats(side).stored), [[0, 0]; 2], "{name}");
        assert_eq!(board.hclk(), 16_000_000);
        let changes = board.take_pin_changes();
        for led in [sync, state] {
            let levels: Vec<_> = changes.iter().filter(|change| change.pin == led).collect();
            assert!(levels.len() >= 2, "{led:?}: {changes:?}");
            assert!(levels.windows(2).all(|pair| pair[0].high != pair[1].high));
        }
        flight.assert_sound();
    }
}

/// Given a board whose oscillator starts 1.5 s after power-on, later than its first timeout, then the board is silent
/// until then, boots, and is operational.
///
/// Verifies: ECSS 6.10f
#[test]
fn board_with_late_oscillator_boots_when_it_runs() {
    for name in [PYBOARD_V11, NUCLEO_F446RE] {
        let [master, slave, mut late, _] = MASTER_AND_THREE;
        (late.board, late.power_on_ms) = (name, 20);
        let delay = |node| if node == late.node { ms(1_500) } else { Time::ZERO };
        let fittings = |node| Fittings { hse_delay: delay(node), ..Fittings::default() };
        let mut flight = Flight::fitted(&[master, slave, late], fittings);
        flight.fly_to(2_600);
        flight.assert_said(late.node, "HSE does not start", ms(20));
        let first = flight.of(late.node).next().unwrap();
        assert!(first.start > ms(1_520) && first.start < ms(1_520 + 300), "{} us", first.start.as_us());
        assert_eq!(first.data(), [BOOT_UP]);
        flight.assert_operational([late.node], Bus::Nominal);
        flight.assert_sound();
    }
}

/// Returns the write index of the log buffer: up channel 0 of the RTT control block.
fn log_index(flight: &Flight, node: u8) -> u32 {
    let [_, _, _, _, _, _, _, _, _, write] = words(flight.emulated(node), "_SEGGER_RTT");
    write
}

/// Given a probe that had set the log to blocking mode, when it is removed and the log overflows, then the boards
/// continue.
#[test]
fn pulled_probe_stops_no_board() {
    const BUFFER: u32 = 1024;
    let (mut flight, guest) = Flight::with_guest(&MASTER_AND_THREE, Bus::Nominal);
    flight.fly_to(1_000);
    [1, 2].into_iter().for_each(|node| flight.emulated_mut(node).pull_probe());
    // The master logs each emergency, the slave each telemetry request with a code that it does not know.
    for at in (1_001..3_000).step_by(5) {
        flight.twin.inject(guest, ms(at), WireFrame::standard(0x085, &[0, 0x10, 1, 0, 0, 0, 0, 0]));
        flight.twin.inject(guest, ms(at), WireFrame::standard(0x402, &[0xFF, 0xFF, 0, 0, 0, 0, 0, 0]));
    }
    let mut logged = [0; 2];
    let mut index = [1, 2].map(|node| log_index(&flight, node));
    for until in (1_050..=3_500).step_by(50) {
        flight.fly_to(until);
        for (n, node) in [1, 2].into_iter().enumerate() {
            let next = log_index(&flight, node);
            logged[n] += (next + BUFFER - index[n]) % BUFFER;
            index[n] = next;
        }
    }
    assert!(flight.is_operational(2, Bus::Nominal), "master and slave stand after {logged:?} bytes");
    assert!(logged.iter().all(|bytes| *bytes > BUFFER), "no overflow after {logged:?} bytes");
    let executed = flight.executed(2);
    flight.fly_to(4_500);
    assert!(flight.executed(2) - executed >= 9, "the master sends a command every 100 ms");
    flight.assert_sound();
}

/// Given a started board, then prefetch, instruction cache and data cache are on, with 5 wait states. Revision A of the
/// F405 has no prefetch.
#[test]
fn flash_accelerator_is_on_after_the_start() {
    let [_, slave, other, _] = MASTER_AND_THREE;
    for (name, revision_a, expected) in
        [(PYBOARD_V11, false, 0x705), (NUCLEO_F446RE, false, 0x705), (PYBOARD_V11, true, 0x605)]
    {
        let fittings = Fittings { revision_a, ..Fittings::default() };
        let setups =
            [BoardSetup { board: name, power_on_ms: 0, ..slave }, BoardSetup { power_on_ms: 0, ..other }];
        let mut flight =
            Flight::fitted(&setups, |node| if node == slave.node { fittings } else { Fittings::default() });
        flight.fly_to(30);
        assert_eq!(flight.emulated(slave.node).flash_acr(), expected, "{name}");
        flight.assert_sound();
    }
}

/// Given a flight with each timing of the flash, then frames are equal, and cycles are in the expected order.
#[test]
fn wait_states_cost_cycles_and_the_accelerator_saves_them() {
    let cycles = |timing: FlashTiming| {
        println!("{timing:?}");
        let fittings = Fittings { flash_timing: timing, ..Fittings::default() };
        let mut flight = Flight::fitted(&MASTER_AND_THREE, |_| fittings);
        flight.fly_to(1_000);
        flight.assert_operational(2..=4, Bus::Nominal);
        flight.assert_nothing_lost();
        let slave = flight.emulated(2).counters();
        slave.cycles_awake as f64 / slave.instructions as f64
    };
    let [ideal, set, off] = [FlashTiming::Ideal, FlashTiming::AsSet, FlashTiming::Unaccelerated].map(cycles);
    assert!(ideal < set && set < off, "{ideal} {set} {off} cycles per instruction");
}

/// Given boards on real flash timing, when the flight is repeated, then each frame is sent at the same tick.
#[test]
fn flight_with_wait_states_repeats_to_the_tick() {
    let ends = || {
        let mut flight = Flight::new(&MASTER_AND_THREE);
        flight.fly_to(800);
        flight.frames.iter().map(|seen| seen.end).collect::<Vec<Time>>()
    };
    assert_eq!(ends(), ends());
}
