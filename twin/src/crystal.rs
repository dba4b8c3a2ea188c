//! Crystals: offset, drift, temperature and noise of the oscillator of a board.
//!
//! The fractional frequency y (1e-6 is a part per million) is constant over steps of [`Crystal::STEP`] of virtual time,
//! and depends only on the crystal and the time, not on the program or the quantum of the simulation.

use crate::wire::time::Time;

/// Change of the frequency by a change of temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Start of the change.
    pub from: Time,
    /// End of the change, later than `from`.
    pub to: Time,
    /// Total change, in parts per million, at a constant rate.
    pub ppm: f64,
}

/// An oscillator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crystal {
    /// Frequency error at time zero, in parts per million, within ±1000. Positive: fast.
    pub ppm: f64,
    /// Drift of the error, in parts per million per second.
    pub drift_ppm_per_s: f64,
    /// A change of temperature.
    pub ramp: Option<Ramp>,
    /// White noise of the frequency: its Allan deviation at 1 s, parts per billion.
    pub white_ppb: f64,
    /// Random walk of the frequency: standard deviation of the change in 1 s, parts per billion.
    pub walk_ppb: f64,
    /// Seed of both noises.
    pub seed: u64,
}

impl Crystal {
    /// Length of a step with constant frequency.
    pub const STEP: Time = Time::from_ms(5);

    /// A crystal that is `ppm` parts per million fast for ever.
    pub const fn ppm(ppm: f64) -> Crystal {
        Crystal { ppm, drift_ppm_per_s: 0.0, ramp: None, white_ppb: 0.0, walk_ppb: 0.0, seed: 0 }
    }

    /// Returns whether the frequency is constant.
    pub(crate) fn is_steady(&self) -> bool {
        *self == Crystal { seed: self.seed, ..Crystal::ppm(self.ppm) }
    }

    /// The fractional frequency at `at` without noise.
    fn systematic(&self, at: Time) -> f64 {
        let ramp = self.ramp.map_or(0.0, |ramp| {
            let passed = at.since(ramp.from).0 as f64 / ramp.to.since(ramp.from).0.max(1) as f64;
            ramp.ppm * passed.min(1.0)
        });
        1e-6 * (self.ppm + self.drift_ppm_per_s * at.as_secs_f64() + ramp)
    }

    /// Returns the phase, in seconds ahead, after each step of `span`, beginning with zero at time zero.
    pub fn phase(&self, span: Time) -> Vec<f64> {
        let mut frequency = Frequency::new(*self);
        let mut phase = 0.0;
        let after = (0..(span.0 / Self::STEP.0) as usize).map(|step| {
            phase += frequency.in_step(step) * Self::STEP.as_secs_f64();
            phase
        });
        std::iter::once(0.0).chain(after).collect()
    }

    /// Its Allan deviation over `span`: averaging times in seconds, each twice the one before, and the deviation at each.
    pub fn allan_deviation(&self, span: Time) -> Vec<(f64, f64)> {
        let phase = self.phase(span);
        let averaged = std::iter::successors(Some(1), |count| Some(2 * count));
        averaged
            .take_while(|count| 3 * count < phase.len())
            .map(|count| {
                let tau = count as f64 * Self::STEP.as_secs_f64();
                (tau, deviation(&phase, count, tau))
            })
            .collect()
    }
}

/// The overlapping Allan deviation of samples of the phase at an averaging time of `count` samples, `tau` seconds (IEEE 1139).
fn deviation(phase: &[f64], count: usize, tau: f64) -> f64 {
    let differences = phase.iter().zip(&phase[count..]).zip(&phase[2 * count..]);
    let squares: f64 = differences.map(|((a, b), c)| (c - 2.0 * b + a).powi(2)).sum();
    (squares / (2.0 * tau * tau * (phase.len() - 2 * count) as f64)).sqrt()
}

/// The frequency of a crystal, step by step.
#[derive(Clone, Debug)]
pub(crate) struct Frequency {
    pub(crate) crystal: Crystal,
    random: fastrand::Rng,
    /// Present value of the random walk.
    walk: f64,
    known: Vec<f64>,
}

impl Frequency {
    pub(crate) fn new(crystal: Crystal) -> Self {
        let random = fastrand::Rng::with_seed(crystal.seed);
        Frequency { crystal, random, walk: 0.0, known: Vec::new() }
    }

    /// The fractional frequency in step `step` since time zero.
    pub(crate) fn in_step(&mut self, step: usize) -> f64 {
        let length = Crystal::STEP.as_secs_f64().sqrt();
        while self.known.len() <= step {
            let middle = Time(Crystal::STEP.0 * self.known.len() as u64 + Crystal::STEP.0 / 2);
            let white = self.normal() * 1e-9 * self.crystal.white_ppb / length;
            self.known.push(self.crystal.systematic(middle) + self.walk + white);
            self.walk += self.normal() * 1e-9 * self.crystal.walk_ppb * length;
        }
        self.known[step]
    }

    /// Returns a nearly normal random number with standard deviation 1: the sum of twelve uniform ones. It is the same
    /// on every computer.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.random.f64()).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The deviation at 1.28 s, and at 10.24 s, over 2000 s.
    fn deviations(crystal: Crystal) -> [f64; 2] {
        let all = crystal.allan_deviation(Time::from_ms(2_000_000));
        [1.28, 10.24].map(|tau| all.iter().find(|(at, _)| (at - tau).abs() < 1e-9).unwrap().1)
    }

    fn assert_near(found: [f64; 2], expected: [f64; 2], share: f64) {
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < share, "{found:e} for {expected:e}");
        }
    }

    /// White noise of the frequency: 1 ppb over the root of the averaging time.
    #[test]
    fn white_noise_averages_out() {
        for seed in 0..3 {
            let crystal = Crystal { white_ppb: 1.0, seed, ..Crystal::ppm(30.0) };
            assert_near(deviations(crystal), [0.8839e-9, 0.3125e-9], 0.15);
        }
    }

    /// Random walk of the frequency: 2 ppb times the root of a third of the averaging time.
    #[test]
    fn a_random_walk_grows() {
        for seed in 0..3 {
            let crystal = Crystal { walk_ppb: 2.0, seed, ..Crystal::ppm(-30.0) };
            assert_near(deviations(crystal), [1.306e-9, 3.695e-9], 0.25);
        }
    }

    /// Drift: 0.1 ppm/s times the averaging time over the root of two.
    #[test]
    fn drift_is_proportional_to_the_averaging_time() {
        let crystal = Crystal { drift_ppm_per_s: 0.1, ..Crystal::ppm(50.0) };
        assert_near(deviations(crystal), [90.51e-9, 724.1e-9], 1e-3);
    }

    #[test]
    fn an_offset_alone_has_no_deviation() {
        assert!(deviations(Crystal::ppm(50.0)).into_iter().all(|deviation| deviation < 1e-12));
    }

    /// 10 ppm more between 1 s and 3 s: after 4 s it is ahead by 10 ppm for 1 s and by 5 ppm on average for 2 s.
    #[test]
    fn a_ramp_begins_and_ends() {
        let ramp = Ramp { from: Time::from_ms(1000), to: Time::from_ms(3000), ppm: 10.0 };
        let phase = Crystal { ramp: Some(ramp), ..Crystal::ppm(0.0) }.phase(Time::from_ms(4000));
        assert_eq!(phase[200], 0.0);
        assert!((phase[800] - 20e-6).abs() < 1e-12, "{:e}", phase[800]);
    }

    #[test]
    fn a_seed_gives_one_frequency() {
        let phase = |seed| {
            let crystal = Crystal { white_ppb: 1.0, walk_ppb: 2.0, seed, ..Crystal::ppm(0.0) };
            crystal.phase(Time::from_ms(100))
        };
        assert_eq!(phase(1), phase(1));
        assert_ne!(phase(1), phase(2));
    }
}
