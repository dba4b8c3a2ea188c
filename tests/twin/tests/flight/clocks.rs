//! Clocks of slaves against that of the master, by their pulses, with crystals that drift and make noise.
//!
//! Profile `standard`: a SYNC every 100 ms, the spacecraft time every second, a pulse every second. Minutes with five seeds are
//! flown by `cargo xtask bench --only time`.

use can_wire::time::Time;
use can_wire::transceiver::Transceiver;
use twin::board::{AccessError, BoardConfig, Fittings};
use twin::crystal::Crystal;
use twin::peripherals::Pin;
use twin::pulses::{Errors, Trial};
use twin::spacecraft::{BoardId, Bus, Spacecraft, SpacecraftConfig};
use twin::traffic::Traffic;

use crate::craft::*;

const PULSE: Pin = Pin::new('B', 1);
const SETTLED: Time = ms(8_000);
const END: Time = ms(13_500);

/// Metres, parts per million, parts per million per second, loop of the transceivers in nanoseconds.
const PLACES: [(f64, f64, f64, u32); 4] =
    [(0.0, 50.0, -0.1, 165), (1.0, -50.0, 0.1, 133), (10.0, 17.0, -0.1, 170), (20.0, -38.0, 0.1, 150)];

/// The clock of each slave against the master's, from 8 s on.
fn flown(capture_wires: bool) -> [Errors; 3] {
    let mut spacecraft = Spacecraft::new(SpacecraftConfig::default());
    for (seat, (position_m, ppm, drift_ppm_per_s, loop_ns)) in MASTER_AND_THREE.into_iter().zip(PLACES) {
        let crystal = Crystal {
            drift_ppm_per_s,
            white_ppb: 1.0,
            walk_ppb: 2.0,
            seed: u64::from(seat.node),
            ..Crystal::ppm(ppm)
        };
        let transceiver = Some(Transceiver::with_loop(loop_ns));
        let fittings = Fittings { capture_wires, transceiver, ..Fittings::default() };
        spacecraft.add_board(BoardConfig { crystal, position_m, fittings, ..seat.with(&STANDARD) });
    }
    let traffic = Traffic::new(&mut spacecraft, Bus::Nominal, 0.3, 1, ms(1_000));
    let mut trial = Trial::new(spacecraft, PULSE, Some(traffic));
    trial.run_until(END, |_, _| Ok::<_, AccessError>(())).unwrap();
    let second = ms(1_000);
    [1, 2, 3].map(|slave| trial.errors(BoardId(0), BoardId(slave), second, SETTLED, END))
}

/// Given delays that nobody has configured, then clocks are late by the cable, and by half of what their transceivers are slower
/// than the master's.
#[test]
fn pulses_of_slaves_are_late_by_the_cable() {
    let (_, _, _, of_master) = PLACES[0];
    for (errors, (position_m, .., loop_ns)) in flown(true).iter().zip(&PLACES[1..]) {
        let expected = 5.0 * position_m + (f64::from(*loop_ns) - f64::from(of_master)) / 2.0;
        assert!((5..=6).contains(&errors.samples.len()) && errors.unpaired == 0, "{errors:?}");
        assert!((errors.mean_ns() - expected).abs() < 60.0, "{} ns for {expected}", errors.mean_ns());
        let farthest = errors.samples.iter().map(|sample| (sample.error_ns - expected).abs());
        assert!(farthest.fold(0.0, f64::max) < 100.0, "{errors:?}");
    }
}

/// Without the capture wires frames are stamped in their interrupts.
#[test]
fn pulses_without_wires_are_within_5_us() {
    for errors in flown(false) {
        assert!((5..=6).contains(&errors.samples.len()) && errors.unpaired == 0, "{errors:?}");
        assert!(errors.worst_ns() < 5_000.0, "{errors:?}");
        assert!(errors.worst_ns() > 100.0, "nobody captured: {errors:?}");
    }
}
