//! How far the slaves' clocks were from the master's: a line for each slave over time, and a histogram for each.

use can_wire::time::Time;

use super::axis::{Axis, Layout};
use super::chart::{self, CURVES, Row};
use super::faults::Marks;
use super::svg::Svg;
use crate::flight::Flight;
use crate::narrator::name;

const TOP: f64 = 44.0;
const DECADE: f64 = 46.0;
const AXIS: f64 = 26.0;

/// Decades of the scale, powers of ten of a nanosecond: these at least.
const DECADES: (i32, i32) = (0, 3);

/// The quantity, where there is room for its name.
const WHAT: &str = "error of the clock against the master's, without sign";

/// The quantity of the histograms.
const SIGNED: &str = "error of the clock against the master's, positive where the slave's pulse is late; each row has its own height";

/// Errors of all slaves over the whole flight; those below a nanosecond stand at the lower border.
pub fn draw(flight: &Flight, layout: Layout) -> Svg {
    let axis = Axis::new(layout, Time::ZERO, flight.end);
    let errors = flight.clocks.iter().flat_map(|clock| &clock.errors.samples);
    let largest = errors.map(|sample| sample.error_ns.abs()).fold(1.0, f64::max);
    let (lowest, highest) = (DECADES.0, DECADES.1.max(largest.log10().ceil() as i32));
    let names: Vec<String> = flight.clocks.iter().map(|clock| name(clock.node)).collect();
    let key = chart::key(&names.iter().map(String::as_str).collect::<Vec<_>>(), layout);
    let marks = Marks::of(flight, &axis);
    let top = TOP + key.last().map_or(0.0, |(_, y)| *y) + marks.height();
    let bottom = top + f64::from(highest - lowest) * DECADE;
    let height = |error_ns: f64| bottom - (error_ns.abs().max(1.0).log10() - f64::from(lowest)) * DECADE;
    let mut svg = Svg::new(layout.width, bottom + AXIS, "Error of the slaves' clocks over time");
    let (left, right) = axis.ends();
    svg.rect("paper", 0.0, 0.0, layout.width, bottom + AXIS);
    svg.rect("lane", left, top, right - left, bottom - top);
    axis.draw(&mut svg, top, bottom);
    for exponent in lowest..=highest {
        let y = height(10_f64.powi(exponent));
        svg.line("grid", (left, y), (right, y));
        svg.text("soft end", left - 12.0, y + 4.0, &chart::duration(10_f64.powi(exponent)));
    }
    marks.draw(&mut svg, top, bottom, 8.0);
    for (place, (clock, &at)) in flight.clocks.iter().zip(&key).enumerate() {
        let dashed = if place < CURVES.len() { "" } else { " dashed" };
        let class = format!("{} close-up{dashed}", CURVES[place % CURVES.len()]);
        let points: Vec<(f64, f64)> = clock
            .errors
            .samples
            .iter()
            .map(|sample| (axis.x(Time::from_us((sample.at * 1e6) as u64)), height(sample.error_ns)))
            .collect();
        svg.path(&class, &points);
        chart::draw_key(&mut svg, &class, at, &names[place]);
    }
    if !layout.brief && key.len() <= 4 {
        svg.text("soft end", right, 14.0, WHAT);
    }
    if flight.clocks.is_empty() {
        svg.text("soft", left + 8.0, top + 20.0, "no pulses to compare");
    }
    svg
}

/// A histogram of the settled errors of each slave; `None` when no clock has settled.
pub fn histogram(flight: &Flight, layout: Layout) -> Option<Svg> {
    let settled = flight.clocks.iter().filter_map(|clock| Some((clock.node, clock.settled()?)));
    let rows: Vec<Row> = settled.map(|(node, errors)| Row::of(name(node), &errors)).collect();
    let what = if layout.brief { "error of the clock" } else { SIGNED };
    (!rows.is_empty())
        .then(|| chart::histogram("Histograms of the errors of the slaves' clocks", layout, what, &rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    /// Given errors of 30 ns and -40 ns after the clock has settled, and 2.5 us before, Then the axis ends at 40 ns.
    #[test]
    fn the_histogram_is_of_what_has_settled() {
        let flight = sample::flight();
        let drawn = histogram(&flight, Layout::WIDE).expect("it has settled").inline().into_string();
        assert_eq!(drawn.matches("class=\"bar\"").count(), 2);
        for expected in [">-40 ns<", ">40 ns<", ">node 2<", ">rms 35 ns<"] {
            assert!(drawn.contains(expected), "{expected}");
        }
    }

    #[test]
    fn a_flight_too_short_has_no_histogram() {
        let mut flight = sample::flight();
        flight.clocks[0].errors.samples.truncate(2);
        assert!(histogram(&flight, Layout::WIDE).is_none());
    }
}
