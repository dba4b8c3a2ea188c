//! Errors of the slaves' clocks against the master's: a line over time and a histogram for each slave.

use can_twin::pulses::{Errors, Sample};
use can_twin::wire::time::Time;

use super::SHEETS;
use super::axis::Axis;
use super::faults::Marks;
use crate::fly::drawing::histogram::{self, Row};
use crate::fly::drawing::{Layout, Picture, Range, Scale, chart, key};
use crate::fly::flight::Flight;
use crate::fly::narrator::name;

const TOP: f64 = 44.0;
const DECADE: f64 = 46.0;
const AXIS: f64 = 26.0;

/// Least range of the scale, in powers of ten of a nanosecond.
const DECADES: (i32, i32) = (0, 3);

/// Long name of the quantity.
const WHAT: &str = "error of the clock against the master's, without sign";

/// The quantity of the histograms.
const SIGNED: &str = "error of the clock against the master's, positive where the slave's pulse is late; each row has its own height";

/// Draws the errors of all slaves over the whole flight; those below a nanosecond are at the lower border.
pub fn draw(flight: &Flight, layout: Layout) -> Picture {
    let axis = Axis::new(layout, Time::ZERO, flight.end);
    let errors = flight.clocks.iter().flat_map(|clock| &clock.errors.samples);
    let largest = errors.map(|sample| sample.error_ns.abs()).fold(1.0, f64::max);
    let highest = DECADES.1.max(largest.log10().ceil() as i32);
    let names: Vec<String> = flight.clocks.iter().map(|clock| name(clock.node)).collect();
    let (key, rows) = key::of_curves(&names.iter().map(String::as_str).collect::<Vec<_>>(), layout);
    let marks = Marks::of(flight, &axis);
    let top = TOP + rows + marks.height();
    let bottom = top + f64::from(highest - DECADES.0) * DECADE;
    let scale = Scale::new(Range::Decades(DECADES.0, highest), (bottom, top));
    let title = "Error of the slaves' clocks over time";
    let mut picture = Picture::new(layout.width, bottom + AXIS, title, SHEETS);
    let (left, right) = layout.plot();
    picture.rect("lane", left, top, right - left, bottom - top);
    axis.draw(&mut picture, top, bottom);
    scale.draw_up(&mut picture, (left, right), chart::duration);
    marks.draw(&mut picture, top, bottom, 8.0);
    for (number, (clock, &at)) in flight.clocks.iter().zip(&key).enumerate() {
        let at_us = |sample: &Sample| Time::from_us((sample.at * 1e6) as u64);
        let place = |sample| (axis.x(at_us(sample)), scale.place(sample.error_ns.abs()));
        let points: Vec<(f64, f64)> = clock.errors.samples.iter().map(place).collect();
        let class = chart::class(number);
        picture.path(&class, &points);
        key::draw_curve(&mut picture, &class, at, &names[number]);
    }
    if !layout.brief && key.len() <= 4 {
        picture.text("soft end", right, 14.0, WHAT);
    }
    if flight.clocks.is_empty() {
        picture.text("soft", left + 8.0, top + 20.0, "no pulses to compare");
    }
    picture
}

/// Makes a row of a histogram, with the root mean square as its note.
pub fn row(name: String, errors: &Errors) -> Row {
    let note = format!("rms {}", chart::duration(errors.rms_ns()));
    Row { name, note, errors: errors.samples.iter().map(|sample| sample.error_ns).collect() }
}

/// Draws a histogram of the settled errors of each slave; `None` if no clock has settled.
pub fn histogram(flight: &Flight, layout: Layout) -> Option<Picture> {
    let settled = flight.clocks.iter().filter_map(|clock| Some((clock.node, clock.settled()?)));
    let rows: Vec<Row> = settled.map(|(node, errors)| row(name(node), &errors)).collect();
    let what = if layout.brief { "error of the clock" } else { SIGNED };
    (!rows.is_empty())
        .then(|| histogram::draw("Histograms of the errors of the slaves' clocks", layout, what, &rows))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    /// Given errors of 30 ns and -40 ns after the clock has settled, and 2.5 us before, Then the axis ends at 40 ns.
    #[test]
    fn the_histogram_is_of_what_has_settled() {
        let flight = sample::flight();
        let drawn = histogram(&flight, Layout::WIDE).expect("it has settled").inline();
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
