//! Keys: marks and their meaning, in rows.

use crate::fly::drawing::layout::{LETTERS, Layout, text_width};
use crate::fly::drawing::picture::Picture;

/// Distance from the begin of a mark to its name.
pub(in crate::fly) const MARK: f64 = 24.0;
/// Distance from a name to the next mark.
const APART: f64 = 16.0;
/// Height of a row.
const ROW: f64 = 18.0;

/// Returns the positions of marks in rows from `left` to `right`, the first row at 0, and the height of the other rows.
/// `letters`: height of the names' letters.
pub(in crate::fly) fn places(
    names: &[&str],
    letters: f64,
    (left, right): (f64, f64),
) -> (Vec<(f64, f64)>, f64) {
    let (mut x, mut y) = (left, 0.0);
    let mut places = Vec::new();
    for name in names {
        let width = MARK + text_width(name, letters);
        if x + width > right {
            (x, y) = (left, y + ROW);
        }
        places.push((x, y));
        x += width + APART;
    }
    (places, y)
}

/// Returns the positions of the names of curves above a plot, in rows from the top, and the height of the rows below
/// the first one.
pub fn of_curves(names: &[&str], layout: Layout) -> (Vec<(f64, f64)>, f64) {
    let left = if layout.brief { 0.0 } else { layout.left };
    places(names, LETTERS, (left, layout.width))
}

/// Draws line and name of a curve at its place.
pub fn draw_curve(picture: &mut Picture, class: &str, (x, y): (f64, f64), name: &str) {
    picture.line(class, (x, y + 10.0), (x + 18.0, y + 10.0));
    picture.text("label", x + MARK, y + 14.0, name);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_curves_stand_in_rows() {
        let (places, _) = of_curves(&["node 2"; 14], Layout::NARROW);
        assert_eq!((places[0], places[3].1, places[4]), ((0.0, 0.0), 0.0, (0.0, 18.0)));
        assert!(places.iter().all(|(x, _)| *x + 24.0 + 45.0 <= Layout::NARROW.width), "{places:?}");
    }
}
