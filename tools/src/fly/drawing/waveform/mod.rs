//! The picture of a waveform: for every node its fields, sent levels, received levels and samples, and its events.

mod bands;
mod notes;
mod strip;

use can_twin::wire::controller::WireEvent;
use can_twin::wire::time::{TICKS_PER_US, Time};
use can_twin::wire::waveform::{Bit, Waveform};
use strip::Strip;

use crate::fly::drawing::key;
use crate::fly::drawing::paint::Sheet;
use crate::fly::drawing::picture::Picture;
use crate::fly::drawing::scale::{Range, Scale};

/// Space left of the traces for names.
const MARGIN: f64 = 116.0;
/// Space right of the traces, and above and below the picture.
const EDGE: f64 = 18.0;
const TITLE: f64 = 26.0;
const AXIS: f64 = 38.0;
/// Space between two nodes.
const SPACE: f64 = 18.0;
const LEGEND: f64 = 26.0;
/// Narrowest bit with digits and resynchronisations in numbers, in SVG units.
const DETAILED: f64 = 9.0;

/// Colours of the picture. It has its own background, so that it looks the same in light and dark mode.
const SHEETS: &[Sheet] = &[include_str!("waveform.sheet")];

/// Options of a drawing.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Heading; none where it is empty.
    pub title: &'a str,
    /// Names of the nodes, by index of attachment; the others have their number.
    pub names: &'a [&'a str],
    /// Width of a bit, in SVG units.
    pub bit_width: f64,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options { title: "", names: &[], bit_width: 16.0 }
    }
}

/// Draws a strip for each node.
pub fn draw(waveform: &Waveform, options: Options) -> Picture {
    let ruler = Ruler::new(waveform, options.bit_width);
    let top = EDGE + if options.title.is_empty() { 0.0 } else { TITLE } + AXIS;
    let width = (ruler.right() + EDGE).ceil();
    let (mut lanes, mut y) = (Picture::new(width, 0.0, "", SHEETS), top);
    for lane in &waveform.lanes {
        let name = options.names.get(lane.node).copied();
        y += Strip { lane, ruler: &ruler, y }.draw(&mut lanes, name) + SPACE;
    }
    let (marks, words): (Vec<Mark>, Vec<&str>) = legend(waveform).into_iter().unzip();
    let (places, rows) = key::places(&words, 11.0, (EDGE, ruler.right()));
    let height = (y + rows + LEGEND).ceil();
    let mut picture = Picture::new(width, height, options.title, SHEETS);
    picture.rect("border", 0.5, 0.5, width - 1.0, height - 1.0);
    if !options.title.is_empty() {
        picture.text("title", EDGE, EDGE + 13.0, options.title);
    }
    ruler.draw(&mut picture, top, y - SPACE);
    picture.append(lanes);
    for ((mark, words), (x, row)) in marks.iter().zip(words).zip(places) {
        mark(&mut picture, x, y + 4.0 + row);
        picture.text("soft", x + key::MARK, y + 8.0 + row, words);
    }
    picture
}

/// Draws a mark of the legend at its left end and the middle of its height.
type Mark = fn(&mut Picture, f64, f64);

/// Returns the marks of a waveform and their meaning.
fn legend(waveform: &Waveform) -> Vec<(Mark, &'static str)> {
    let mut entries: Vec<(Mark, &str)> = vec![
        (|picture, x, y| picture.line("tx", (x, y), (x + 16.0, y)), "what the node sends (up: recessive, 1)"),
        (|picture, x, y| picture.line("rx", (x, y), (x + 16.0, y)), "what it sees"),
        (|picture, x, y| picture.circle("sample", x + 8.0, y, 2.3), "sample point"),
        (|picture, x, y| picture.rect("stuff", x + 2.0, y - 7.0, 12.0, 14.0), "stuff bit"),
    ];
    let has = |is: fn(&Bit) -> bool| waveform.lanes.iter().any(|lane| lane.bits.iter().any(is));
    if has(|bit| bit.resynchronised != 0) {
        let words = "bit made longer or shorter: resynchronisation";
        entries.push((|picture, x, y| picture.rect("resync", x + 6.0, y - 7.0, 3.0, 14.0), words));
    }
    if has(|bit| bit.flipped) {
        entries.push((|picture, x, y| picture.circle("flip", x + 8.0, y, 5.0), "sample flipped by a fault"));
    }
    entries
}

/// Converts times to positions, with marks at bit times from the first SOF.
struct Ruler {
    scale: Scale,
    /// SOF of the first frame.
    zero: Time,
    /// End of the span.
    to: Time,
    bit: Time,
    is_detailed: bool,
}

impl Ruler {
    fn new(waveform: &Waveform, bit_width: f64) -> Self {
        let starts = waveform.lanes.iter().flat_map(|lane| &lane.events);
        let starts = starts.filter(|(at, event)| *event == WireEvent::Started && *at >= waveform.from);
        let zero = starts.map(|&(at, _)| at).min().unwrap_or(waveform.from);
        let bit = waveform.lanes.iter().map(|lane| lane.bit_time).min().unwrap_or(Time::from_us(1));
        let [from, to] = [waveform.from, waveform.to].map(|at| bits(at, zero, bit));
        let is_detailed = bit_width >= DETAILED;
        let every = if is_detailed { 5.0 } else { 10.0 * (DETAILED / bit_width).ceil() };
        let ends = (MARGIN, MARGIN + (to - from) * bit_width);
        let scale = Scale::new(Range::Linear(from, to, every), ends);
        Ruler { scale, zero, to: waveform.to, bit, is_detailed }
    }

    /// Returns the position of an instant; those outside the span are at its border.
    fn x(&self, at: Time) -> f64 {
        self.scale.place(bits(at, self.zero, self.bit))
    }

    fn right(&self) -> f64 {
        self.x(self.to)
    }

    /// Grid and axis: bit times from the first SOF, and microseconds.
    fn draw(&self, picture: &mut Picture, top: f64, bottom: f64) {
        picture.text("soft", EDGE, top - 20.0, "bit times");
        picture.text("soft", EDGE, top - 7.0, "µs");
        for (bit, x) in self.scale.marks() {
            picture.line(if bit == 0.0 { "grid zero" } else { "grid" }, (x, top - 4.0), (x, bottom));
            picture.text("soft middle", x, top - 20.0, &format!("{bit:.0}"));
            let us = (self.zero.0 as f64 + bit * self.bit.0 as f64) / TICKS_PER_US as f64;
            picture.text("soft middle", x, top - 7.0, &((us * 10.0).round() / 10.0).to_string());
        }
    }
}

/// Returns the bit times from `zero` to an instant.
fn bits(at: Time, zero: Time, bit: Time) -> f64 {
    (at.0 as f64 - zero.0 as f64) / bit.0 as f64
}
