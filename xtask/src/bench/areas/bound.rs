//! The error bound that clocks report (2015h), against their errors by the edges of their pulses.
//!
//! [`crate::bench::clocks`] describes the flight. A pulse each 10 ms is compared with the bound that its slave reported
//! last, at most 20 ms before. `cargo run --release -p ecss-can-worlds --example bounds` has more cases and a hundred
//! seeds, without boards.

use std::collections::VecDeque;

use can_twin::wire::time::Time;
use ecss_can_cli::images::Images;
use ecss_can_cli::images::support::board::Profile;

use super::time::in_all_seeds;
use crate::bench::clocks::{Crystals, Flight, PULSE_PERIOD, Scenario, Wires};
use crate::bench::context::{Context, FLOWN};
use crate::bench::row::Row;

const SEEDS: u64 = 2;
/// Start of the comparison of pulses.
const FROM: Time = Time::from_ms(30_000);
const TO: Time = Time::from_ms(50_000);
/// Time by which pulses are requested before their comparison.
const PREPARED: Time = Time::from_ms(2_000);
/// Period of reads of bounds, without the time of a read.
const POLLED: Time = Time::from_ms(10);

const CASES: [(&str, Scenario); 4] = [
    ("ramp", Scenario { crystals: Crystals::Ramp, ..QUIET }),
    ("far", Scenario { crystals: Crystals::Far, ..QUIET }),
    ("uncorrected", Scenario { corrected: false, ..QUIET }),
    ("master_without_wires", Scenario { wires: Wires::Slaves, ..QUIET }),
];

const QUIET: Scenario = Scenario {
    sync: Time::from_ms(1_000),
    load: 0.30,
    wires: Wires::All,
    corrected: true,
    crystals: Crystals::Required,
};

/// A pulse: its error without sign, and the bound before it, ns.
type Pulse = (f64, f64);

pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let images = context.images(&FLOWN, Profile::Standard)?;
    let rows = CASES.into_iter().map(|(name, scenario)| case(&images, name, scenario));
    Ok(rows.collect::<anyhow::Result<Vec<_>>>()?.concat())
}

fn case(images: &Images, name: &str, scenario: Scenario) -> anyhow::Result<Vec<Row>> {
    let flights = in_all_seeds(SEEDS, |seed| fly(images, scenario, seed))?;
    let pulses: Vec<Pulse> = flights.into_iter().flatten().collect();
    let mut bounds: Vec<f64> = pulses.iter().map(|(_, bound)| *bound).collect();
    bounds.sort_by(f64::total_cmp);
    let median = bounds.get(bounds.len() / 2).copied().unwrap_or(f64::NAN);
    let outside = pulses.iter().filter(|(error, bound)| error > bound).count() as u64;
    let worst = pulses.iter().map(|(error, _)| *error).fold(0.0, f64::max);
    let expected = SEEDS * 3 * ((TO.0 - FROM.0) / PULSE_PERIOD.0 - 2);
    Ok(vec![
        Row::lower(format!("{name}_outside"), outside, "pulses").within(pulses.len() as u64 / 1_000),
        Row::lower(format!("{name}_median"), median, "ns"),
        Row::lower(format!("{name}_worst_error"), worst, "ns"),
        Row::higher(format!("{name}_pulses"), pulses.len() as u64, "pulses").within(expected),
    ])
}

/// Returns the pulses of all slaves.
fn fly(images: &Images, scenario: Scenario, seed: u64) -> anyhow::Result<Vec<Pulse>> {
    let mut flight = Flight::new(images, scenario, seed)?;
    flight.run_until(FROM - PREPARED)?;
    flight.begin_pulses()?;
    flight.run_until(FROM - POLLED)?;
    let mut reports: [VecDeque<(f64, f64)>; 3] = Default::default();
    while flight.now() < TO {
        let at = seconds(flight.now());
        let bounds = flight.bounds()?;
        reports.iter_mut().zip(bounds).for_each(|(reports, bound)| reports.push_back((at, bound.into())));
        let next = flight.now() + POLLED;
        flight.run_until(next)?;
    }
    let errors = flight.errors(FROM, TO);
    Ok(errors
        .iter()
        .zip(&mut reports)
        .flat_map(|(errors, reports)| {
            let bounded = |at| {
                while reports.get(1).is_some_and(|(read, _)| *read <= at) {
                    reports.pop_front();
                }
                reports.front().map_or(0.0, |(_, bound)| *bound)
            };
            let mut bounded = bounded;
            let pulses = errors.samples.iter().map(|sample| (sample.error_ns.abs(), bounded(sample.at)));
            pulses.collect::<Vec<_>>()
        })
        .collect())
}

fn seconds(time: Time) -> f64 {
    time.as_secs_f64()
}
