//! The strip of one node in a waveform.

use can_twin::wire::field::Field;
use can_twin::wire::time::Time;
use can_twin::wire::waveform::{Bit, Lane};

use super::bands::{Band, bands};
use super::notes::{Note, notes};
use super::{EDGE, MARGIN, Ruler};
use crate::fly::drawing::layout::text_width;
use crate::fly::drawing::picture::Picture;

const BAND: f64 = 26.0;
/// Height from recessive to dominant.
const SWING: f64 = 18.0;
/// Space between the traces of a node.
const GAP: f64 = 9.0;
const DIGITS: f64 = 14.0;
const NOTE: f64 = 15.0;

/// A lane and the top of its strip.
pub(super) struct Strip<'a> {
    pub(super) lane: &'a Lane,
    pub(super) ruler: &'a Ruler,
    pub(super) y: f64,
}

impl Strip<'_> {
    /// Draws the strip and returns its height.
    pub(super) fn draw(&self, picture: &mut Picture, name: Option<&str>) -> f64 {
        let Strip { lane, ruler, y } = *self;
        let tx = y + BAND + GAP;
        let rx = tx + SWING + GAP;
        let digits = rx + SWING + if ruler.is_detailed { DIGITS } else { 0.0 };
        let number = format!("node {}", lane.node);
        picture.text("node", EDGE, y + 12.0, name.unwrap_or(&number));
        picture.text("soft", EDGE, y + 26.0, &format!("at {} m", lane.position_m));
        picture.text("sends", MARGIN - 8.0, tx + SWING / 2.0 + 4.0, "sends");
        picture.text("sees", MARGIN - 8.0, rx + SWING / 2.0 + 4.0, "sees");
        let bands = bands(lane);
        for band in &bands {
            let (from, to) = (ruler.x(band.from), ruler.x(band.to));
            let (class, names) = band.look();
            picture.rect_with_hint(&format!("band {class}"), [from, y, to - from, BAND], &names[0]);
        }
        for bit in lane.bits.iter().filter(|bit| bit.field == Field::Stuff) {
            let (from, to) = (ruler.x(bit.start), ruler.x(bit.end));
            picture.rect("stuff", from, y, to - from, digits - y);
        }
        for band in &bands {
            self.name(picture, band);
        }
        let rows = self.notes(picture, digits + GAP / 2.0, rx);
        for (from, to, _) in spans(&lane.driver, ruler.to).filter(|(.., recessive)| !recessive) {
            let (from, to) = (ruler.x(from), ruler.x(to));
            picture.rect("drives", from, tx, to - from, SWING);
        }
        self.trace(picture, "tx", &lane.driver, tx);
        self.trace(picture, "rx", &lane.line, rx);
        for bit in lane.bits.iter().filter(|bit| bit.field != Field::Idle) {
            self.sample(picture, bit, rx);
        }
        digits + GAP / 2.0 + rows as f64 * NOTE - y
    }

    /// Draws the longest name of a field for which there is room.
    fn name(&self, picture: &mut Picture, band: &Band) {
        let (from, to) = (self.ruler.x(band.from), self.ruler.x(band.to));
        let (room, x, y) = (to - from, (from + to) / 2.0, self.y + BAND / 2.0);
        let (_, names) = band.look();
        if let Some(name) = names.iter().find(|name| text_width(name, 10.5) + 2.0 <= room) {
            picture.text("name", x, y + 4.0, name);
        } else if let Some(name) = names.iter().find(|name| text_width(name, 8.5) <= BAND && room >= 8.0) {
            picture.text_upwards("narrow", x + 3.0, y, name);
        }
    }

    /// Draws levels over time. Recessive is up.
    fn trace(&self, picture: &mut Picture, class: &str, changes: &[(Time, bool)], y: f64) {
        let mut points = Vec::new();
        for (from, to, is_recessive) in spans(changes, self.ruler.to) {
            let y = if is_recessive { y } else { y + SWING };
            points.extend([(self.ruler.x(from), y), (self.ruler.x(to), y)]);
        }
        picture.path(class, &points);
    }

    /// Draws the sample point of a bit, its value, and changes of its length or value.
    fn sample(&self, picture: &mut Picture, bit: &Bit, rx: f64) {
        let ruler = self.ruler;
        let x = ruler.x(bit.sample);
        let level = if bit.sampled != bit.flipped { rx } else { rx + SWING };
        picture.circle("sample", x, level, if ruler.is_detailed { 2.3 } else { 1.5 });
        if bit.flipped {
            picture.circle("flip", x, level, 5.0);
        }
        if bit.resynchronised != 0 {
            let (nominal, end) = (Time((bit.end.0 as i64 - bit.resynchronised) as u64), bit.end);
            let (from, to) = (ruler.x(nominal.min(end)), ruler.x(nominal.max(end)));
            picture.rect("resync", from, rx - 3.0, to - from, SWING + 6.0);
        }
        if ruler.is_detailed {
            let class = if bit.field == Field::Stuff { "digit stuffed" } else { "digit" };
            let x = (ruler.x(bit.start) + ruler.x(bit.end)) / 2.0;
            picture.text(class, x, rx + SWING + DIGITS - 2.0, if bit.sampled { "1" } else { "0" });
        }
    }

    /// Draws the notes below `y`, each in the first row with room, with a line from `from`. Returns the number of rows.
    fn notes(&self, picture: &mut Picture, y: f64, from: f64) -> usize {
        let mut words = Vec::new();
        // End of the used part of each row.
        let mut rows: Vec<f64> = Vec::new();
        for Note { at, text, class } in notes(self.lane) {
            let (x, room) = (self.ruler.x(at), text_width(&text, 11.0) + 8.0);
            let is_left = x + room > self.ruler.right();
            let (begin, end) = if is_left { (x - room, x) } else { (x, x + room) };
            let row = rows.iter().position(|&taken| taken <= begin).unwrap_or(rows.len());
            rows.resize(rows.len().max(row + 1), 0.0);
            rows[row] = end;
            let base = y + row as f64 * NOTE + 11.0;
            picture.line(&format!("leader{class}"), (x, from), (x, base));
            let (x, align) = if is_left { (x - 4.0, " end") } else { (x + 4.0, "") };
            words.push((format!("note{class}{align}"), x, base, text));
        }
        for (class, x, y, text) in words {
            picture.text(&class, x, y, &text);
        }
        rows.len()
    }
}

/// Levels with their begin and end, up to `to`.
fn spans(changes: &[(Time, bool)], to: Time) -> impl Iterator<Item = (Time, Time, bool)> {
    let ends = changes.iter().skip(1).map(|&(at, _)| at).chain([to]);
    changes.iter().zip(ends).map(|(&(from, level), end)| (from, end, level))
}
