//! The picture of a waveform: for every node its fields, what it sends, what it sees and samples, and its events.

mod bands;
mod classes;
mod notes;
mod ruler;
mod sheet;

use can_wire::waveform::{Bit, Waveform};

use crate::key;
use crate::picture::Picture;
use classes::SHEETS;
use ruler::Ruler;
use sheet::Sheet;

/// Left of the traces: names.
const MARGIN: f64 = 116.0;
/// Right of them, above and below everything.
const EDGE: f64 = 18.0;
const TITLE: f64 = 26.0;
const AXIS: f64 = 38.0;
/// Between two nodes.
const SPACE: f64 = 18.0;
const LEGEND: f64 = 26.0;

/// How a waveform is drawn.
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

/// Draws a lane for each node.
pub fn draw(waveform: &Waveform, options: Options) -> Picture {
    let ruler = Ruler::new(waveform, options.bit_width);
    let top = EDGE + if options.title.is_empty() { 0.0 } else { TITLE } + AXIS;
    let width = (ruler.right() + EDGE).ceil();
    let (mut lanes, mut y) = (Picture::new(width, 0.0, "", SHEETS), top);
    for lane in &waveform.lanes {
        let name = options.names.get(lane.node).copied();
        y += Sheet { lane, ruler: &ruler, y }.draw(&mut lanes, name) + SPACE;
    }
    let (marks, words): (Vec<Mark>, Vec<&str>) = legend(waveform).into_iter().unzip();
    let places = key::places(&words, 11.0, (EDGE, ruler.right()));
    let height = (y + key::height(&places) + LEGEND).ceil();
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

/// Draws a mark of the legend: its left end, and the middle of its height.
type Mark = fn(&mut Picture, f64, f64);

/// The marks of a waveform, and what they mean.
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
