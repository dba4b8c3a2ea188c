//! A waveform as SVG: for every node its fields, what it sends, what it sees and samples, and what it is told.

use svg::Document;
use svg::Node as _;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Line, Path, Rectangle, Style, Text, Title};

use super::bands::{Band, bands};
use super::notes::{Note, notes};
use super::style::{AXIS, BAND, DIGITS, EDGE, GAP, LEGEND, MARGIN, NOTE, SHEET, SPACE, SWING, TITLE, width};
use super::{Bit, Lane, Waveform};
use crate::controller::WireEvent;
use crate::field::Field;
use crate::mac::{DOMINANT, RECESSIVE};
use crate::time::{TICKS_PER_US, Time};

/// Narrowest bit with digits and resynchronisations in numbers, px.
const DETAILED: f64 = 9.0;

/// How a waveform is to be drawn.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    waveform: &'a Waveform,
    title: &'a str,
    names: &'a [&'a str],
    bit_px: f64,
}

impl Waveform {
    /// A picture with one lane per node, 16 px per bit.
    pub fn picture(&self) -> Picture<'_> {
        Picture { waveform: self, title: "", names: &[], bit_px: 16.0 }
    }
}

impl<'a> Picture<'a> {
    /// With a heading.
    #[must_use]
    pub fn title(self, title: &'a str) -> Self {
        Picture { title, ..self }
    }

    /// With names of the nodes, by index of attachment; the others have their number.
    #[must_use]
    pub fn names(self, names: &'a [&'a str]) -> Self {
        Picture { names, ..self }
    }

    /// With bits of this width.
    #[must_use]
    pub fn bit_px(self, bit_px: f64) -> Self {
        Picture { bit_px, ..self }
    }

    /// The SVG document.
    pub fn render(&self) -> String {
        let scale = Scale::new(self.waveform, self.bit_px);
        let mut lanes = Group::new();
        let top = EDGE + if self.title.is_empty() { 0.0 } else { TITLE } + AXIS;
        let mut y = top;
        for lane in &self.waveform.lanes {
            let sheet = Sheet { lane, scale: &scale, y, detailed: self.bit_px >= DETAILED };
            let (drawn, height) = sheet.draw(self.names.get(lane.node).copied());
            lanes.append(drawn);
            y += height + SPACE;
        }
        let (wide, high) = (scale.right() + EDGE, y + LEGEND);
        let mut document = Document::new()
            .set("viewBox", (0, 0, wide.ceil() as i32, high.ceil() as i32))
            .set("role", "img")
            .add(Style::new(SHEET))
            .add(rectangle("paper", 0.5, 0.5, wide - 1.0, high - 1.0).set("rx", 8));
        if !self.title.is_empty() {
            document.append(Title::new(self.title));
            document.append(text(self.title, "title", EDGE, EDGE + 13.0));
        }
        document.append(scale.draw(top, y - SPACE));
        document.append(lanes);
        document.append(legend(self.waveform, y + 4.0));
        format!("{document}\n")
    }
}

/// Times as places.
struct Scale {
    from: Time,
    to: Time,
    /// SOF of the first frame.
    zero: Time,
    bit: Time,
    bit_px: f64,
}

impl Scale {
    fn new(waveform: &Waveform, bit_px: f64) -> Self {
        let starts = waveform.lanes.iter().flat_map(|lane| &lane.events);
        let starts = starts.filter(|(at, event)| *event == WireEvent::Started && *at >= waveform.from);
        let zero = starts.map(|&(at, _)| at).min().unwrap_or(waveform.from);
        let bit = waveform.lanes.iter().map(|lane| lane.bit_time).min().unwrap_or(Time::from_us(1));
        Scale { from: waveform.from, to: waveform.to, zero, bit, bit_px }
    }

    /// Within the picture, whatever the time.
    fn x(&self, at: Time) -> f64 {
        let at = at.clamp(self.from, self.to);
        MARGIN + at.since(self.from).0 as f64 / self.bit.0 as f64 * self.bit_px
    }

    fn right(&self) -> f64 {
        self.x(self.to)
    }

    /// Grid and axis: bit times from the first SOF, and microseconds.
    fn draw(&self, top: f64, bottom: f64) -> Group {
        let mut group = Group::new().add(text("bit times", "soft is-axis", EDGE, top - 20.0)).add(text(
            "µs",
            "soft is-axis",
            EDGE,
            top - 7.0,
        ));
        let every = if self.bit_px >= DETAILED { 5 } else { 10 * (DETAILED / self.bit_px).ceil() as u64 };
        let bits_before = self.zero.since(self.from).0 / self.bit.0;
        let first = (bits_before / every) as i64 * -(every as i64);
        let mut bit = first;
        loop {
            let at = Time((self.zero.0 as i64 + bit * self.bit.0 as i64) as u64);
            if at > self.to {
                return group;
            }
            let x = self.x(at);
            group.append(line(if bit == 0 { "grid zero" } else { "grid" }, x, top - 4.0, x, bottom));
            group.append(middle(text(&bit.to_string(), "soft", x, top - 20.0)));
            let us = format!("{:.1}", at.0 as f64 / TICKS_PER_US as f64);
            let us = us.strip_suffix(".0").unwrap_or(&us);
            group.append(middle(text(us, "soft", x, top - 7.0)));
            bit += every as i64;
        }
    }
}

/// A lane and where it comes.
struct Sheet<'a> {
    lane: &'a Lane,
    scale: &'a Scale,
    y: f64,
    detailed: bool,
}

impl Sheet<'_> {
    /// The lane and its height.
    fn draw(&self, name: Option<&str>) -> (Group, f64) {
        let Sheet { lane, scale, y, detailed } = *self;
        let tx = y + BAND + GAP;
        let rx = tx + SWING + GAP;
        let digits = rx + SWING + if detailed { DIGITS } else { 0.0 };
        let (notes, rows) = self.notes(digits + GAP / 2.0, rx);
        let height = digits + GAP / 2.0 + rows as f64 * NOTE - y;
        let number = format!("node {}", lane.node);
        let mut group = Group::new()
            .add(text(name.unwrap_or(&number), "node", EDGE, y + 12.0))
            .add(text(&format!("at {} m", lane.position_m), "soft", EDGE, y + 26.0))
            .add(text("sends", "is-tx", MARGIN - 8.0, tx + SWING / 2.0 + 4.0))
            .add(text("sees", "is-rx", MARGIN - 8.0, rx + SWING / 2.0 + 4.0));
        let bands = bands(lane);
        for band in &bands {
            let (from, to) = (scale.x(band.from), scale.x(band.to));
            let rectangle = rectangle(&format!("band {}", band.class()), from, y, to - from, BAND);
            group.append(rectangle.add(Title::new(band.names().swap_remove(0))));
        }
        for bit in lane.bits.iter().filter(|bit| bit.field == Field::Stuff) {
            let (from, to) = (scale.x(bit.start), scale.x(bit.end));
            group.append(rectangle("stuff", from, y, to - from, digits - y));
        }
        for band in &bands {
            group.append(self.name(band));
        }
        group.append(notes);
        for pair in spans(&lane.driver, scale.to).filter(|&(.., level)| level == DOMINANT) {
            let (from, to) = (scale.x(pair.0), scale.x(pair.1));
            group.append(rectangle("drives", from, tx, to - from, SWING));
        }
        group.append(self.trace("tx", &lane.driver, tx));
        group.append(self.trace("rx", &lane.line, rx));
        for bit in lane.bits.iter().filter(|bit| bit.field != Field::Idle) {
            let x = scale.x(bit.sample);
            let level = if bit.sampled != bit.flipped { rx } else { rx + SWING };
            group.append(circle("sample", x, level, if detailed { 2.3 } else { 1.5 }));
            if bit.flipped {
                group.append(circle("flip", x, level, 5.0));
            }
            if bit.resynchronised != 0 {
                let (nominal, end) = (Time((bit.end.0 as i64 - bit.resynchronised) as u64), bit.end);
                let (a, b) = (scale.x(nominal.min(end)), scale.x(nominal.max(end)));
                group.append(rectangle("resync", a, rx - 3.0, b - a, SWING + 6.0));
            }
            if detailed {
                group.append(self.digit(bit, rx + SWING + DIGITS - 2.0));
            }
        }
        (group, height)
    }

    fn digit(&self, bit: &Bit, y: f64) -> Text {
        let x = (self.scale.x(bit.start) + self.scale.x(bit.end)) / 2.0;
        let class = if bit.field == Field::Stuff { "digit stuffed" } else { "digit" };
        text(if bit.sampled { "1" } else { "0" }, class, x, y)
    }

    /// As much of the name of a field as it has room for.
    fn name(&self, band: &Band) -> Group {
        let (from, to) = (self.scale.x(band.from), self.scale.x(band.to));
        let (room, x, y) = (to - from, (from + to) / 2.0, self.y + BAND / 2.0);
        let names = band.names();
        let mut group = Group::new();
        if let Some(name) = names.iter().find(|name| width(name, 10.5) + 2.0 <= room) {
            group.append(text(name, "name", x, y + 4.0));
        } else if let Some(name) = names.iter().find(|name| width(name, 8.5) <= BAND && room >= 8.0) {
            let turned = format!("rotate(-90 {} {})", round(x), round(y));
            group.append(text(name, "narrow", x, y + 3.0).set("transform", turned));
        }
        group
    }

    /// Recessive is up.
    fn trace(&self, class: &str, changes: &[(Time, bool)], y: f64) -> Path {
        let height = |level| if level == RECESSIVE { y } else { y + SWING };
        let mut data = Data::new();
        for (n, (from, to, level)) in spans(changes, self.scale.to).enumerate() {
            let (x, y) = (round(self.scale.x(from)), round(height(level)));
            data = if n == 0 { data.move_to((x, y)) } else { data.vertical_line_to(y) };
            data = data.horizontal_line_to(round(self.scale.x(to)));
        }
        Path::new().set("class", class).set("d", data)
    }

    /// Remarks below `y` in as many rows as they need, with a line from where they belong, at `from`.
    fn notes(&self, y: f64, from: f64) -> (Group, usize) {
        let (mut leaders, mut words) = (Group::new(), Group::new());
        // Up to where each row is taken.
        let mut rows: Vec<f64> = Vec::new();
        for Note { at, text: remark, class } in notes(self.lane) {
            let (x, room) = (self.scale.x(at), width(&remark, 11.0) + 8.0);
            let left = x + room > self.scale.right();
            let (begin, end) = if left { (x - room, x) } else { (x, x + room) };
            let row = rows.iter().position(|&taken| taken <= begin).unwrap_or(rows.len());
            rows.resize(rows.len().max(row + 1), 0.0);
            rows[row] = end;
            let base = y + row as f64 * NOTE + 11.0;
            let class = class.name();
            leaders.append(line(&format!("leader{class}"), x, from, x, base));
            let place = if left { x - 4.0 } else { x + 4.0 };
            let note = text(&remark, &format!("note{class}"), place, base);
            words.append(if left { note.set("text-anchor", "end") } else { note });
        }
        (leaders.add(words), rows.len())
    }
}

/// Levels with their begin and end, up to `to`.
fn spans(changes: &[(Time, bool)], to: Time) -> impl Iterator<Item = (Time, Time, bool)> {
    let ends = changes.iter().skip(1).map(|&(at, _)| at).chain([to]);
    changes.iter().zip(ends).map(|(&(from, level), end)| (from, end, level))
}

/// What the marks mean.
fn legend(waveform: &Waveform, y: f64) -> Group {
    let mut group = Group::new();
    let mut x = EDGE;
    let mut entry = |mark: Box<dyn svg::Node>, words: &str| {
        group.append(Group::new().set("transform", format!("translate({} 0)", round(x))).add(mark));
        group.append(text(words, "soft", x + 22.0, y + 4.0));
        x += 22.0 + width(words, 11.0) + 14.0;
    };
    entry(line("tx", 0.0, y, 16.0, y).into(), "what the node sends (up: recessive, 1)");
    entry(line("rx", 0.0, y, 16.0, y).into(), "what it sees");
    entry(circle("sample", 8.0, y, 2.3).into(), "sample point");
    entry(rectangle("stuff", 2.0, y - 7.0, 12.0, 14.0).into(), "stuff bit");
    let has = |is: fn(&Bit) -> bool| waveform.lanes.iter().any(|lane| lane.bits.iter().any(is));
    if has(|bit| bit.resynchronised != 0) {
        let words = "bit made longer or shorter: resynchronisation";
        entry(rectangle("resync", 6.0, y - 7.0, 3.0, 14.0).into(), words);
    }
    if has(|bit| bit.flipped) {
        entry(circle("flip", 8.0, y, 5.0).into(), "sample flipped by a fault");
    }
    group
}

/// A tenth of a pixel is enough.
fn round(px: f64) -> f32 {
    ((px * 10.0).round() / 10.0) as f32
}

fn rectangle(class: &str, x: f64, y: f64, width: f64, height: f64) -> Rectangle {
    let place = Rectangle::new().set("class", class).set("x", round(x)).set("y", round(y));
    place.set("width", round(width)).set("height", round(height))
}

fn line(class: &str, x1: f64, y1: f64, x2: f64, y2: f64) -> Line {
    let from = Line::new().set("class", class).set("x1", round(x1)).set("y1", round(y1));
    from.set("x2", round(x2)).set("y2", round(y2))
}

fn circle(class: &str, x: f64, y: f64, radius: f64) -> Circle {
    Circle::new().set("class", class).set("cx", round(x)).set("cy", round(y)).set("r", round(radius))
}

fn text(words: &str, class: &str, x: f64, y: f64) -> Text {
    Text::new(words).set("class", class).set("x", round(x)).set("y", round(y))
}

fn middle(text: Text) -> Text {
    text.set("text-anchor", "middle")
}
