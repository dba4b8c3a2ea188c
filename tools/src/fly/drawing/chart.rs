//! Curves over two numbered axes.

use crate::fly::drawing::key;
use crate::fly::drawing::layout::Layout;
use crate::fly::drawing::paint::BASE;
use crate::fly::drawing::picture::Picture;
use crate::fly::drawing::scale::{Range, Scale};

/// Colours of curves in their order; further curves repeat them, dashed.
const COLOURS: [&str; 6] = ["blue", "amber", "green", "violet", "teal", "black"];

/// Bottom of the names of the curves, and of the title of the vertical axis.
const TOP: f64 = 44.0;
/// Height of a decade of a logarithmic axis, and of the space between two marks of a linear one.
const STEP: f64 = 46.0;
/// Height of numbers and title below a plot.
pub(in crate::fly) const AXIS: f64 = 46.0;

/// Quantity of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Its name.
    pub title: &'static str,
    /// Its values.
    pub range: Range,
    /// Formats the text at a mark.
    pub text: fn(f64) -> String,
}

/// A curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the key; a curve without name belongs to the one before.
    pub name: Option<String>,
    /// Style: classes of [`BASE`].
    pub class: String,
    /// Pairs of values, in drawing order.
    pub points: Vec<(f64, f64)>,
}

/// Draws curves over two axes.
pub fn curves(title: &str, layout: Layout, [across, up]: [Quantity; 2], curves: &[Curve]) -> Picture {
    let names: Vec<&str> = curves.iter().filter_map(|curve| curve.name.as_deref()).collect();
    let (key, rows) = key::of_curves(&names, layout);
    let top = TOP + rows;
    let bottom = top + (up.range.marks().len() - 1) as f64 * STEP;
    let (left, right) = layout.plot();
    let mut picture = Picture::new(layout.width, bottom + AXIS, title, &[BASE]);
    picture.rect("lane", left, top, right - left, bottom - top);
    let x = Scale::new(across.range, (left, right));
    let y = Scale::new(up.range, (bottom, top));
    x.draw_across(&mut picture, (top, bottom), across.text);
    picture.text("soft middle", (left + right) / 2.0, bottom + 36.0, across.title);
    y.draw_up(&mut picture, (left, right), up.text);
    picture.text("soft", left, top - 10.0, up.title);
    let mut places = key.iter();
    for curve in curves {
        let points: Vec<_> = curve.points.iter().map(|&(a, b)| (x.place(a), y.place(b))).collect();
        picture.path(&curve.class, &points);
        if let Some(name) = &curve.name
            && let Some(&place) = places.next()
        {
            key::draw_curve(&mut picture, &curve.class, place, name);
        }
    }
    picture
}

/// Returns the classes of the curve with a number from 0, different for each curve.
pub fn class(number: usize) -> String {
    let dashed = if number < COLOURS.len() { "" } else { " dashed" };
    format!("{} thick{dashed}", COLOURS[number % COLOURS.len()])
}

/// Formats a number of nanoseconds in the most readable unit.
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
}
