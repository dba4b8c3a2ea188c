//! Errors of slaves' clocks relative to the master, by the edges of their pulses.
//!
//! [`crate::bench::clocks`] describes the flight. A figure is that of the worst slave over five seeds, from 30 s to 60
//! s. Pulses every 10 ms are at all phases of the SYNC period. Other rows are the errors of the SYNC instants on which
//! the clocks are based, the physical floor, and the cycles of one update ([`crate::bench::update`]).

use std::thread;

use can_twin::pulses::Errors;
use can_twin::wire::time::Time;
use ecss_can_cli::fly::stamps::StampErrors;
use ecss_can_cli::images::Images;
use ecss_can_cli::images::support::board::Profile;

use crate::bench::clocks::{Crystals, Flight, PULSE_PERIOD, Scenario, Wires, most_left_ns};
use crate::bench::context::{Context, FLOWN};
use crate::bench::row::Row;
use crate::bench::update;

const SEEDS: u64 = 5;
const SECOND: Time = Time::from_ms(1_000);
/// Time by which pulses are requested before their comparison.
const PREPARED: Time = Time::from_ms(2_000);

/// Seconds in which pulses are compared. The clocks have settled by then.
const SPAN: [u64; 2] = [30, 60];

/// Second of the cut. The clocks are compared from two seconds before until five seconds after it.
const CUT: u64 = 30;
const BEFORE_CUT: u64 = 2;
const AFTER_CUT: u64 = 5;

/// Standard deviation of rounding, ns. A capture timer counts at 84 MHz, and the spacecraft time has 24 bits of a
/// second.
const CAPTURE_NS: f64 = 1e3 / 84.0 * UNIFORM;
const SCET_NS: f64 = 1e9 / 16_777_216.0 * UNIFORM;
/// Standard deviation of the rounding of one unit: one over the root of twelve.
const UNIFORM: f64 = 0.288_675_134_594_812_9;

/// Case that is flown with all seeds.
struct Case {
    /// End of the names of its rows.
    name: &'static str,
    scenario: Scenario,
    /// Bound of the root mean square, ns. That of 99.9 % follows.
    rms: Option<f64>,
    most: Option<f64>,
}

const CASES: [Case; 7] = [
    case("sync_1_load_30", scenario(1_000, 0.30, true, true), Some(100.0), Some(250.0)),
    case("sync_1_load_90", scenario(1_000, 0.90, true, true), Some(100.0), Some(250.0)),
    case("sync_10_load_30", scenario(100, 0.30, true, true), Some(40.0), None),
    case("sync_10_load_90", scenario(100, 0.90, true, true), Some(40.0), None),
    case("without_wires_load_30", scenario(1_000, 0.30, false, true), None, Some(5_000.0)),
    case("without_wires_load_90", scenario(1_000, 0.90, false, true), None, Some(5_000.0)),
    case("uncorrected_load_30", scenario(1_000, 0.30, true, false), None, None),
];

const fn case(name: &'static str, scenario: Scenario, rms: Option<f64>, most: Option<f64>) -> Case {
    Case { name, scenario, rms, most }
}

const fn scenario(sync_ms: u64, load: f64, are_wired: bool, corrected: bool) -> Scenario {
    let wires = if are_wired { Wires::All } else { Wires::None };
    Scenario { sync: Time::from_ms(sync_ms), load, wires, corrected, crystals: Crystals::Required }
}

/// SYNC periods of the flights in which the nominal bus is cut, ms.
const SWITCHES: [(&str, u64); 2] = [("sync_1", 1_000), ("sync_10", 100)];

/// Measures an update of the clock, the floors, then each case and each change of the bus.
pub fn measure(context: &Context) -> anyhow::Result<Vec<Row>> {
    let mut rows = update::rows(context)?;
    rows.extend([
        Row::lower("floor_capture", CAPTURE_NS, "ns"),
        Row::lower("floor_scet", SCET_NS, "ns"),
        Row::lower("floor_propagation", most_left_ns(), "ns"),
    ]);
    let images = context.images(&FLOWN, Profile::Standard)?;
    for case in &CASES {
        let outcome = in_all_seeds(SEEDS, |seed| compared(&images, case.scenario, seed))?;
        rows.extend(outcome.into_iter().fold(Outcome::default(), Outcome::and).rows(case));
    }
    for switch in &SWITCHES {
        rows.extend(switched(&images, switch)?);
    }
    Ok(rows)
}

/// Converts seconds to a time.
pub const fn seconds(count: u64) -> Time {
    Time(count * SECOND.0)
}

/// Number of pulses to compare in all flights. One may be missing at either end of each.
const SAMPLES: u64 = SEEDS * ((SPAN[1] - SPAN[0]) * SECOND.0 / PULSE_PERIOD.0 - 2);

/// Results of one flight, or of all.
#[derive(Default)]
struct Outcome {
    slaves: [Errors; 3],
    stamps: StampErrors,
    /// Number of settings of the clock after the first one.
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

    /// Returns the figure of the slave for which it is largest.
    fn worst(&self, figure: impl Fn(&Errors) -> f64) -> f64 {
        self.slaves.iter().map(figure).fold(0.0, f64::max)
    }

    fn rows(&self, &Case { name, rms, most, .. }: &Case) -> Vec<Row> {
        let bounded = |what: &str, value: f64, bound: Option<f64>| {
            Row::lower(format!("{what}_{name}"), value, "ns").within_any(bound)
        };
        let found = self.slaves.iter().map(|errors| errors.samples.len() as u64).min().unwrap_or_default();
        let unpaired: u64 = self.slaves.iter().map(|errors| errors.unpaired).sum();
        let mut rows = vec![
            bounded("rms", self.worst(Errors::rms_ns), rms),
            bounded("p999", self.worst(|errors| errors.quantile_ns(0.999)), most),
            bounded("worst", self.worst(Errors::worst_ns), None),
            bounded("mean", self.worst(|errors| errors.mean_ns().abs()), None),
            Row::higher(format!("samples_{name}"), found, "pulses").within(SAMPLES),
            Row::lower(format!("unpaired_{name}"), unpaired, "pulses").within(0_u64),
            Row::lower(format!("steps_{name}"), self.steps, "steps").within(0_u64),
        ];
        // Without the wires there are no stamps.
        if self.stamps.compared > 0 {
            rows.push(bounded("sync_rms", self.stamps.rms_ns(), None));
        }
        rows
    }
}

/// Flies all seeds at once. The results are in their order.
pub(super) fn in_all_seeds<T: Send>(
    seeds: u64,
    fly: impl Fn(u64) -> anyhow::Result<T> + Sync,
) -> anyhow::Result<Vec<T>> {
    let fly = &fly;
    thread::scope(|scope| {
        let flights: Vec<_> = (0..seeds).map(|seed| scope.spawn(move || fly(seed))).collect();
        let ends = flights.into_iter().map(|flight| flight.join());
        ends.map(|end| end.map_err(|_| anyhow::anyhow!("a flight panicked"))?).collect()
    })
}

/// Flies until the end of [`SPAN`].
fn compared(images: &Images, scenario: Scenario, seed: u64) -> anyhow::Result<Outcome> {
    let mut flight = Flight::new(images, scenario, seed)?;
    let [from, to] = SPAN.map(seconds);
    flight.run_until(from - PREPARED)?;
    flight.begin_pulses()?;
    let before: u32 = flight.steps()?.iter().sum();
    flight.run_until(to + Time(SECOND.0 / 10))?;
    let steps = u64::from(flight.steps()?.iter().sum::<u32>() - before);
    Ok(Outcome { slaves: flight.errors(from, to), stamps: flight.stamps(), steps })
}

/// Returns the errors of the three clocks in the first flight of the first case.
///
/// # Errors
/// When the images cannot be built or run.
pub fn clock_errors() -> anyhow::Result<[Errors; 3]> {
    let images = Context::default().images(&FLOWN, Profile::Standard)?;
    Ok(compared(&images, CASES[0].scenario, 0)?.slaves)
}

/// Returns the rows of a cut of the nominal bus next to the master.
fn switched(images: &Images, &(name, sync_ms): &(&str, u64)) -> anyhow::Result<Vec<Row>> {
    let flights = in_all_seeds(SEEDS, |seed| switch(images, scenario(sync_ms, 0.30, true, true), seed))?;
    let moved = flights.iter().map(|(moved, _)| *moved).fold(0.0, f64::max);
    let unpaired: u64 = flights.iter().map(|(_, unpaired)| unpaired).sum();
    Ok(vec![
        Row::lower(format!("switch_moved_{name}"), moved, "ns").within(300.0),
        Row::lower(format!("switch_unpaired_{name}"), unpaired, "pulses").within(0_u64),
    ])
}

/// Returns the largest difference of a clock from its mean before the cut, ns, and the number of pulses without a
/// partner.
fn switch(images: &Images, scenario: Scenario, seed: u64) -> anyhow::Result<(f64, u64)> {
    let mut flight = Flight::new(images, scenario, seed)?;
    flight.run_until(seconds(CUT - BEFORE_CUT) - PREPARED)?;
    flight.begin_pulses()?;
    flight.run_until(seconds(CUT))?;
    flight.cut_beside_master();
    flight.run_until(seconds(CUT + AFTER_CUT) + Time(SECOND.0 / 10))?;
    let before = flight.errors(seconds(CUT - BEFORE_CUT), seconds(CUT)).map(|errors| errors.mean_ns());
    let after = flight.errors(seconds(CUT), seconds(CUT + AFTER_CUT));
    let moved = after.iter().zip(before).flat_map(|(errors, before)| {
        errors.samples.iter().map(move |sample| (sample.error_ns - before).abs())
    });
    Ok((moved.fold(0.0, f64::max), after.iter().map(|errors| errors.unpaired).sum()))
}
