//! Clocks of slaves without SYNC: their errors by the edges of their pulses, and the bounds that they report (2015h).
//!
//! [`crate::bench::clocks`] describes the flight. The crystals drift as required until 10 s after the last SYNC, so
//! that each pair of them changes by the 2 ppm of the default profile, and keep their frequency afterwards.

use can_twin::pulses::Sample;
use can_twin::wire::time::Time;
use ecss_can_cli::images::Images;
use ecss_can_cli::images::support::board::Profile;

use super::time::{in_all_seeds, seconds};
use crate::bench::clocks::{Crystals, Flight, Scenario, Wires};
use crate::bench::context::{Context, FLOWN};
use crate::bench::row::Row;

/// Second from which the master sends no SYNC.
const SILENT: u64 = 30;
/// Number of flights.
const SEEDS: u64 = 5;
/// Length of a flight without SYNC, seconds.
const LENGTH: u64 = 100;

const SCENARIO: Scenario = Scenario {
    sync: Time::from_ms(1_000),
    load: 0.30,
    wires: Wires::All,
    corrected: true,
    crystals: Crystals::Settling(seconds(SILENT + 10)),
};

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let images = context.images(&FLOWN, Profile::Standard)?;
    let flights = in_all_seeds(SEEDS, |seed| hold_over(&images, seed))?;
    let mut rows = Vec::new();
    for count in [10, LENGTH] {
        let end = (SILENT + count) as f64;
        let held = || flights.iter().flatten().filter(move |pulse| pulse.at < end);
        let error = held().map(|pulse| pulse.error_ns).fold(0.0, f64::max);
        let bound = held().map(|pulse| pulse.bound_ns).fold(0.0, f64::max);
        let outside = held().filter(|pulse| pulse.error_ns > pulse.bound_ns).count() as u64;
        let name = |value: &str| format!("{count}_s_{value}");
        rows.extend([
            Row::lower(name("error"), error, "ns"),
            Row::lower(name("bound"), bound, "ns"),
            Row::lower(name("outside"), outside, "pulses").within(0_u64),
            Row::higher(name("pulses"), held().count() as u64, "pulses").within(3 * SEEDS * (count - 1)),
        ]);
    }
    Ok(rows)
}

/// A pulse of a slave in holdover.
struct Held {
    /// Seconds since the start of the simulation.
    at: f64,
    /// Absolute error of its clock.
    error_ns: f64,
    /// Bound that the slave reported at the start of that second.
    bound_ns: f64,
}

/// Returns the pulses of all slaves without SYNC, one per second.
fn hold_over(images: &Images, seed: u64) -> anyhow::Result<Vec<Held>> {
    let mut flight = Flight::new(images, SCENARIO, seed)?;
    flight.run_until(seconds(SILENT))?;
    flight.set_sync(Time::ZERO)?;
    let mut pulses = Vec::new();
    for second in SILENT..SILENT + LENGTH {
        let bounds = flight.bounds()?.map(f64::from);
        flight.run_until(seconds(second + 1))?;
        let errors = flight.errors(seconds(second), seconds(second + 1));
        pulses.extend(errors.iter().zip(bounds).flat_map(|(errors, bound_ns)| {
            let held =
                move |sample: &Sample| Held { at: sample.at, error_ns: sample.error_ns.abs(), bound_ns };
            errors.samples.iter().map(held)
        }));
    }
    Ok(pulses)
}
