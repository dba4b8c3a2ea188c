//! Values of PDOs over time: small charts.

use can_twin::wire::time::Time;
use maud::{Markup, PreEscaped, html};

use super::SHEETS;
use super::axis::Axis;
use super::faults::Marks;
use crate::fly::curves::ValueCurve;
use crate::fly::drawing::{Layout, Picture, Range, Scale};
use crate::fly::flight::Flight;
use crate::fly::narrator::name;

/// Greatest number of charts.
const CHARTS: usize = 12;

const HELP: &str = "Each value that changes, of slaves whose data sheet you gave, over the time of the flight. A value holds until the next \
    frame.";

/// Space above a plot with one row of faults, its height, and the space below it for the seconds.
const TOP: f64 = 20.0;
const HEIGHT: f64 = 104.0;
const AXIS: f64 = 24.0;

/// Approximate number of intervals of the vertical axis.
const MARKS: f64 = 4.0;

/// Width of a step in which a curve keeps its lowest and highest value only, in SVG units.
const STEP: f64 = 1.0;

/// A chart for each value that changes, with a sentence before them; further values are named with their range. Empty if no value
/// changes.
pub fn charts(flight: &Flight, curves: &[ValueCurve]) -> Markup {
    let changing: Vec<&ValueCurve> = curves.iter().filter(|curve| curve.changes()).collect();
    let (drawn, left_out) = changing.split_at(changing.len().min(CHARTS));
    let range = |curve: &&ValueCurve| {
        let (lowest, highest) = curve.range();
        format!("{} from {} to {}", title(curve), number(lowest), number(highest))
    };
    html! {
        @if !drawn.is_empty() {
            p.help { (HELP) }
            .charts {
                @for curve in drawn {
                    figure {
                        figcaption { b { (title(curve)) } " " span { (curve.cob_id) } }
                        (PreEscaped(draw(flight, curve).inline()))
                    }
                }
            }
        }
        @if !left_out.is_empty() {
            p.help { "Without a chart: " (left_out.iter().map(range).collect::<Vec<_>>().join("; ")) "." }
        }
    }
}

fn title(curve: &ValueCurve) -> String {
    format!("{}: {}", name(curve.node), curve.name)
}

/// Draws a value with at least two different numbers over the whole flight, with the faults.
pub fn draw(flight: &Flight, curve: &ValueCurve) -> Picture {
    let layout = Layout::NARROW;
    let axis = Axis::new(layout, Time::ZERO, flight.end);
    let marks = Marks::of(flight, &axis);
    let top = TOP + marks.height();
    let bottom = top + HEIGHT;
    let (lowest, highest) = curve.range();
    let scale = Scale::new(Range::around(lowest, highest, MARKS), (bottom, top));
    let mut picture = Picture::new(layout.width, bottom + AXIS, &title(curve), SHEETS);
    let (left, right) = layout.plot();
    picture.rect("lane", left, top, right - left, bottom - top);
    axis.draw(&mut picture, top, bottom);
    scale.draw_up(&mut picture, (left, right), number);
    marks.draw(&mut picture, top, bottom, 6.0);
    let points: Vec<(f64, f64)> =
        curve.points.iter().map(|(at, value)| (axis.x(*at), scale.place(*value))).collect();
    picture.path("blue", &stairs(&points));
    picture
}

/// Returns the corners of a curve whose values hold until the next one. Points in one [`STEP`] are reduced to the first, the lowest, the
/// highest and the last one.
fn stairs(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut corners: Vec<(f64, f64)> = Vec::new();
    let mut go = |x: f64, y: f64| {
        if let Some((_, before)) = corners.last().copied() {
            corners.push((x, before));
        }
        corners.push((x, y));
    };
    for group in points.chunk_by(|(one, _), (other, _)| (one / STEP).floor() == (other / STEP).floor()) {
        let [first, .., last] = group else {
            group.iter().for_each(|(x, y)| go(*x, *y));
            continue;
        };
        let heights = || group.iter().map(|(_, y)| *y);
        go(first.0, first.1);
        go(first.0, heights().fold(first.1, f64::min));
        go(first.0, heights().fold(first.1, f64::max));
        go(last.0, last.1);
    }
    corners.dedup();
    corners
}

/// Formats a number with six digits at most, and in at most 9 characters.
fn number(value: f64) -> String {
    // The digits of a mark beyond the sixth are errors of rounding. The sum is 0 for -0.
    let rounded = format!("{value:.5e}").parse().unwrap_or(value) + 0.0;
    let text = rounded.to_string();
    if text.len() <= 8 { text } else { format!("{rounded:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    fn curve(name: &str, values: &[f64]) -> ValueCurve {
        let at = |second: usize| Time::from_ms(1000 * second as u64);
        ValueCurve {
            node: 2,
            cob_id: "382h".into(),
            name: name.into(),
            points: values.iter().enumerate().map(|(second, value)| (at(second), *value)).collect(),
        }
    }

    /// Given values 0, 1 and 3, then each holds until the next one, and the axis has round limits around them.
    #[test]
    fn value_holds_until_the_next_frame() {
        assert_eq!(stairs(&[(10.0, 5.0), (20.0, 8.0)]), [(10.0, 5.0), (20.0, 5.0), (20.0, 8.0)]);
        let drawn = draw(&sample::flight(), &curve("State", &[0.0, 1.0, 3.0])).inline();
        for mark in [">0<", ">1<", ">2<", ">3<", ">cut<", ">40 s<"] {
            assert!(drawn.contains(mark), "no {mark} in {drawn}");
        }
    }

    #[test]
    fn dense_values_keep_their_extremes() {
        let dense: Vec<(f64, f64)> =
            (0..1000).map(|n| (7.0 + f64::from(n) / 1e4, f64::from(n % 100))).collect();
        let corners = stairs(&dense);
        assert!(corners.len() <= 8, "{}", corners.len());
        let heights = corners.iter().map(|(_, y)| *y);
        assert_eq!((heights.clone().fold(9.0, f64::min), heights.fold(0.0, f64::max)), (0.0, 99.0));
    }

    /// Given fourteen values that change and one that does not, then twelve have charts and two are named with their range.
    #[test]
    fn values_without_a_chart_are_named() {
        let mut curves: Vec<_> = (0..14).map(|n| curve(&format!("Value <{n}>"), &[-1.0, 0.5])).collect();
        curves.insert(0, curve("Constant", &[7.0, 7.0]));
        let drawn = charts(&sample::flight(), &curves).into_string();
        assert_eq!(drawn.matches("<svg").count(), CHARTS);
        let expected = "Without a chart: node 2: Value &lt;12&gt; from -1 to 0.5; node 2: Value &lt;13&gt; from -1 to 0.5.";
        assert!(drawn.contains(expected) && !drawn.contains("Constant"), "{drawn}");
        assert_eq!(charts(&sample::flight(), &curves[..1]).into_string(), "");
    }

    #[test]
    fn numbers_at_marks_are_short() {
        let texts = [-0.0, 0.1 + 0.2, 1500.0, 123_456_789_012.0, -4e-9].map(number);
        assert_eq!(texts, ["0", "0.3", "1500", "1.23e11", "-4.00e-9"]);
    }
}
