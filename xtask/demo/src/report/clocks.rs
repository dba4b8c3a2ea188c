//! How far the slaves' clocks were from the master's: a line for each slave.

use can_wire::time::Time;

use super::axis::{Axis, Layout, text_width};
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

/// What a line looks like; more slaves than colours have dashed ones.
const LINES: [&str; 6] = ["master", "time", "reply", "request", "command", "network"];

/// Errors of all slaves over the whole flight; those below a nanosecond stand at the lower border.
pub fn draw(flight: &Flight, layout: Layout) -> Svg {
    let axis = Axis::new(layout, Time::ZERO, flight.end);
    let errors = flight.clocks.iter().flat_map(|clock| &clock.errors.samples);
    let largest = errors.map(|sample| sample.error_ns.abs()).fold(1.0, f64::max);
    let (lowest, highest) = (DECADES.0, DECADES.1.max(largest.log10().ceil() as i32));
    let key = key(flight, layout);
    let top = TOP + key.last().map_or(0.0, |(_, y)| *y);
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
        svg.text("soft end", left - 12.0, y + 4.0, &decade(exponent));
    }
    if let Some((cut, _)) = flight.cut() {
        let x = axis.x(cut);
        svg.line("cut", (x, top - 4.0), (x, bottom));
        svg.text("cut-label middle", x, top - 8.0, "cut");
    }
    for (place, (clock, &(x, y))) in flight.clocks.iter().zip(&key).enumerate() {
        let dashed = if place < LINES.len() { "" } else { " dashed" };
        let class = format!("{} close-up{dashed}", LINES[place % LINES.len()]);
        let points: Vec<(f64, f64)> = clock
            .errors
            .samples
            .iter()
            .map(|sample| (axis.x(Time::from_us((sample.at * 1e6) as u64)), height(sample.error_ns)))
            .collect();
        svg.path(&class, &points);
        svg.line(&class, (x, y + 10.0), (x + 18.0, y + 10.0));
        svg.text("label", x + 24.0, y + 14.0, &name(clock.node));
    }
    if !layout.brief && key.len() <= 4 {
        svg.text("soft end", right, 14.0, WHAT);
    }
    if flight.clocks.is_empty() {
        svg.text("soft", left + 8.0, top + 20.0, "no pulses to compare");
    }
    svg
}

/// Places of the names of the slaves, in rows from the top.
fn key(flight: &Flight, layout: Layout) -> Vec<(f64, f64)> {
    let first = if layout.brief { 0.0 } else { layout.left };
    let (mut x, mut y) = (first, 0.0);
    let mut places = Vec::new();
    for clock in &flight.clocks {
        let words = name(clock.node);
        if !layout.has_room(x + 24.0, &words) {
            (x, y) = (first, y + 18.0);
        }
        places.push((x, y));
        x += 40.0 + text_width(&words);
    }
    places
}

/// A power of ten of a nanosecond.
fn decade(exponent: i32) -> String {
    let unit = ["ns", "\u{b5}s", "ms", "s"][(exponent / 3) as usize];
    format!("{} {unit}", 10_i32.pow((exponent % 3) as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    #[test]
    fn names_of_many_slaves_stand_in_rows() {
        let mut flight = sample::flight();
        flight.clocks = vec![flight.clocks[0].clone(); 14];
        let places = key(&flight, Layout::NARROW);
        assert_eq!((places[0], places[3].1, places[4]), ((0.0, 0.0), 0.0, (0.0, 18.0)));
        assert!(places.iter().all(|(x, _)| *x + 24.0 + 45.0 <= Layout::NARROW.width), "{places:?}");
    }

    #[test]
    fn decades_have_their_units() {
        assert_eq!([0, 2, 3, 7, 9].map(decade), ["1 ns", "100 ns", "1 \u{b5}s", "10 ms", "1 s"]);
    }
}
