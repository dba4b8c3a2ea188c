//! Random bit errors: inverted microseconds at random nodes.

use crate::wire::fault::{Effect, Fault, Nodes};
use crate::wire::time::{TICKS_PER_US, Time};

/// A Poisson process of disturbances.
#[derive(Clone, Debug)]
pub(in crate::wire) struct BitErrors {
    rng: fastrand::Rng,
    /// Mean distance between two disturbances anywhere, ticks.
    mean: f64,
    pub(in crate::wire) next: Time,
}

impl BitErrors {
    /// Makes the process: each of `nodes` nodes sees each microsecond inverted with probability `rate`. Returns `None`
    /// for a rate of zero.
    pub(in crate::wire) fn new(rate: f64, seed: u64, now: Time, nodes: usize) -> Option<Self> {
        if rate == 0.0 || nodes == 0 {
            return None;
        }
        let mean = TICKS_PER_US as f64 / (rate * nodes as f64);
        let mut errors = BitErrors { rng: fastrand::Rng::with_seed(seed), mean, next: now };
        errors.plan();
        Some(errors)
    }

    /// Returns the present disturbance and schedules the next one.
    pub(in crate::wire) fn strike(&mut self, nodes: usize) -> Fault {
        let node = self.rng.usize(..nodes);
        self.plan();
        Fault::Glitch { nodes: Nodes::of(&[node]), duration: Time(TICKS_PER_US), effect: Effect::Invert }
    }

    fn plan(&mut self) {
        let gap = -(1.0 - self.rng.f64()).ln() * self.mean;
        self.next += Time((gap as u64).max(1));
    }
}
