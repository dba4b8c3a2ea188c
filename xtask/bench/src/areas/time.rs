//! Clocks of slaves against that of the master, by the edges of their pulses.
//!
//! [`crate::clocks`] says what flies. A figure is that of the worst slave over five seeds, from 30 s to 60 s; a pulse every 10 ms
//! meets all phases of the SYNC period. Beside the error of the clocks stand those of the SYNC instants that they are made
//! of, and the physical floor.

use std::thread;

use can_wire::time::Time;
use firmware_images::Images;
use twin::pulses::Errors;

use super::Area;
use crate::clocks::{Flight, PULSE_PERIOD, Scenario};
use crate::context::{Context, FLOWN};
use crate::row::Row;
use demo::stamps::StampErrors;
use support::board::Profile;

pub const AREA: Area =
    Area { name: "time", about: "clocks of three slaves against the master's, five seeds of 60 s", measure };

const SEEDS: u64 = 5;
const SETTLED: Time = Time::from_ms(30_000);
const END: Time = Time::from_ms(60_000);
const SECOND: Time = Time::from_ms(1_000);
const HOLDOVER: Time = Time::from_ms(10_000);

/// Of [`END`] - [`SETTLED`] in all seeds: one pulse may be missing at either end of each.
const SAMPLES: u64 = SEEDS * ((END.0 - SETTLED.0) / PULSE_PERIOD.0 - 2);

/// The bus is cut here, and the clocks are compared from a second before until three seconds after.
const CUT: Time = Time::from_ms(10_000);

/// A capture timer counts at 84 MHz, the spacecraft time has 24 bits of a second: standard deviations of what is rounded, ns.
const CAPTURE_NS: f64 = 1e3 / 84.0 * UNIFORM;
const SCET_NS: f64 = 1e9 / 16_777_216.0 * UNIFORM;
/// Of one unit: one over the root of twelve.
const UNIFORM: f64 = 0.288_675_134_594_812_9;

/// What is flown, the name of its rows, bounds of the root of the mean square and of 99.9 %, ns.
const SCENARIOS: [(&str, Scenario, Option<f64>, Option<f64>); 5] = [
    ("sync_1_load_30", scenario(1_000, 0.30, true, true), Some(100.0), Some(250.0)),
    ("sync_1_load_90", scenario(1_000, 0.90, true, true), Some(100.0), Some(250.0)),
    ("sync_10_load_90", scenario(100, 0.90, true, true), Some(40.0), None),
    ("without_wires_load_90", scenario(1_000, 0.90, false, true), None, Some(5_000.0)),
    ("uncorrected_load_30", scenario(1_000, 0.30, true, false), None, None),
];

const fn scenario(sync_ms: u64, load: f64, wires: bool, corrected: bool) -> Scenario {
    Scenario { sync: Time::from_ms(sync_ms), load, wires, corrected }
}

fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let images = context.images(FLOWN, Profile::Standard)?;
    let mut rows = Vec::new();
    for (name, scenario, rms, most) in SCENARIOS {
        let outcome = over_seeds(|seed| settled(&images, scenario, seed))?;
        rows.extend(outcome.rows(name, rms, most));
    }
    rows.extend(switched(&images)?);
    rows.extend(held_over(&images)?);
    rows.extend([Row::lower("floor_capture", CAPTURE_NS, "ns"), Row::lower("floor_scet", SCET_NS, "ns")]);
    Ok(rows)
}

/// What was found in one flight, or in all.
#[derive(Default)]
struct Outcome {
    slaves: [Errors; 3],
    stamps: StampErrors,
    /// Settings of the clock beyond the first one.
    steps: u64,
}

impl Outcome {
    fn and(self, other: Outcome) -> Outcome {
        let [a, b, c] = self.slaves;
        let [d, e, f] = other.slaves;
        Outcome {
            slaves: [[a, d], [b, e], [c, f]].map(Errors::join),
            stamps: self.stamps.and(&other.stamps),
            steps: self.steps + other.steps,
        }
    }

    /// Of the slave for which it is largest.
    fn worst(&self, figure: impl Fn(&Errors) -> f64) -> f64 {
        self.slaves.iter().map(figure).fold(0.0, f64::max)
    }

    fn rows(&self, name: &str, rms: Option<f64>, most: Option<f64>) -> Vec<Row> {
        let bounded = |row: Row, bound: Option<f64>| match bound {
            Some(bound) => row.within(bound),
            None => row,
        };
        let samples = self.slaves.iter().map(|errors| errors.samples.len() as u64).min().unwrap_or_default();
        let unpaired: u64 = self.slaves.iter().map(|errors| errors.unpaired).sum();
        vec![
            bounded(Row::lower(format!("rms_{name}"), self.worst(Errors::rms_ns), "ns"), rms),
            bounded(
                Row::lower(format!("p999_{name}"), self.worst(|errors| errors.quantile_ns(0.999)), "ns"),
                most,
            ),
            Row::lower(format!("worst_{name}"), self.worst(Errors::worst_ns), "ns"),
            Row::lower(format!("mean_{name}"), self.worst(|errors| errors.mean_ns().abs()), "ns"),
            Row::lower(format!("sync_rms_{name}"), self.stamps.rms_ns(), "ns"),
            Row::higher(format!("samples_{name}"), samples, "pulses").within(SAMPLES),
            Row::lower(format!("unpaired_{name}"), unpaired, "pulses").within(0_u64),
            Row::lower(format!("steps_{name}"), self.steps, "steps").within(0_u64),
        ]
    }
}

/// Flies all seeds, as many at once as the computer has processors.
fn over_seeds(fly: impl Fn(u64) -> anyhow::Result<Outcome> + Sync) -> anyhow::Result<Outcome> {
    let at_once = thread::available_parallelism().map_or(1, |count| count.get() as u64);
    let of_thread = |first: u64| {
        (first..SEEDS)
            .step_by(at_once as usize)
            .map(|seed| Ok((seed, fly(seed)?)))
            .collect::<anyhow::Result<Vec<_>>>()
    };
    let mut outcomes = Vec::new();
    thread::scope(|scope| {
        let threads: Vec<_> = (0..at_once).map(|first| scope.spawn(move || of_thread(first))).collect();
        for thread in threads {
            outcomes.extend(thread.join().map_err(|_| anyhow::anyhow!("a flight panicked"))??);
        }
        anyhow::Ok(())
    })?;
    outcomes.sort_by_key(|(seed, _)| *seed);
    Ok(outcomes.into_iter().fold(Outcome::default(), |all, (_, outcome)| all.and(outcome)))
}

fn settled(images: &Images, scenario: Scenario, seed: u64) -> anyhow::Result<Outcome> {
    let mut flight = Flight::new(images, scenario, seed)?;
    flight.run_until(SETTLED)?;
    let before: u32 = flight.steps()?.iter().sum();
    flight.run_until(END)?;
    let steps = u64::from(flight.steps()?.iter().sum::<u32>() - before);
    Ok(Outcome { slaves: flight.errors(SETTLED, END), stamps: flight.stamps(), steps })
}

/// The nominal bus is cut beside the master: by how much clocks move, against the mean of the second before.
fn switched(images: &Images) -> anyhow::Result<[Row; 1]> {
    let mut flight = Flight::new(images, scenario(100, 0.30, true, true), 0)?;
    flight.run_until(CUT)?;
    flight.cut_beside_master();
    let end = CUT + Time(3 * SECOND.0);
    flight.run_until(end)?;
    let before = flight.errors(CUT - SECOND, CUT).map(|errors| errors.mean_ns());
    let after = flight.errors(CUT, end);
    let moved = after.iter().zip(before).flat_map(|(errors, before)| {
        errors.samples.iter().map(move |sample| (sample.error_ns - before).abs())
    });
    Ok([Row::lower("switch_moved", moved.fold(0.0, f64::max), "ns").within(300.0)])
}

/// No SYNC any more after a minute: largest error after ten seconds, smallest and largest reported bound over the error.
fn held_over(images: &Images) -> anyhow::Result<[Row; 3]> {
    let mut flight = Flight::new(images, scenario(1_000, 0.30, true, true), 0)?;
    flight.run_until(END)?;
    flight.set_sync(Time::ZERO)?;
    flight.run_until(END + HOLDOVER)?;
    let now = END + HOLDOVER;
    let errors = flight.errors(now - SECOND, now).map(|errors| errors.worst_ns());
    let bounds = flight.bounds()?.map(f64::from);
    let outside = errors.iter().zip(bounds).filter(|&(error, bound)| *error > bound).count() as u64;
    Ok([
        Row::lower("holdover_10_s", errors.into_iter().fold(0.0, f64::max), "ns"),
        Row::lower("holdover_10_s_bound", bounds.into_iter().fold(0.0, f64::max), "ns"),
        Row::lower("holdover_10_s_outside", outside, "slaves").within(0_u64),
    ])
}
