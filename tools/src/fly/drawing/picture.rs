//! A picture: elements with classes, painted by their attributes.

use std::fmt::Write;

use svg::node::element::{Circle, Element, Line, Path, Rectangle, Style, Text, Title};
use svg::{Document, Node};

use crate::fly::drawing::layout::{LETTERS, text_width};
use crate::fly::drawing::paint::{self, Sheet};

const FONT: &str = "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";

/// A picture under construction. Positions and sizes are in SVG units, from the upper left corner.
#[derive(Clone, Debug)]
pub struct Picture {
    width: f64,
    /// Document with title and background; the style of a separate file follows.
    frame: Document,
    sheets: &'static [Sheet],
    drawn: Vec<Element>,
}

impl Picture {
    /// Makes a picture with background only; the title is for screen readers.
    pub fn new(width: f64, height: f64, title: &str, sheets: &'static [Sheet]) -> Self {
        let mut frame = Document::new()
            .set("class", "chart")
            .set("width", width)
            .set("height", height)
            .set("viewBox", (0, 0, width, height))
            .set("role", "img")
            .set("font-family", FONT)
            .set("font-size", LETTERS);
        if !title.is_empty() {
            frame.append(Title::new(title));
        }
        frame.append(painted(sheets, "paper", rectangle([0.0, 0.0, width, height])));
        Picture { width, frame, sheets, drawn: Vec::new() }
    }

    /// A filled rectangle.
    pub fn rect(&mut self, class: &str, x: f64, y: f64, width: f64, height: f64) {
        self.add(class, rectangle([x, y, width, height]));
    }

    /// A rectangle at x, y with width and height, and a text that appears when pointed at.
    pub fn rect_with_hint(&mut self, class: &str, place: [f64; 4], hint: &str) {
        self.add(class, rectangle(place).add(Title::new(hint)));
    }

    /// A circle about `(x, y)`.
    pub fn circle(&mut self, class: &str, x: f64, y: f64, radius: f64) {
        self.add(class, Circle::new().set("cx", tenth(x)).set("cy", tenth(y)).set("r", tenth(radius)));
    }

    /// A straight line.
    pub fn line(&mut self, class: &str, from: (f64, f64), to: (f64, f64)) {
        let line = Line::new().set("x1", tenth(from.0)).set("y1", tenth(from.1));
        self.add(class, line.set("x2", tenth(to.0)).set("y2", tenth(to.1)));
    }

    /// Text, its baseline at `(x, y)`; classes `end` and `middle` align it.
    pub fn text(&mut self, class: &str, x: f64, y: f64, text: &str) {
        self.add(class, Text::new(text).set("x", tenth(x)).set("y", tenth(y)));
    }

    /// Draws the number of a mark below a plot: centred at `x`, inside the picture.
    pub(in crate::fly) fn number_below(&mut self, (x, bottom): (f64, f64), number: &str) {
        let x = x.min(self.width - text_width(number, LETTERS) / 2.0);
        self.text("soft middle", x, bottom + 16.0, number);
    }

    /// Text that reads upwards, its baseline at `(x, y)`.
    pub fn text_upwards(&mut self, class: &str, x: f64, y: f64, text: &str) {
        let turn = format!("rotate(-90 {} {})", tenth(x), tenth(y));
        self.add(class, Text::new(text).set("x", tenth(x)).set("y", tenth(y)).set("transform", turn));
    }

    /// Draws vertical ticks of one height at many positions, in tenths of a unit, as one element.
    pub fn ticks(&mut self, class: &str, tenths: impl IntoIterator<Item = i64>, y: f64, height: f64) {
        let mut path = String::new();
        for x in tenths {
            let _ = write!(path, "M{}.{} {y:.1}v{height:.1}", x / 10, x % 10);
        }
        self.shape(class, path);
    }

    /// Straight lines from point to point.
    pub fn path(&mut self, class: &str, points: &[(f64, f64)]) {
        let mut path = String::new();
        for (number, (x, y)) in points.iter().enumerate() {
            let _ = write!(path, "{}{x:.1} {y:.1}", if number == 0 { 'M' } else { 'L' });
        }
        self.shape(class, path);
    }

    fn shape(&mut self, class: &str, path: String) {
        if !path.is_empty() {
            self.add(class, Path::new().set("d", path));
        }
    }

    /// Adds all elements of another picture in front.
    pub fn append(&mut self, other: Picture) {
        self.drawn.extend(other.drawn);
    }

    fn add(&mut self, class: &str, element: impl Into<Element>) {
        self.drawn.push(painted(self.sheets, class, element));
    }

    /// Returns the SVG for a page with [`paint::dark`] of the same sheets.
    pub fn inline(&self) -> String {
        self.render(String::new())
    }

    /// Returns the SVG for a separate file.
    pub fn standalone(&self) -> String {
        self.render(paint::dark(self.sheets))
    }

    fn render(&self, style: String) -> String {
        let mut picture = self.frame.clone();
        if !style.is_empty() {
            picture.append(Style::new(style));
        }
        for element in &self.drawn {
            picture.append(element.clone());
        }
        format!("{picture}\n")
    }
}

fn painted(sheets: &[Sheet], class: &str, element: impl Into<Element>) -> Element {
    let mut element = element.into();
    for (name, value) in paint::attributes(sheets, class) {
        element.assign(name, value);
    }
    element
}

fn rectangle([x, y, width, height]: [f64; 4]) -> Rectangle {
    let rectangle = Rectangle::new().set("x", tenth(x)).set("y", tenth(y));
    rectangle.set("width", tenth(width)).set("height", tenth(height))
}

/// Formats a coordinate to a tenth of a unit.
fn tenth(place: f64) -> String {
    format!("{place:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_out() {
        let mut picture = Picture::new(10.0, 10.0, "a < b", &[paint::BASE]);
        picture.text("label", 1.0, 2.0, "</text><script>");
        let drawn = picture.inline();
        assert!(drawn.contains("&lt;/text&gt;&lt;script&gt;"), "{drawn}");
        assert!(drawn.contains("a &lt; b"), "{drawn}");
    }
}
