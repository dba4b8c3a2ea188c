//! The reported bound (2015h) with crystals, stamps and losses within the limits of the profile.

use ecss_can_worlds::local_clock::trials::TRIALS;

/// Seeds of each trial; the example `bounds` runs a hundred.
const SEEDS: u64 = 4;

/// Given each trial, with a SYNC each second and ten a second, then at most 0.1 % of the samples are outside the bound: one each
/// 10 ms, also right before a pair arrives.
#[test]
fn bound_holds_in_every_trial() {
    for trial in &TRIALS {
        for period in [1e9, 1e8] {
            let samples: Vec<_> = (0..SEEDS).flat_map(|seed| trial.run(seed, period)).collect();
            assert!(samples.len() > 4 * 8_000, "{}: {} samples have a bound", trial.name, samples.len());
            let outside = samples.iter().filter(|sample| sample.error.abs() > sample.bound).count();
            assert!(outside * 1_000 <= samples.len(), "{}: {outside} of {}", trial.name, samples.len());
        }
    }
}

/// Median bounds of the quiet trial with the covariance alone were 149 and 96 ns; three times that is allowed.
#[test]
fn bound_is_tight_in_the_quiet_trial() {
    for (period, most) in [(1e9, 447.0), (1e8, 288.0)] {
        let samples = (0..SEEDS).flat_map(|seed| TRIALS[0].run(seed, period));
        let mut bounds: Vec<f64> =
            samples.filter(|sample| sample.time >= 30.0).map(|sample| sample.bound).collect();
        bounds.sort_by(f64::total_cmp);
        let median = bounds[bounds.len() / 2];
        assert!(median <= most, "{median} ns");
    }
}
