//! Least squares over a window with rejection of outliers: what the clock's filter is compared with.

use std::collections::VecDeque;

use ecss_can::time::TimeSource;
use ecss_can::types::{FineInstant, FineScet};

use crate::local_clock::follower::Follower;

/// A parabola through the last pairs. Those that are off by more than four times the median are left out. In floating point.
#[derive(Clone, Debug)]
pub struct Window {
    length: usize,
    pairs: VecDeque<(FineInstant, FineScet)>,
    /// Offset, rate and half of the drift at the last pair: nanoseconds, per second, per square second.
    fit: [f64; 3],
}

impl Window {
    /// Of so many pairs.
    pub fn new(length: usize) -> Self {
        Window { length, pairs: VecDeque::new(), fit: [0.0; 3] }
    }

    /// The pairs relative to the last: seconds of the node, and nanoseconds that spacecraft time is ahead of them.
    fn points(&self) -> Vec<(f64, f64)> {
        let Some(&(last, scet)) = self.pairs.back() else { return Vec::new() };
        let point = |&(at, value): &(FineInstant, FineScet)| {
            let seconds = at.units().wrapping_sub(last.units()) as i64 as f64 / 256e6;
            (seconds, value.since(scet) as f64 / 4.294967296 - seconds * 1e9)
        };
        self.pairs.iter().map(point).collect()
    }
}

impl Follower for Window {
    fn pair(&mut self, at: FineInstant, scet: FineScet, _: TimeSource, _: FineInstant) {
        self.pairs.push_back((at, scet));
        if self.pairs.len() > self.length {
            self.pairs.pop_front();
        }
        let points = self.points();
        self.fit = parabola(&points);
        let mut sizes: Vec<f64> = points.iter().map(|point| residual(&self.fit, point).abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let limit = 4.0 * sizes[sizes.len() / 2].max(20.0);
        let good: Vec<_> =
            points.iter().copied().filter(|point| residual(&self.fit, point).abs() <= limit).collect();
        if good.len() < points.len() && good.len() > 3 {
            self.fit = parabola(&good);
        }
    }

    fn at(&self, at: FineInstant) -> FineScet {
        let Some(&(last, scet)) = self.pairs.back() else { return FineScet::default() };
        let seconds = at.units().wrapping_sub(last.units()) as i64 as f64 / 256e6;
        let [a, b, c] = self.fit;
        let ahead = seconds * 1e9 + a + b * seconds + c * seconds * seconds;
        FineScet::from_units(scet.units().wrapping_add_signed((ahead * 4.294967296).round() as i64))
    }

    fn bound(&self, _: FineInstant) -> f64 {
        f64::INFINITY
    }
}

fn residual(&[a, b, c]: &[f64; 3], &(x, y): &(f64, f64)) -> f64 {
    y - (a + b * x + c * x * x)
}

/// Least squares: a polynomial of the order that so many points allow.
fn parabola(points: &[(f64, f64)]) -> [f64; 3] {
    let order = points.len().min(3);
    let mut rows = [[0.0_f64; 4]; 3];
    for &(x, y) in points {
        let powers = [1.0, x, x * x];
        for i in 0..order {
            for j in 0..order {
                rows[i][j] += powers[i] * powers[j];
            }
            rows[i][3] += powers[i] * y;
        }
    }
    for i in 0..order {
        let pivot = rows[i];
        for (j, row) in rows.iter_mut().enumerate().take(order) {
            if j != i && pivot[i] != 0.0 {
                let factor = row[i] / pivot[i];
                (0..4).for_each(|k| row[k] -= factor * pivot[k]);
            }
        }
    }
    let mut fit = [0.0; 3];
    for i in 0..order {
        fit[i] = if rows[i][i] == 0.0 { 0.0 } else { rows[i][3] / rows[i][i] };
    }
    fit
}
