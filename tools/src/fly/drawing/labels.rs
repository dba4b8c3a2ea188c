//! Positions of labels above vertical lines, so that none overlaps another one.
//!
//! A label is in a *row*: row 0 is next to the picture, the others are above it. The line of a label extends to its
//! row.

use crate::fly::drawing::layout::{LETTERS, Layout, text_width};

/// Height of a row.
pub const ROW: f64 = 15.0;

/// Space between a line and a label beside it.
const GAP: f64 = 6.0;

/// Least space between two texts: the reader's font may be wider than the average.
pub const APART: f64 = 8.0;

/// A label and its position.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Position of its line.
    pub line: f64,
    /// Left end of the text.
    pub left: f64,
    /// Right end, by the width of an average letter.
    pub right: f64,
    /// Row of the text.
    pub row: usize,
}

impl Label {
    /// Places a label right of its line, or left of it if there is no room.
    pub fn beside(layout: Layout, line: f64, text: &str) -> Label {
        let width = text_width(text, LETTERS);
        let left = if layout.has_room(line + GAP + APART, text) { line + GAP } else { line - GAP - width };
        Label { line, left, right: left + width, row: 0 }
    }

    /// Places a label above its line, inside the picture.
    pub fn above(layout: Layout, line: f64, text: &str) -> Label {
        let half = text_width(text, LETTERS) / 2.0;
        let middle = line.min(layout.width - half);
        Label { line, left: middle - half, right: middle + half, row: 0 }
    }

    /// Returns whether the text begins right of its line.
    pub fn is_right(&self) -> bool {
        self.left > self.line
    }

    /// Returns the middle of the text.
    pub fn middle(&self) -> f64 {
        (self.left + self.right) / 2.0
    }

    fn overlaps(&self, left: f64, right: f64) -> bool {
        self.left < right + APART && left < self.right + APART
    }

    /// Returns whether this label in `row` overlaps `other`, or the line of the higher label crosses the text of the
    /// lower one.
    fn is_in_the_way(&self, row: usize, other: &Label) -> bool {
        let crosses = |line: f64, text: &Label| (text.left..text.right).contains(&line);
        match row.cmp(&other.row) {
            std::cmp::Ordering::Equal => self.overlaps(other.left, other.right),
            std::cmp::Ordering::Greater => crosses(self.line, other),
            std::cmp::Ordering::Less => crosses(other.line, self),
        }
    }
}

/// Chooses the row of each label, the last one first: its text is right of the other lines, so it may be next to the
/// picture. `taken`: end of a text that is in row 0 already, at the left border. Returns the number of rows above row
/// 0.
pub fn arrange(labels: &mut [Label], taken: f64) -> usize {
    let mut order: Vec<usize> = (0..labels.len()).collect();
    order.sort_by(|a, b| labels[*b].line.total_cmp(&labels[*a].line));
    for (placed, &index) in order.iter().enumerate() {
        let label = &labels[index];
        let is_free = |row: &usize| {
            let mut others = order[..placed].iter().map(|other| &labels[*other]);
            (*row > 0 || label.left >= taken) && !others.any(|other| label.is_in_the_way(*row, other))
        };
        // If lines are so close that no row is free, a row above all others: texts do not overlap there.
        let above = order[..placed].iter().map(|other| labels[*other].row + 1).max().unwrap_or(1);
        labels[index].row = (0..above).find(is_free).unwrap_or(above);
    }
    labels.iter().map(|label| label.row).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Labels with room share the first row. An earlier label is above a near later one, so that no line crosses a
    /// text.
    #[test]
    fn label_before_a_near_one_is_above_it() {
        for (lines, expected) in [
            ([200.0, 500.0, 800.0], [0, 0, 0]),
            ([200.0, 220.0, 240.0], [2, 1, 0]),
            ([200.0, 220.0, 600.0], [1, 0, 0]),
        ] {
            let mut labels = lines.map(|line| Label::beside(Layout::WIDE, line, "a label"));
            arrange(&mut labels, 0.0);
            assert_eq!(labels.map(|label| label.row), expected, "{lines:?}");
        }
    }

    #[test]
    fn labels_over_lines_that_are_near_do_not_overlap() {
        let mut labels = [85.1, 88.2, 94.5].map(|line| Label::above(Layout::NARROW, line, "a label"));
        assert_eq!(arrange(&mut labels, 0.0), 2);
        assert_eq!(labels.map(|label| label.row), [2, 1, 0]);
    }

    #[test]
    fn label_at_the_border_stays_inside() {
        let label = Label::beside(Layout::NARROW, 330.0, "power off");
        assert!(label.right < 330.0 && !label.is_right(), "{label:?}");
        let label = Label::above(Layout::NARROW, 332.0, "power off");
        assert!(label.right <= Layout::NARROW.width, "{label:?}");
    }

    #[test]
    fn label_over_a_taken_place_goes_up() {
        let mut labels = [Label::beside(Layout::NARROW, 83.0, "cut")];
        assert_eq!(arrange(&mut labels, 95.0), 1);
    }
}
