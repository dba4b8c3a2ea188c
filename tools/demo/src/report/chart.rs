//! Curves over two numbered axes, and histograms in rows.

use twin::pulses::Errors;

use super::axis::{Layout, text_width};
use super::svg::Svg;

/// Classes of curves in their order; further curves repeat them, dashed.
pub const CURVES: [&str; 6] = ["master", "time", "reply", "request", "command", "network"];

/// Bottom of the names of the curves, and of the title of the vertical axis.
const TOP: f64 = 44.0;
/// Height of a decade of a logarithmic axis, and of the space between two marks of a linear one.
const STEP: f64 = 46.0;
/// Numbers and title below the plot.
const AXIS: f64 = 46.0;

/// A row of a histogram and the space below it.
const ROW: f64 = 64.0;
const GAP: f64 = 12.0;
/// Bins on either side of zero.
const BINS: usize = 30;

/// An axis: its title, its range and how its numbers are written.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Quantity.
    pub title: &'static str,
    /// Range.
    pub range: Range,
    /// Text at a mark.
    pub text: fn(f64) -> String,
}

/// Range of an axis.
#[derive(Clone, Copy, Debug)]
pub enum Range {
    /// Powers of ten, the first and the last.
    Decades(i32, i32),
    /// From, to, and the distance of the marks.
    Linear(f64, f64, f64),
}

impl Range {
    /// Place of a value, 0 at the beginning and 1 at the end; values outside stand at the border.
    fn place(self, value: f64) -> f64 {
        let place = match self {
            Range::Decades(from, to) => {
                (value.max(f64::MIN_POSITIVE).log10() - f64::from(from)) / f64::from(to - from)
            }
            Range::Linear(from, to, _) => (value - from) / (to - from),
        };
        place.clamp(0.0, 1.0)
    }

    fn marks(self) -> Vec<f64> {
        match self {
            Range::Decades(from, to) => (from..=to).map(|exponent| 10_f64.powi(exponent)).collect(),
            Range::Linear(from, to, step) => {
                let last = ((to - from) / step).round() as u32;
                (0..=last).map(|mark| from + f64::from(mark) * step).collect()
            }
        }
    }
}

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// For the key; curves without name belong to the one before.
    pub name: Option<String>,
    /// How it is drawn.
    pub class: String,
    /// Pairs of values, in drawing order.
    pub points: Vec<(f64, f64)>,
}

/// Draws curves over two axes.
pub fn curves(title: &str, layout: Layout, [across, up]: [Scale; 2], curves: &[Curve]) -> Svg {
    let names: Vec<&str> = curves.iter().filter_map(|curve| curve.name.as_deref()).collect();
    let key = key(&names, layout);
    let top = TOP + key.last().map_or(0.0, |(_, y)| *y);
    let bottom = top + (up.range.marks().len() - 1) as f64 * STEP;
    let (left, right) = layout.plot();
    let mut svg = Svg::new(layout.width, bottom + AXIS, title);
    svg.rect("paper", 0.0, 0.0, layout.width, bottom + AXIS);
    svg.rect("lane", left, top, right - left, bottom - top);
    let x = |value| left + across.range.place(value) * (right - left);
    let y = |value| bottom - up.range.place(value) * (bottom - top);
    for mark in across.range.marks() {
        svg.line("grid", (x(mark), top), (x(mark), bottom));
        below(&mut svg, layout, x(mark), bottom, &(across.text)(mark));
    }
    svg.text("soft middle", (left + right) / 2.0, bottom + 36.0, across.title);
    for mark in up.range.marks() {
        svg.line("grid", (left, y(mark)), (right, y(mark)));
        svg.text("soft end", left - 12.0, y(mark) + 4.0, &(up.text)(mark));
    }
    svg.text("soft", left, top - 10.0, up.title);
    let mut places = key.iter();
    for curve in curves {
        let points: Vec<(f64, f64)> = curve.points.iter().map(|&(a, b)| (x(a), y(b))).collect();
        svg.path(&curve.class, &points);
        if let Some(name) = &curve.name
            && let Some(&place) = places.next()
        {
            draw_key(&mut svg, &curve.class, place, name);
        }
    }
    svg
}

/// The number of a mark below the plot, inside the picture.
fn below(svg: &mut Svg, layout: Layout, x: f64, bottom: f64, number: &str) {
    let x = x.min(layout.width - text_width(number) / 2.0);
    svg.text("soft middle", x, bottom + 16.0, number);
}

/// Line and name of a curve in the key.
pub fn draw_key(svg: &mut Svg, class: &str, (x, y): (f64, f64), name: &str) {
    svg.line(class, (x, y + 10.0), (x + 18.0, y + 10.0));
    svg.text("label", x + 24.0, y + 14.0, name);
}

/// Places of the names of curves, in rows from the top.
pub fn key(names: &[&str], layout: Layout) -> Vec<(f64, f64)> {
    let first = if layout.brief { 0.0 } else { layout.left };
    let (mut x, mut y) = (first, 0.0);
    let mut places = Vec::new();
    for name in names {
        if !layout.has_room(x + 24.0, name) {
            (x, y) = (first, y + 18.0);
        }
        places.push((x, y));
        x += 40.0 + text_width(name);
    }
    places
}

/// A row of a histogram.
#[derive(Clone, Debug)]
pub struct Row {
    /// Left of the row.
    pub name: String,
    /// Below the name.
    pub note: String,
    /// Nanoseconds.
    pub errors: Vec<f64>,
}

impl Row {
    /// With the root of the mean square as its note.
    pub fn of(name: String, errors: &Errors) -> Row {
        let note = format!("rms {}", duration(errors.rms_ns()));
        Row { name, note, errors: errors.samples.iter().map(|sample| sample.error_ns).collect() }
    }
}

/// Draws a histogram for each row, all over one axis that is symmetrical about zero.
pub fn histogram(title: &str, layout: Layout, what: &str, rows: &[Row]) -> Svg {
    let largest = rows.iter().flat_map(|row| &row.errors).fold(1.0_f64, |most, error| most.max(error.abs()));
    let limit = round_up(largest);
    let bottom = rows.len() as f64 * (ROW + GAP);
    let (left, right) = layout.plot();
    let x = |value: f64| left + (value / limit + 1.0) / 2.0 * (right - left);
    let mut svg = Svg::new(layout.width, bottom + AXIS, title);
    svg.rect("paper", 0.0, 0.0, layout.width, bottom + AXIS);
    let marks = if layout.brief { [-1.0, 0.0, 1.0].as_slice() } else { &[-1.0, -0.5, 0.0, 0.5, 1.0] };
    for (place, row) in rows.iter().enumerate() {
        let top = place as f64 * (ROW + GAP) + GAP / 2.0;
        svg.rect("lane", left, top, right - left, ROW);
        for mark in marks {
            svg.line("grid", (x(mark * limit), top), (x(mark * limit), top + ROW));
        }
        svg.text("label end", left - 12.0, top + ROW / 2.0 - 3.0, &row.name);
        svg.text("soft end", left - 12.0, top + ROW / 2.0 + 14.0, &row.note);
        let counts = counts(&row.errors, limit);
        let most = counts.iter().copied().max().unwrap_or(0).max(1);
        let width = (right - left) / counts.len() as f64;
        for (bin, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let height = (ROW - 6.0) * count as f64 / most as f64;
            svg.rect("bar", left + bin as f64 * width, top + ROW - height, width - 1.0, height);
        }
    }
    for mark in marks {
        below(&mut svg, layout, x(mark * limit), bottom, &duration(mark * limit));
    }
    svg.text("soft middle", (left + right) / 2.0, bottom + 36.0, what);
    svg
}

/// Errors in each bin from `-limit` to `limit`.
fn counts(errors: &[f64], limit: f64) -> Vec<usize> {
    let mut counts = vec![0; 2 * BINS];
    for error in errors {
        let bin = ((error / limit + 1.0) * BINS as f64).floor().max(0.0) as usize;
        counts[bin.min(2 * BINS - 1)] += 1;
    }
    counts
}

/// The next limit whose half is a short number, too.
fn round_up(value: f64) -> f64 {
    let magnitude = 10_f64.powf(value.log10().floor());
    let factor =
        [1.0, 2.0, 3.0, 4.0, 6.0, 8.0].into_iter().find(|factor| factor * magnitude >= value * 0.999_999);
    factor.unwrap_or(10.0) * magnitude
}

/// A number of nanoseconds, in the unit that reads best.
pub fn duration(ns: f64) -> String {
    let units = [(1e9, "s"), (1e6, "ms"), (1e3, "\u{b5}s")];
    let unit = units.into_iter().find(|(unit, _)| ns.abs() >= unit * 0.999_999);
    let (unit, name) = unit.unwrap_or((1.0, "ns"));
    let digits = if (ns / unit).abs() < 10.0 { 10.0 } else { 1.0 };
    // Without "-0" and trailing zeros.
    let rounded = (ns / unit * digits).round() / digits + 0.0;
    format!("{rounded} {name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_their_units() {
        let texts = [1.0, 100.0, 1e3, -2.5e4, 1e7, 1e9, -0.0].map(duration);
        assert_eq!(texts, ["1 ns", "100 ns", "1 \u{b5}s", "-25 \u{b5}s", "10 ms", "1 s", "0 ns"]);
    }

    #[test]
    fn limits_are_round() {
        assert_eq!([1.0, 1.1, 48.0, 60.0, 81.0, 999.0].map(round_up), [1.0, 2.0, 60.0, 60.0, 100.0, 1000.0]);
    }

    /// Given limits of ±60 ns and bins of 2 ns, Then errors on a border count in the upper bin, the largest in the last one.
    #[test]
    fn every_error_is_in_one_bin() {
        let counts = counts(&[-60.0, -0.1, 0.0, 1.9, 2.0, 60.0], 60.0);
        let filled: Vec<_> = counts.into_iter().enumerate().filter(|(_, count)| *count > 0).collect();
        assert_eq!(filled, [(0, 1), (29, 1), (30, 2), (31, 1), (59, 1)]);
    }

    #[test]
    fn values_stand_on_their_scales() {
        let decades = Range::Decades(0, 4);
        assert_eq!([0.0, 1.0, 100.0, 1e9].map(|value| decades.place(value)), [0.0, 0.0, 0.5, 1.0]);
        let linear = Range::Linear(-10.0, 30.0, 20.0);
        assert_eq!(linear.marks(), [-10.0, 10.0, 30.0]);
        assert_eq!([-20.0, 0.0, 30.0].map(|value| linear.place(value)), [0.0, 0.25, 1.0]);
    }

    #[test]
    fn names_of_many_curves_stand_in_rows() {
        let places = key(&["node 2"; 14], Layout::NARROW);
        assert_eq!((places[0], places[3].1, places[4]), ((0.0, 0.0), 0.0, (0.0, 18.0)));
        assert!(places.iter().all(|(x, _)| *x + 24.0 + 45.0 <= Layout::NARROW.width), "{places:?}");
    }
}
