//! Marks of the faults that the demo caused, in a picture of one plot.

use super::axis::Axis;
use crate::fly::drawing::Picture;
use crate::fly::drawing::labels::{self, Label};
use crate::fly::flight::Flight;

/// Lines of the faults and their names above the plot.
pub struct Marks {
    marks: Vec<(&'static str, Label)>,
    rows: usize,
}

impl Marks {
    /// Marks of all faults of a flight.
    pub fn of(flight: &Flight, axis: &Axis) -> Marks {
        let (names, mut labels): (Vec<_>, Vec<_>) = flight
            .faults()
            .into_iter()
            .map(|(name, at)| (name, Label::above(axis.layout, axis.x(at), name)))
            .unzip();
        let rows = labels::arrange(&mut labels, 0.0);
        Marks { marks: names.into_iter().zip(labels).collect(), rows }
    }

    /// Returns the height that they need in addition to a single row.
    pub fn height(&self) -> f64 {
        self.rows as f64 * labels::ROW
    }

    /// Draws them over a plot; `gap` is the space between the plot and the names.
    pub fn draw(&self, picture: &mut Picture, top: f64, bottom: f64, gap: f64) {
        for (name, label) in &self.marks {
            let up = label.row as f64 * labels::ROW;
            picture.line("cut", (label.line, top - 4.0 - up), (label.line, bottom));
            picture.text("cut-label middle", label.middle(), top - gap - up, name);
        }
    }
}
