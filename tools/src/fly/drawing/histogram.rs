//! Histograms in rows over one axis.

use crate::fly::drawing::chart::{AXIS, duration};
use crate::fly::drawing::layout::Layout;
use crate::fly::drawing::paint::BASE;
use crate::fly::drawing::picture::Picture;
use crate::fly::drawing::scale::{Range, Scale, round_up};

/// A row of a histogram and the space below it.
const ROW: f64 = 64.0;
const GAP: f64 = 12.0;
/// Bins on either side of zero.
const BINS: usize = 30;

/// A row of a histogram.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name on the left of the row.
    pub name: String,
    /// Text below the name.
    pub note: String,
    /// Errors in nanoseconds.
    pub errors: Vec<f64>,
}

/// Draws a histogram for each row, all over one axis that is symmetrical about zero.
pub fn draw(title: &str, layout: Layout, what: &str, rows: &[Row]) -> Picture {
    let largest = rows.iter().flat_map(|row| &row.errors).fold(1.0_f64, |most, error| most.max(error.abs()));
    // Chooses a limit whose half is also a short number.
    let limit = round_up(largest, &[1.0, 2.0, 3.0, 4.0, 6.0, 8.0]);
    let step = if layout.brief { limit } else { limit / 2.0 };
    let bottom = rows.len() as f64 * (ROW + GAP);
    let (left, right) = layout.plot();
    let scale = Scale::new(Range::Linear(-limit, limit, step), (left, right));
    let mut picture = Picture::new(layout.width, bottom + AXIS, title, &[BASE]);
    for (place, row) in rows.iter().enumerate() {
        let top = place as f64 * (ROW + GAP) + GAP / 2.0;
        picture.rect("lane", left, top, right - left, ROW);
        for (_, x) in scale.marks() {
            picture.line("grid", (x, top), (x, top + ROW));
        }
        picture.text("label end", left - 12.0, top + ROW / 2.0 - 3.0, &row.name);
        picture.text("soft end", left - 12.0, top + ROW / 2.0 + 14.0, &row.note);
        let counts = counts(&row.errors, limit);
        let most = counts.iter().copied().max().unwrap_or(0).max(1);
        let width = (right - left) / counts.len() as f64;
        for (bin, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let height = (ROW - 6.0) * count as f64 / most as f64;
            picture.rect("bar", left + bin as f64 * width, top + ROW - height, width - 1.0, height);
        }
    }
    for (value, x) in scale.marks() {
        picture.number_below((x, bottom), &duration(value));
    }
    picture.text("soft middle", (left + right) / 2.0, bottom + 36.0, what);
    picture
}

/// Returns the number of errors in each bin from `-limit` to `limit`.
fn counts(errors: &[f64], limit: f64) -> Vec<usize> {
    let mut counts = vec![0; 2 * BINS];
    for error in errors {
        let bin = ((error / limit + 1.0) * BINS as f64).floor().max(0.0) as usize;
        counts[bin.min(2 * BINS - 1)] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given limits of ±60 ns and bins of 2 ns, Then errors on a border count in the upper bin, the largest in the last one.
    #[test]
    fn every_error_is_in_one_bin() {
        let counts = counts(&[-60.0, -0.1, 0.0, 1.9, 2.0, 60.0], 60.0);
        let filled: Vec<_> = counts.into_iter().enumerate().filter(|(_, count)| *count > 0).collect();
        assert_eq!(filled, [(0, 1), (29, 1), (30, 2), (31, 1), (59, 1)]);
    }
}
