//! What every node did over time: a bar per node, coloured by state, underlined by bus.

use can_wire::time::Time;

use super::axis::{Axis, Layout, text_width};
use super::svg::Svg;
use crate::flight::Flight;
use crate::narrator::name;

const TOP: f64 = 26.0;
const ROW: f64 = 40.0;
const BAR: f64 = 20.0;
const UNDERLINE: f64 = 4.0;
const AXIS: f64 = 26.0;

/// Bars of all nodes over the whole flight.
pub fn draw(flight: &Flight, layout: Layout) -> Svg {
    let Layout { width: whole, left, .. } = layout;
    let axis = Axis::new(layout, Time::ZERO, flight.end);
    let nodes = flight.observer.nodes();
    let bottom = TOP + nodes.len() as f64 * ROW;
    let mut svg = Svg::new(whole, bottom + AXIS, "States of all nodes over time");
    svg.rect("paper", 0.0, 0.0, whole, bottom + AXIS);
    axis.draw(&mut svg, TOP, bottom);
    for (row, (&node, track)) in nodes.iter().enumerate() {
        let y = TOP + row as f64 * ROW + 6.0;
        svg.text("label end", left - 12.0, y + 11.0, &name(node));
        let kind = if track.is_minimal && layout.brief { "minimal".to_owned() } else { track.kind() };
        svg.text("soft end", left - 12.0, y + 25.0, &kind);
        let ends = track.spans.iter().skip(1).map(|span| span.from).chain([flight.end]);
        for (span, end) in track.spans.iter().zip(ends) {
            let (x, width) = (axis.x(span.from), axis.x(end) - axis.x(span.from));
            let hint = format!(
                "{}: {} on the {} bus, {:.4} s to {:.4} s",
                name(node),
                span.phase.name(),
                span.bus.name(),
                span.from.as_secs_f64(),
                end.as_secs_f64()
            );
            svg.rect_with_hint(&format!("phase-{}", span.phase.name()), [x, y, width, BAR], &hint);
            if span.phase.is_powered() {
                svg.rect(&format!("on-{}", span.bus.name()), x, y + BAR, width, UNDERLINE);
            }
            let phase = span.phase.name();
            let words = [format!("{phase}, {}", span.bus.name()), phase.to_owned()];
            if let Some(words) = words.iter().find(|words| text_width(words) + 16.0 <= width) {
                svg.text("in-bar", x + 8.0, y + 14.0, words);
            }
        }
    }
    if let Some(fault) = flight.fault() {
        let (x, label) = (axis.x(fault), if flight.cut().is_some() { "cut" } else { "power off" });
        svg.line("cut", (x, TOP - 4.0), (x, bottom));
        svg.text("cut-label middle", x, TOP - 10.0, label);
    }
    svg
}
