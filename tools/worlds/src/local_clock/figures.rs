//! Figures of a series of errors.

use crate::local_clock::scenario::Sample;

/// Figures of errors in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Number of errors.
    pub count: usize,
    /// Mean.
    pub mean: f64,
    /// Root mean square.
    pub rms: f64,
    /// Absolute error that 99.9 % do not exceed.
    pub permille: f64,
    /// Largest absolute error.
    pub worst: f64,
}

impl Figures {
    /// Computes the figures of errors in nanoseconds.
    pub fn of(errors: impl IntoIterator<Item = f64>) -> Self {
        let errors: Vec<f64> = errors.into_iter().collect();
        let count = errors.len();
        let mut sizes: Vec<f64> = errors.iter().map(|error| error.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let at = |part: f64| sizes.get(((count as f64 * part).ceil() as usize).saturating_sub(1)).copied();
        Figures {
            count,
            mean: errors.iter().sum::<f64>() / count as f64,
            rms: (errors.iter().map(|error| error * error).sum::<f64>() / count as f64).sqrt(),
            permille: at(0.999).unwrap_or(f64::NAN),
            worst: at(1.0).unwrap_or(f64::NAN),
        }
    }

    /// Computes the figures of the samples from some second on.
    pub fn from(samples: &[Sample], seconds: f64) -> Self {
        Figures::of(samples.iter().filter(|sample| sample.time >= seconds).map(|sample| sample.error))
    }
}
