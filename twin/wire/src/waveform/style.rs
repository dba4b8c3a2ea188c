//! Measures and colours of a waveform's picture. It brings its own paper, so that it looks the same everywhere.

/// Left of the traces: names.
pub(super) const MARGIN: f64 = 116.0;
/// Right of them, above and below everything.
pub(super) const EDGE: f64 = 18.0;
pub(super) const TITLE: f64 = 26.0;
pub(super) const AXIS: f64 = 38.0;
pub(super) const BAND: f64 = 26.0;
/// From recessive to dominant.
pub(super) const SWING: f64 = 18.0;
/// Between the traces of a node.
pub(super) const GAP: f64 = 9.0;
pub(super) const DIGITS: f64 = 14.0;
pub(super) const NOTE: f64 = 15.0;
/// Between two nodes.
pub(super) const SPACE: f64 = 18.0;
pub(super) const LEGEND: f64 = 26.0;

/// Width of a character of a text in `px`, for all the fonts that a browser may take.
pub(super) fn width(text: &str, px: f64) -> f64 {
    text.chars().count() as f64 * px * 0.58
}

pub(super) const SHEET: &str = "
text { font: 11px system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif; fill: #1b2330; }
.paper { fill: #ffffff; stroke: #d0d5dd; }
.title { font-size: 15px; font-weight: 600; }
.node { font-size: 13px; font-weight: 600; }
.soft { fill: #667085; }
.grid { stroke: #e9ecf1; }
.grid.zero { stroke: #98a2b3; }
.lane { fill: #fafbfc; }
.band { stroke: #ffffff; stroke-width: 1; }
.name { font-size: 10.5px; text-anchor: middle; }
.narrow { font-size: 8.5px; text-anchor: middle; }
.stuff { fill: #f59e0b; fill-opacity: 0.30; }
.stuffed { fill: #b45309; font-weight: 700; }
.digit { font-size: 9px; text-anchor: middle; fill: #475467; }
.tx { fill: none; stroke: #2563b0; stroke-width: 1.8; stroke-linejoin: round; }
.rx { fill: none; stroke: #3b4454; stroke-width: 1.5; stroke-linejoin: round; }
text.is-tx { fill: #2563b0; font-size: 10px; text-anchor: end; }
text.is-rx { fill: #3b4454; font-size: 10px; text-anchor: end; }
.drives { fill: #2563b0; fill-opacity: 0.13; }
.sample { fill: #0f8577; }
.flip { fill: none; stroke: #c4232f; stroke-width: 1.8; }
.resync { fill: #9333ea; fill-opacity: 0.55; }
.leader { stroke: #98a2b3; stroke-dasharray: 2 2; }
.leader.error { stroke: #c4232f; }
.leader.shift { stroke: #9333ea; }
.note { fill: #344054; stroke: #ffffff; stroke-width: 3px; stroke-linejoin: round; paint-order: stroke; }
.note.error { fill: #b01c28; font-weight: 600; }
.note.shift { fill: #7e22ce; }
.sof { fill: #c9ced8; }
.id { fill: #c7dcfa; }
.control { fill: #ddd7f6; }
.dlc { fill: #c6e8e2; }
.data { fill: #fdecb8; }
.crc { fill: #d7e8bd; }
.fixed { fill: #e6e9ee; }
.ack { fill: #a9dfb8; }
.between { fill: #f2f4f7; }
.flag { fill: #f2918a; }
.passive { fill: #fbd3cf; }
.overload { fill: #eeb2dd; }
.superposition { fill: #f9c29b; }
.delimiter { fill: #f6e0da; }
";
