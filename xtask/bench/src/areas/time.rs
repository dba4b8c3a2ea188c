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
use crate::clocks::{Flight, PULSE_PERIOD, Scenario, most_left_ns};
use crate::context::{Context, FLOWN};
use crate::row::Row;
use demo::stamps::StampErrors;
use support::board::Profile;

pub const AREA: Area =
    Area { name: "time", about: "clocks of three slaves against the master's, five seeds of 60 s", measure };

const SEEDS: u64 = 5;
const SECOND: Time = Time::from_ms(1_000);
/// Before pulses are compared, they are asked for.
const PREPARED: Time = Time::from_ms(2_000);
const HOLDOVER: Time = Time::from_ms(10_000);

/// When pulses are compared, seconds.
type Span = [u64; 2];
/// By then the clocks have settled.
const SETTLED: Span = [30, 60];
const SOON: Span = [10, 30];

/// The bus is cut at this second; the clocks are compared from a second before until three seconds after.
const CUT: u64 = 12;

/// A capture timer counts at 84 MHz, the spacecraft time has 24 bits of a second: standard deviations of what is rounded, ns.
const CAPTURE_NS: f64 = 1e3 / 84.0 * UNIFORM;
const SCET_NS: f64 = 1e9 / 16_777_216.0 * UNIFORM;
/// Of one unit: one over the root of twelve.
const UNIFORM: f64 = 0.288_675_134_594_812_9;

/// What is flown in all seeds.
struct Case {
    /// Ends the names of its rows.
    name: &'static str,
    scenario: Scenario,
    span: Span,
    /// Bounds of the root of the mean square and of 99.9 %, ns.
    rms: Option<f64>,
    most: Option<f64>,
}

const CASES: [Case; 7] = [
    Case {
        name: "sync_1_load_30",
        scenario: scenario(1_000, 0.30, true, true),
        span: SETTLED,
        rms: Some(100.0),
        most: Some(250.0),
    },
    Case {
        name: "sync_1_load_90",
        scenario: scenario(1_000, 0.90, true, true),
        span: SETTLED,
        rms: Some(100.0),
        most: Some(250.0),
    },
    Case {
        name: "sync_10_load_30",
        scenario: scenario(100, 0.30, true, true),
        span: SOON,
        rms: Some(40.0),
        most: None,
    },
    Case {
        name: "sync_10_load_90",
        scenario: scenario(100, 0.90, true, true),
        span: SOON,
        rms: Some(40.0),
        most: None,
    },
    Case {
        name: "without_wires_load_30",
        scenario: scenario(1_000, 0.30, false, true),
        span: SOON,
        rms: None,
        most: Some(5_000.0),
    },
    Case {
        name: "without_wires_load_90",
        scenario: scenario(1_000, 0.90, false, true),
        span: SOON,
        rms: None,
        most: Some(5_000.0),
    },
    Case {
        name: "uncorrected_load_30",
        scenario: scenario(1_000, 0.30, true, false),
        span: SOON,
        rms: None,
        most: None,
    },
];

const fn scenario(sync_ms: u64, load: f64, wires: bool, corrected: bool) -> Scenario {
    Scenario { sync: Time::from_ms(sync_ms), load, wires, corrected }
}

fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let images = context.images(FLOWN, Profile::Standard)?;
    let mut rows = Vec::new();
    for case in &CASES {
        let outcome = over_seeds(|seed| compared(&images, case.scenario, case.span, seed))?;
        rows.extend(outcome.rows(case));
    }
    rows.extend(switched(&images)?);
    rows.extend(held_over(&images)?);
    rows.extend([
        Row::lower("floor_capture", CAPTURE_NS, "ns"),
        Row::lower("floor_scet", SCET_NS, "ns"),
        Row::lower("floor_propagation", most_left_ns(), "ns"),
    ]);
    Ok(rows)
}

const fn seconds(count: u64) -> Time {
    Time(count * SECOND.0)
}

/// Pulses to compare in all flights: one may be missing at either end of each.
const fn samples([from, to]: Span) -> u64 {
    SEEDS * ((to - from) * SECOND.0 / PULSE_PERIOD.0 - 2)
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

    fn rows(&self, &Case { name, span, rms, most, .. }: &Case) -> Vec<Row> {
        let bounded = |what: &str, value: f64, bound: Option<f64>| {
            let row = Row::lower(format!("{what}_{name}"), value, "ns");
            bound.map_or(row.clone(), |bound| row.within(bound))
        };
        let found = self.slaves.iter().map(|errors| errors.samples.len() as u64).min().unwrap_or_default();
        let unpaired: u64 = self.slaves.iter().map(|errors| errors.unpaired).sum();
        let mut rows = vec![
            bounded("rms", self.worst(Errors::rms_ns), rms),
            bounded("p999", self.worst(|errors| errors.quantile_ns(0.999)), most),
            bounded("worst", self.worst(Errors::worst_ns), None),
            bounded("mean", self.worst(|errors| errors.mean_ns().abs()), None),
            Row::higher(format!("samples_{name}"), found, "pulses").within(samples(span)),
            Row::lower(format!("unpaired_{name}"), unpaired, "pulses").within(0_u64),
            Row::lower(format!("steps_{name}"), self.steps, "steps").within(0_u64),
        ];
        // Without the wires there are none.
        if self.stamps.compared > 0 {
            rows.push(bounded("sync_rms", self.stamps.rms_ns(), None));
        }
        rows
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

/// Flies until `span` is over.
fn compared(images: &Images, scenario: Scenario, span: Span, seed: u64) -> anyhow::Result<Outcome> {
    let mut flight = Flight::new(images, scenario, seed)?;
    let [from, to] = span.map(seconds);
    flight.run_until(from - PREPARED)?;
    flight.begin_pulses()?;
    let before: u32 = flight.steps()?.iter().sum();
    flight.run_until(to + Time(SECOND.0 / 10))?;
    let steps = u64::from(flight.steps()?.iter().sum::<u32>() - before);
    Ok(Outcome { slaves: flight.errors(from, to), stamps: flight.stamps(), steps })
}

/// The nominal bus is cut beside the master: by how much clocks move, against the mean of the second before.
fn switched(images: &Images) -> anyhow::Result<[Row; 2]> {
    let mut flight = Flight::new(images, scenario(100, 0.30, true, true), 0)?;
    flight.begin_pulses()?;
    flight.run_until(seconds(CUT))?;
    flight.cut_beside_master();
    flight.run_until(seconds(CUT + 4))?;
    let before = flight.errors(seconds(CUT - 1), seconds(CUT)).map(|errors| errors.mean_ns());
    let after = flight.errors(seconds(CUT), seconds(CUT + 3));
    let moved = after.iter().zip(before).flat_map(|(errors, before)| {
        errors.samples.iter().map(move |sample| (sample.error_ns - before).abs())
    });
    let unpaired: u64 = after.iter().map(|errors| errors.unpaired).sum();
    Ok([
        Row::lower("switch_moved", moved.fold(0.0, f64::max), "ns").within(300.0),
        Row::lower("switch_unpaired", unpaired, "pulses").within(0_u64),
    ])
}

/// No SYNC after half a minute: errors and reported bounds ten seconds later.
fn held_over(images: &Images) -> anyhow::Result<[Row; 3]> {
    let mut flight = Flight::new(images, scenario(1_000, 0.30, true, true), 0)?;
    flight.run_until(seconds(30))?;
    flight.set_sync(Time::ZERO)?;
    flight.run_until(seconds(30) + HOLDOVER - PREPARED)?;
    flight.begin_pulses()?;
    flight.run_until(seconds(30) + HOLDOVER)?;
    let bounds = flight.bounds()?.map(f64::from);
    let now = flight.now();
    flight.run_until(now + SECOND)?;
    let errors = flight.errors(now, now + SECOND - PULSE_PERIOD).map(|errors| errors.worst_ns());
    let outside = errors.iter().zip(bounds).filter(|&(error, bound)| *error > bound).count() as u64;
    Ok([
        Row::lower("holdover_10_s", errors.into_iter().fold(0.0, f64::max), "ns"),
        Row::lower("holdover_10_s_bound", bounds.into_iter().fold(0.0, f64::max), "ns"),
        Row::lower("holdover_10_s_outside", outside, "slaves").within(0_u64),
    ])
}
