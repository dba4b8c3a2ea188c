//! Prints the figures of `docs/decisions/clock-estimator.md`: `cargo run --release -p ecss-can-worlds --example figures`.

use ecss_can::time::machine::LocalClock;
use ecss_can_worlds::local_clock::trials::STEADY;
use ecss_can_worlds::local_clock::{Figures, Sample, Scenario, Stamps};

const SEEDS: u64 = 100;

/// Samples of all seeds from 30 s on, as a row of a table.
fn row(name: &str, scenario: impl Fn(u64) -> Scenario) {
    let runs: Vec<Vec<Sample>> =
        (0..SEEDS).map(|seed| scenario(seed).run(&mut LocalClock::new(&STEADY))).collect();
    let worst = runs.iter().map(|samples| Figures::from(samples, 30.0).rms).fold(0.0, f64::max);
    let late = runs.iter().flatten().filter(|sample| sample.time >= 30.0);
    let figures = Figures::of(late.map(|sample| sample.error));
    println!("| {name} | {:.1} | {worst:.1} | {:.1} | {:.1} |", figures.rms, figures.permille, figures.worst);
}

fn accuracy() {
    println!("| scenario | rms | rms of the worst seed | 99.9 % | largest |");
    let hertz = |period: f64| move |seed| Scenario { period, ..Scenario::new(seed) };
    row("SYNC 1 Hz", hertz(1e9));
    row("SYNC 10 Hz", hertz(1e8));
    row("SYNC 10 Hz, time PDO with each tenth", |seed| Scenario { divider: 10, ..hertz(1e8)(seed) });
    row("SYNC 100 Hz", hertz(1e7));
    row("SYNC 1 Hz, 30 % of the pairs lost", |seed| Scenario { lost: 0.3, ..Scenario::new(seed) });
    let interrupt =
        |period: f64| move |seed| Scenario { stamps: [Stamps::Interrupt; 2], ..hertz(period)(seed) };
    row("interrupt stamps, SYNC 1 Hz", interrupt(1e9));
    row("interrupt stamps, SYNC 10 Hz", interrupt(1e8));
}

fn dither() {
    println!("| SYNC is late by | 1 Hz: rms | worst seed | 99.9 % | largest |");
    for (name, jitter, dither) in [
        ("nothing", 0.0, 1),
        ("up to 50 ns", 50.0, 1),
        ("up to 200 ns", 200.0, 1),
        ("up to 20 µs", 20_000.0, 1),
        ("0 to 3 µs by dither", 0.0, 4),
        ("0 to 15 µs by dither", 0.0, 16),
        ("0 to 63 µs by dither", 0.0, 64),
    ] {
        for (rate, period) in [("1 Hz", 1e9), ("10 Hz", 1e8)] {
            let scenario = |seed| Scenario { jitter, dither, period, ..Scenario::new(seed) };
            row(&format!("{name}, {rate}"), scenario);
        }
    }
}

fn holdover() {
    println!("| holdover | rms | largest error | median bound | samples outside |");
    for (name, stamps, period) in [
        ("1 Hz", Stamps::Capture, 1e9),
        ("10 Hz", Stamps::Capture, 1e8),
        ("interrupt stamps, 1 Hz", Stamps::Interrupt, 1e9),
    ] {
        for hold in [10.0, 100.0] {
            let scenario = |seed| {
                let seconds = 60.0 + hold + 0.01;
                Scenario { stamps: [stamps; 2], period, seconds, silent_from: 60.0, ..Scenario::new(seed) }
            };
            let runs: Vec<Vec<Sample>> =
                (0..SEEDS).map(|seed| scenario(seed).run(&mut LocalClock::new(&STEADY))).collect();
            let held = runs.iter().flatten().filter(|sample| sample.time >= 60.0);
            let outside = held.filter(|sample| sample.error.abs() > sample.bound).count();
            let last: Vec<&Sample> = runs.iter().filter_map(|samples| samples.last()).collect();
            let figures = Figures::of(last.iter().map(|sample| sample.error));
            let mut bounds: Vec<f64> = last.iter().map(|sample| sample.bound).collect();
            bounds.sort_by(f64::total_cmp);
            let median = bounds[bounds.len() / 2];
            println!(
                "| {hold} s after 60 s, {name} | {:.0} | {:.0} | {median:.0} | {outside} |",
                figures.rms, figures.worst
            );
        }
    }
}

fn main() {
    accuracy();
    dither();
    holdover();
}
