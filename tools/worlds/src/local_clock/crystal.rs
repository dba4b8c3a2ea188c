//! Emulated crystals: offset, drift, white frequency noise and random walk of frequency.

use fastrand::Rng;

/// Properties of a crystal by its data sheet.
#[derive(Clone, Copy, Debug)]
pub struct Data {
    /// Frequency at the beginning, parts per million.
    pub offset_ppm: f64,
    /// Change of the frequency, parts per million in a second.
    pub drift_ppm: f64,
    /// When the drift begins, seconds.
    pub drift_from: f64,
    /// Change with temperature.
    pub warmth: Warmth,
    /// White frequency noise: Allan deviation at one second, parts per billion.
    pub white_ppb: f64,
    /// Random walk of the frequency, parts per billion per root second.
    pub walk_ppb: f64,
}

/// Change of a frequency with temperature.
#[derive(Clone, Copy, Debug)]
pub enum Warmth {
    /// None.
    Steady,
    /// A straight line.
    Ramp {
        /// Begin of the change, seconds.
        from: f64,
        /// Duration of the change, seconds.
        over: f64,
        /// Total change, parts per million.
        ppm: f64,
    },
    /// Up and down in straight lines.
    Cycles {
        /// Amplitude, parts per million: from `-ppm` to `ppm` and back.
        ppm: f64,
        /// Period, seconds.
        period: f64,
    },
    /// A sine.
    Sine {
        /// Amplitude, parts per million.
        ppm: f64,
        /// Period, seconds.
        period: f64,
    },
}

impl Warmth {
    /// Returns the change in parts per million at a time in seconds.
    fn at(self, time: f64) -> f64 {
        match self {
            Warmth::Steady => 0.0,
            Warmth::Ramp { from, over, ppm } => ppm * ((time - from) / over).clamp(0.0, 1.0),
            Warmth::Cycles { ppm, period } => {
                let phase = (time / period).rem_euclid(1.0);
                ppm * if phase < 0.5 { 4.0 * phase - 1.0 } else { 3.0 - 4.0 * phase }
            }
            Warmth::Sine { ppm, period } => ppm * (core::f64::consts::TAU * time / period).sin(),
        }
    }
}

impl Data {
    /// Returns a crystal with the noise of the requirement, and this offset and drift.
    pub fn noisy(offset_ppm: f64, drift_ppm: f64) -> Self {
        Data { offset_ppm, drift_ppm, drift_from: 0.0, warmth: Warmth::Steady, white_ppb: 1.0, walk_ppb: 2.0 }
    }
}

/// Time of a clock that this crystal drives.
#[derive(Clone, Debug)]
pub struct Crystal {
    /// Reading minus true time each 10 ms, nanoseconds.
    ahead: Vec<f64>,
}

/// Nanoseconds between two points of a crystal's history.
pub const GRID: f64 = 10_000_000.0;

impl Crystal {
    /// Runs a crystal for some seconds.
    pub fn run(data: Data, seconds: f64, rng: &mut Rng) -> Self {
        let step = GRID / 1e9;
        let points = (seconds / step).ceil() as usize + 2;
        let (mut ahead, mut walk, mut phase) = (Vec::with_capacity(points), 0.0, 0.0);
        for point in 0..points {
            ahead.push(phase);
            let middle = (point as f64 + 0.5) * step;
            let drifted = data.drift_ppm * (middle - data.drift_from).max(0.0);
            let steady = (data.offset_ppm + drifted + data.warmth.at(middle)) * 1_000.0;
            // On average the integral of a step of the walk is half of it.
            let new_walk = walk + data.walk_ppb * step.sqrt() * normal(rng);
            phase += (steady + (walk + new_walk) / 2.0) * step + data.white_ppb * step.sqrt() * normal(rng);
            walk = new_walk;
        }
        Crystal { ahead }
    }

    /// Returns the reading of the clock at a true time, nanoseconds.
    pub fn reads(&self, time: f64) -> f64 {
        let point = (time / GRID).floor().clamp(0.0, (self.ahead.len() - 2) as f64);
        let (at, part) = (point as usize, time / GRID - point);
        time + self.ahead[at] + (self.ahead[at + 1] - self.ahead[at]) * part
    }

    /// Returns the true time at which the clock shows `reading`, nanoseconds.
    pub fn shows(&self, reading: f64) -> f64 {
        let mut time = reading;
        for _ in 0..6 {
            time -= self.reads(time) - reading;
        }
        time
    }

    /// Overlapping Allan deviation of the frequency at some averaging times: pairs of seconds and 10^-9.
    pub fn allan_deviation(&self, steps: &[usize]) -> Vec<(f64, f64)> {
        let deviation = |&m: &usize| {
            let tau = m as f64 * GRID / 1e9;
            let terms = self.ahead.len().saturating_sub(2 * m);
            let sum: f64 = (0..terms)
                .map(|i| (self.ahead[i + 2 * m] - 2.0 * self.ahead[i + m] + self.ahead[i]).powi(2))
                .sum();
            (tau, (sum / (2.0 * terms as f64)).sqrt() / tau)
        };
        steps.iter().map(deviation).collect()
    }
}

/// A normal variable: mean 0, deviation 1 (Box and Muller).
pub fn normal(rng: &mut Rng) -> f64 {
    let radius = (-2.0 * (1.0 - rng.f64()).ln()).sqrt();
    radius * (core::f64::consts::TAU * rng.f64()).cos()
}
