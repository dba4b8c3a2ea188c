//! Scales: convert values to positions in a picture, with marks at round values.

use crate::fly::drawing::picture::Picture;

/// Range of values of a scale.
#[derive(Clone, Copy, Debug)]
pub enum Range {
    /// Powers of ten, the first and the last.
    Decades(i32, i32),
    /// Start, end, and the distance of the marks, which are at its multiples.
    Linear(f64, f64, f64),
}

impl Range {
    /// Makes a range with about `marks` marks, or fewer, at round values.
    pub fn with_marks(from: f64, to: f64, marks: f64) -> Range {
        Range::Linear(from, to, round_up((to - from) / marks, &[1.0, 2.0, 5.0]))
    }

    /// Makes a range whose ends are marks too: about `marks` intervals that contain `from` and `to`, which differ.
    pub fn around(from: f64, to: f64, marks: f64) -> Range {
        let step = round_up((to - from) / marks, &[1.0, 2.0, 5.0]);
        Range::Linear((from / step).floor() * step, (to / step).ceil() * step, step)
    }

    /// Returns the values with a mark.
    pub fn marks(self) -> Vec<f64> {
        match self {
            Range::Decades(from, to) => (from..=to).map(|exponent| 10_f64.powi(exponent)).collect(),
            Range::Linear(from, to, step) => {
                let (first, last) = ((from / step - 1e-9).ceil() as i64, (to / step + 1e-9).floor() as i64);
                (first..=last).map(|mark| mark as f64 * step).collect()
            }
        }
    }
}

/// A range of values between two positions.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    range: Range,
    ends: (f64, f64),
}

impl Scale {
    /// A scale whose range begins and ends at these places.
    pub fn new(range: Range, ends: (f64, f64)) -> Self {
        Scale { range, ends }
    }

    /// Returns the position of a value; values outside the range are at its border.
    pub fn place(&self, value: f64) -> f64 {
        let share = match self.range {
            Range::Decades(from, to) => {
                (value.max(f64::MIN_POSITIVE).log10() - f64::from(from)) / f64::from(to - from)
            }
            Range::Linear(from, to, _) => (value - from) / (to - from),
        };
        self.ends.0 + share.clamp(0.0, 1.0) * (self.ends.1 - self.ends.0)
    }

    /// Returns the values with a mark, and their positions.
    pub fn marks(&self) -> impl Iterator<Item = (f64, f64)> {
        self.range.marks().into_iter().map(|value| (value, self.place(value)))
    }

    /// Vertical lines at the marks, from `top` to `bottom`, with their values below.
    pub fn draw_across(
        &self,
        picture: &mut Picture,
        (top, bottom): (f64, f64),
        text: impl Fn(f64) -> String,
    ) {
        for (value, x) in self.marks() {
            picture.line("grid", (x, top), (x, bottom));
            picture.number_below((x, bottom), &text(value));
        }
    }

    /// Horizontal lines at the marks, from `left` to `right`, with their values on the left.
    pub fn draw_up(&self, picture: &mut Picture, (left, right): (f64, f64), text: impl Fn(f64) -> String) {
        for (value, y) in self.marks() {
            picture.line("grid", (left, y), (right, y));
            picture.text("soft end", left - 12.0, y + 4.0, &text(value));
        }
    }
}

/// Rounds a value up to the least of the factors (and ten) times a power of ten.
pub(in crate::fly) fn round_up(value: f64, factors: &[f64]) -> f64 {
    let magnitude = 10_f64.powf(value.log10().floor());
    let factor = factors.iter().find(|factor| **factor * magnitude >= value * 0.999_999);
    factor.unwrap_or(&10.0) * magnitude
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_and_limits_are_round() {
        for (span, marks, step) in
            [(40.0, 10.0, 5.0), (1.0, 10.0, 0.1), (3600.0, 10.0, 500.0), (40.0, 5.0, 10.0)]
        {
            assert_eq!(Range::with_marks(0.0, span, marks).marks()[1], step, "{span} with {marks} marks");
        }
        let limits = [1.0, 1.1, 48.0, 60.0, 81.0, 999.0];
        let factors = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0];
        assert_eq!(limits.map(|value| round_up(value, &factors)), [1.0, 2.0, 60.0, 60.0, 100.0, 1000.0]);
    }

    #[test]
    fn range_around_values_ends_at_marks() {
        for (from, to, expected) in
            [(-1.0, 3.0, &[-1.0, 0.0, 1.0, 2.0, 3.0][..]), (21.3, 22.9, &[21.0, 21.5, 22.0, 22.5, 23.0])]
        {
            assert_eq!(Range::around(from, to, 4.0).marks(), expected, "{from} to {to}");
        }
    }

    #[test]
    fn values_stand_on_their_scales() {
        let decades = Scale::new(Range::Decades(0, 4), (100.0, 0.0));
        assert_eq!([0.0, 1.0, 100.0, 1e9].map(|value| decades.place(value)), [100.0, 100.0, 50.0, 0.0]);
        let linear = Scale::new(Range::Linear(-10.0, 30.0, 20.0), (0.0, 80.0));
        assert_eq!(linear.marks().collect::<Vec<_>>(), [(0.0, 20.0), (20.0, 60.0)]);
        assert_eq!([-20.0, 0.0, 30.0].map(|value| linear.place(value)), [0.0, 20.0, 80.0]);
    }
}
