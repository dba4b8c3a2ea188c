//! Size of pictures and texts.

/// Height of letters of the usual size, in SVG units.
pub const LETTERS: f64 = 13.0;

/// Widths of a picture, in SVG units, and length of its texts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Width of the picture.
    pub width: f64,
    /// Left end of the plot; the names of the rows are left of it.
    pub left: f64,
    /// Space right of the plot.
    margin: f64,
    /// Approximate greatest number of marks on a horizontal axis.
    pub marks: f64,
    /// Short names instead of long ones.
    pub brief: bool,
}

impl Layout {
    /// For screens and paper.
    pub const WIDE: Layout = Layout { width: 1160.0, left: 150.0, margin: 20.0, marks: 10.0, brief: false };

    /// For a phone: the width of a page of 400 px, so that letters keep their size.
    pub const NARROW: Layout = Layout { width: 348.0, left: 90.0, margin: 16.0, marks: 5.0, brief: true };

    /// Returns the left and right end of the plot.
    pub fn plot(&self) -> (f64, f64) {
        (self.left, self.width - self.margin)
    }

    /// Returns whether a text that begins at `x` ends inside the picture, by the width of an average letter.
    pub fn has_room(&self, x: f64, text: &str) -> bool {
        x + text_width(text, LETTERS) <= self.width
    }
}

/// Returns the approximate width of a text in bold letters of a height, in SVG units.
pub fn text_width(text: &str, letters: f64) -> f64 {
    text.chars().count() as f64 * letters * 0.58
}
