//! The local clock in simulations, and the crystals of the twin.

use can_twin::crystal::Crystal;
use can_twin::wire::time::Time;
use ecss_can::time::machine::LocalClock;
use ecss_can_cli::fly::drawing::chart::{Curve, Quantity, curves, duration};
use ecss_can_cli::fly::drawing::{Layout, Range};
use ecss_can_worlds::local_clock::trials::STEADY;
use ecss_can_worlds::local_clock::{Sample, Scenario, Stamps};

const SEEDS: u64 = 100;
/// Number of seeds with a separate line.
const SHOWN: usize = 10;

/// Second at which SYNC stops. The number of seconds without it follows.
const SILENT: f64 = 60.0;
const HOLDOVER: f64 = 100.0;

/// Returns names and contents of all pictures.
pub fn pictures() -> Vec<(&'static str, String)> {
    vec![("clock-holdover.svg", holdover()), ("clock-wires.svg", wires()), ("clock-crystals.svg", crystals())]
}

/// Returns the runs of all seeds.
fn runs(scenario: impl Fn(u64) -> Scenario) -> Vec<Vec<Sample>> {
    (0..SEEDS).map(|seed| scenario(seed).run(&mut LocalClock::new(&STEADY))).collect()
}

/// Returns a figure of the samples of all seeds over time. `origin` is zero of the time.
fn over_time(runs: &[Vec<Sample>], origin: f64, figure: impl Fn(&[Sample]) -> f64) -> Vec<(f64, f64)> {
    (0..runs[0].len())
        .map(|point| {
            let samples: Vec<Sample> = runs.iter().map(|samples| samples[point]).collect();
            (samples[0].time - origin, figure(&samples))
        })
        .collect()
}

fn rms(samples: &[Sample]) -> f64 {
    (samples.iter().map(|sample| sample.error.powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
}

fn worst(samples: &[Sample]) -> f64 {
    samples.iter().map(|sample| sample.error.abs()).fold(0.0, f64::max)
}

fn median_bound(samples: &[Sample]) -> f64 {
    let mut bounds: Vec<f64> = samples.iter().map(|sample| sample.bound).collect();
    bounds.sort_by(f64::total_cmp);
    bounds[bounds.len() / 2]
}

fn curve(name: &str, class: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { name: Some(name.into()), class: class.into(), points }
}

/// Errors from 1 ns to 100 us.
const ERROR: Quantity =
    Quantity { title: "error of the clock, without sign", range: Range::Decades(0, 5), text: duration };

/// Errors and bounds without SYNC, from 1 ns to 10 ms.
const HELD: Quantity =
    Quantity { title: "error of the clock, without sign", range: Range::Decades(0, 7), text: duration };

fn seconds(value: f64) -> String {
    format!("{value} s")
}

fn holdover() -> String {
    let runs = runs(|seed| Scenario {
        seconds: SILENT + HOLDOVER + 0.1,
        silent_from: SILENT,
        sampled: 5e8,
        ..Scenario::new(seed)
    });
    let shown: Vec<Vec<Sample>> = runs
        .iter()
        .map(|samples| samples.iter().filter(|sample| sample.time >= SILENT - 10.0).copied().collect())
        .collect();
    let mut drawn: Vec<Curve> = shown[..SHOWN]
        .iter()
        .map(|samples| {
            let points = samples.iter().map(|sample| (sample.time - SILENT, sample.error.abs())).collect();
            Curve { name: None, class: "sky".into(), points }
        })
        .collect();
    drawn[0].name = Some(format!("error, {SHOWN} seeds"));
    drawn.push(curve("largest error of 100 seeds", "blue thick", over_time(&shown, SILENT, worst)));
    drawn.push(curve(
        "median of the reported bounds",
        "amber thick",
        over_time(&shown, SILENT, median_bound),
    ));
    let across = Quantity {
        title: "time since the last SYNC",
        range: Range::Linear(-10.0, HOLDOVER, 10.0),
        text: seconds,
    };
    let title = "Holdover: errors of the clock and the bounds that it reports, without SYNC for 100 s";
    curves(title, Layout::WIDE, [across, HELD], &drawn).standalone()
}

fn wires() -> String {
    let mut drawn = Vec::new();
    for (name, class, stamps) in
        [("with capture wires", "blue", Stamps::Capture), ("without", "amber", Stamps::Interrupt)]
    {
        let mut runs = runs(|seed| Scenario {
            stamps: [stamps; 2],
            seconds: 60.0,
            sampled: 2.5e8,
            ..Scenario::new(seed)
        });
        // The first pair arrives at 1 s.
        runs.iter_mut().for_each(|samples| samples.retain(|sample| sample.time >= 1.2));
        drawn.push(curve(&format!("{name}: rms"), &format!("{class} thick"), over_time(&runs, 0.0, rms)));
        let class = format!("{class} dashed");
        drawn.push(curve(&format!("{name}: largest"), &class, over_time(&runs, 0.0, worst)));
    }
    let across = Quantity {
        title: "time since the slave came up; the first SYNC is at 1 s",
        range: Range::Linear(0.0, 60.0, 5.0),
        text: seconds,
    };
    let title = "Errors of the clock with capture wires and without them, 100 seeds, SYNC 1 Hz";
    curves(title, Layout::WIDE, [across, ERROR], &drawn).standalone()
}

/// White noise of the frequency, parts per billion.
const WHITE: f64 = 1.0;
const WALK: f64 = 2.0;
/// Drift of the frequency, parts per million per second.
const DRIFT: f64 = 0.1;

/// Length of a crystal's history. Averaging times are up to a tenth of it.
const HISTORY: Time = Time::from_ms(1_000_000);

fn crystals() -> String {
    let noisy = Crystal { white_ppb: WHITE, walk_ppb: WALK, ..Crystal::ppm(50.0) };
    let measured = |crystal: Crystal| -> Vec<(f64, f64)> {
        let all = crystal.allan_deviation(HISTORY).into_iter();
        all.filter(|(tau, _)| *tau <= HISTORY.as_secs_f64() / 10.0).collect()
    };
    let formula = |of: fn(f64) -> f64| [0.005, 100.0].map(|tau| (tau, of(tau))).to_vec();
    let drawn = [
        curve("white noise by formula", "green dashed", formula(|tau| WHITE * 1e-9 / tau.sqrt())),
        curve("random walk by formula", "violet dashed", formula(|tau| WALK * 1e-9 * (tau / 3.0).sqrt())),
        curve("drift by formula", "black dashed", formula(|tau| DRIFT * 1e-6 * tau / 2.0_f64.sqrt())),
        curve("white noise and random walk", "blue thick", measured(noisy)),
        curve("with drift", "amber thick", measured(Crystal { drift_ppm_per_s: DRIFT, ..noisy })),
    ];
    let scales = [
        Quantity { title: "averaging time", range: Range::Decades(-3, 2), text: |tau| duration(tau * 1e9) },
        Quantity {
            title: "Allan deviation of the frequency",
            range: Range::Decades(-10, -5),
            text: |deviation| format!("1e{:.0}", deviation.log10()),
        },
    ];
    curves("Allan deviation of the emulated crystals", Layout::WIDE, scales, &drawn).standalone()
}
