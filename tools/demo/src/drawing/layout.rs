//! How much room a picture has, and how much of it a text needs.

/// Height of letters of the usual size, in SVG units.
pub const LETTERS: f64 = 13.0;

/// How wide a picture is, in SVG units, and how many words there is room for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Width of the picture.
    pub width: f64,
    /// Where the plot begins: left of it stand the names of the rows.
    pub left: f64,
    /// Room right of the plot.
    margin: f64,
    /// Greatest number of marks on an axis across the picture, approximately.
    pub marks: f64,
    /// Short names instead of long ones.
    pub brief: bool,
}

impl Layout {
    /// For screens and paper.
    pub const WIDE: Layout = Layout { width: 1160.0, left: 150.0, margin: 20.0, marks: 10.0, brief: false };

    /// For a phone: as wide as a page of 400 px leaves it, so that letters keep their size.
    pub const NARROW: Layout = Layout { width: 348.0, left: 90.0, margin: 16.0, marks: 5.0, brief: true };

    /// Left and right end of the plot.
    pub fn plot(&self) -> (f64, f64) {
        (self.left, self.width - self.margin)
    }

    /// Whether a text that begins at `x` ends inside the picture, by the width of an average letter.
    pub fn has_room(&self, x: f64, text: &str) -> bool {
        x + text_width(text, LETTERS) <= self.width
    }
}

/// About the width of a text in bold letters of a height, in SVG units.
pub fn text_width(text: &str, letters: f64) -> f64 {
    text.chars().count() as f64 * letters * 0.58
}
