//! States of all nodes over time: a bar per node, coloured by state, underlined by bus.

use can_twin::wire::time::Time;

use super::SHEETS;
use super::axis::Axis;
use super::faults::Marks;
use crate::fly::drawing::{LETTERS, Layout, Picture, text_width};
use crate::fly::flight::Flight;
use crate::fly::narrator::name;

/// Top of the plot if the names of the faults need one row.
const TOP: f64 = 26.0;
const ROW: f64 = 40.0;
const BAR: f64 = 20.0;
const UNDERLINE: f64 = 4.0;
const AXIS: f64 = 26.0;

/// Bars of all nodes over the whole flight.
pub fn draw(flight: &Flight, layout: Layout) -> Picture {
    let Layout { width: whole, left, .. } = layout;
    let axis = Axis::new(layout, Time::ZERO, flight.end);
    let nodes = &flight.observer.nodes;
    let marks = Marks::of(flight, &axis);
    let top = TOP + marks.height();
    let bottom = top + nodes.len() as f64 * ROW;
    let mut picture = Picture::new(whole, bottom + AXIS, "States of all nodes over time", SHEETS);
    axis.draw(&mut picture, top, bottom);
    for (row, (&node, track)) in nodes.iter().enumerate() {
        let y = top + row as f64 * ROW + 6.0;
        picture.text("label end", left - 12.0, y + 11.0, &name(node));
        let kind = if track.is_minimal && layout.brief { "minimal".to_owned() } else { track.kind() };
        picture.text("soft end", left - 12.0, y + 25.0, &kind);
        let ends = track.spans.iter().skip(1).map(|span| span.from).chain([flight.end]);
        for (span, end) in track.spans.iter().zip(ends) {
            let (x, width) = (axis.x(span.from), axis.x(end) - axis.x(span.from));
            let phase = track.name_of(span.phase);
            let on = format!(" on the {} bus", span.bus.name());
            let on = if span.phase.is_powered() { &on } else { "" };
            let [from, to] = [span.from, end].map(|at| format!("{:.4} s", at.as_secs_f64()));
            let hint = format!("{}: {phase}{on}, {from} to {to}", name(node));
            picture.rect_with_hint(&format!("phase-{}", span.phase.name()), [x, y, width, BAR], &hint);
            if span.phase.is_powered() {
                picture.rect(&format!("on-{}", span.bus.name()), x, y + BAR, width, UNDERLINE);
            }
            let words = [format!("{phase}, {}", span.bus.name()), phase.to_owned()];
            let words = if span.phase.is_powered() { &words } else { &words[1..] };
            if let Some(words) = words.iter().find(|words| text_width(words, LETTERS) + 16.0 <= width) {
                picture.text("in-bar", x + 8.0, y + 14.0, words);
            }
        }
    }
    marks.draw(&mut picture, top, bottom, 10.0);
    picture
}
