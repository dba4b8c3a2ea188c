//! The two buses over time: a lane each, a row per kind of frame, a tick per frame.

use std::collections::BTreeSet;

use can_twin::wire::time::Time;

use super::SHEETS;
use super::axis::Axis;
use super::flags::Flags;
use super::kind::Kind;
use super::lanes::{Lanes, ROW, lane, lane_title};
use crate::fly::change::Since;
use crate::fly::drawing::{Layout, Picture};
use crate::fly::flight::Flight;
use crate::fly::record::Bus;

const AXIS: f64 = 26.0;

/// Time shown before a fault, and after the instant at which the first slave works again.
const BEFORE: Time = Time::from_ms(400);
const AFTER: Time = Time::from_ms(600);

/// The whole flight.
pub fn overview(flight: &Flight, layout: Layout) -> Picture {
    draw(flight, Axis::new(layout, Time::ZERO, flight.end), "", "Frames on the two buses over the whole run")
}

/// Draws the time around a fault, until the first slave works again; `None` in a flight without this fault.
pub fn close_up(flight: &Flight, since: Since, layout: Layout) -> Option<Picture> {
    let (fault, title) = match since {
        Since::Cut => (flight.cut()?.0, "Frames around the cut"),
        Since::Loss => (flight.loss()?.0, "Frames around the takeover"),
    };
    let times = flight.observer.slaves().filter_map(|(_, track)| match since {
        Since::Cut => track.failover,
        Since::Loss => track.takeover,
    });
    let switch = flight.switch().filter(|at| *at >= fault).map(|at| at.since(fault));
    let after = times.min().or(switch).unwrap_or_default() + AFTER;
    let until = (fault + after).min(flight.end);
    (until > fault).then(|| draw(flight, Axis::new(layout, fault - BEFORE, until), " thick", title))
}

fn draw(flight: &Flight, axis: Axis, tick_class: &str, title: &str) -> Picture {
    let (layout, flags) = (axis.layout, Flags::of(flight, &axis));
    let lanes = Lanes::new(flight, Bus::ALL.map(|bus| flags.height(bus)));
    let height = lanes.bottom(Bus::Redundant) + AXIS;
    let mut picture = Picture::new(layout.width, height, title, SHEETS);
    let (left, right) = layout.plot();
    for bus in Bus::ALL {
        picture.rect("lane", left, lanes.top(bus), right - left, lane(&lanes.rows));
    }
    shade_active(flight, &axis, &lanes, &mut picture);
    axis.draw(&mut picture, lanes.top(Bus::Nominal), lanes.bottom(Bus::Redundant));
    for bus in Bus::ALL {
        // In a narrow layout the title is wider than the names of the rows, so it begins at the border.
        let (anchor, x) = if layout.brief { ("", 0.0) } else { (" end", left - 12.0) };
        picture.text(&format!("bus-{}{anchor}", bus.name()), x, lanes.top(bus) - 9.0, &lane_title(bus));
        for (row, kind) in lanes.rows.iter().enumerate() {
            let y = lanes.row_top(bus, row);
            let [name, brief, _] = kind.look();
            picture.text("soft end", left - 12.0, y + 11.0, if layout.brief { brief } else { name });
        }
        let others = Kind::OTHERS.iter().map(|kind| (0, kind));
        for (row, &kind) in lanes.rows.iter().enumerate().chain(others) {
            let places: BTreeSet<i64> = flight
                .frames()
                .filter(|(at, seen)| seen.bus == bus && axis.shows(*at) && Kind::of(seen) == kind)
                .map(|(at, _)| (axis.x(at) * 5.0).round() as i64 * 2)
                .collect();
            let [.., class] = kind.look();
            picture.ticks(&format!("{class}{tick_class}"), places, lanes.row_top(bus, row), ROW - 4.0);
        }
    }
    flags.draw(&mut picture, &lanes);
    picture
}

/// Shades the bus with the master's heartbeat.
fn shade_active(flight: &Flight, axis: &Axis, lanes: &Lanes, picture: &mut Picture) {
    for (bus, begin, end) in active_spans(flight) {
        let (x, until) = (axis.x(begin), axis.x(end));
        picture.rect("active", x, lanes.top(bus), until - x, lanes.bottom(bus) - lanes.top(bus));
    }
}

/// Returns the spans from the first to the last heartbeat of a master on a bus. A span that was ended by a cut or a
/// loss ends at that fault; the last span of a flight extends to its end.
fn active_spans(flight: &Flight) -> Vec<(Bus, Time, Time)> {
    let mut beats = flight
        .frames()
        .filter(|(_, seen)| Kind::of(seen) == Kind::Master)
        .map(|(at, seen)| (at, (seen.bus, seen.from)))
        .peekable();
    let mut spans = Vec::new();
    while let Some((begin, place)) = beats.next() {
        let (mut last, (bus, board)) = (begin, place);
        while let Some((at, _)) = beats.next_if(|(_, next)| *next == place) {
            last = at;
        }
        let next = beats.peek().map(|(at, _)| *at);
        let cut = flight.cut().filter(|(_, cut)| *cut == bus).map(|(at, _)| at);
        let loss = flight.loss().filter(|(_, lost)| *lost == board).map(|(at, _)| at);
        let is_after = |at: &Time| *at >= last && next.is_none_or(|next| *at <= next);
        let silenced = [cut, loss].into_iter().flatten().filter(is_after).min();
        spans.push((bus, begin, silenced.unwrap_or(if next.is_some() { last } else { flight.end })));
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fly::sample;

    fn spans(flight: &Flight) -> Vec<(Bus, u64, u64)> {
        let ms = |at: Time| at.as_us() / 1000;
        active_spans(flight).into_iter().map(|(bus, begin, end)| (bus, ms(begin), ms(end))).collect()
    }

    #[test]
    fn active_bus_is_that_of_the_heartbeat() {
        let expected = [(Bus::Nominal, 50, 20_000), (Bus::Redundant, 20_600, 40_000)];
        assert_eq!(spans(&sample::flight()), expected);
    }

    /// Given claims on both buses, then only 701h makes a bus the active one. The cut leaves a slave that acknowledges, so the nominal
    /// bus is active to the last heartbeat there; the redundant one until the loss of the master, and from the takeover on.
    #[test]
    fn claims_make_no_bus_the_active_one() {
        let expected =
            [(Bus::Nominal, 901, 11_101), (Bus::Redundant, 11_201, 20_000), (Bus::Redundant, 20_301, 40_000)];
        assert_eq!(spans(&sample::standby::flight()), expected);
    }
}
