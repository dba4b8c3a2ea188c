//! Positions of the lanes of a timeline, one for each bus.

use super::kind::Kind;
use crate::fly::flight::Flight;
use crate::fly::record::Bus;

/// Height of a row.
pub const ROW: f64 = 16.0;
const TITLE: f64 = 32.0;

/// Positions of the lanes and their rows.
pub struct Lanes {
    /// Kinds of frames, a row each.
    pub rows: Vec<Kind>,
    /// Tops of the lanes, nominal first.
    tops: [f64; 2],
}

impl Lanes {
    /// The lanes of a flight; `above`: height of the texts above each lane, nominal first.
    pub fn new(flight: &Flight, above: [f64; 2]) -> Lanes {
        let rows = Kind::rows(flight);
        let lane = lane(&rows);
        let [nominal, redundant] = above.map(|words| TITLE + words);
        Lanes { rows, tops: [nominal, nominal + lane + redundant] }
    }

    /// Top of a lane.
    pub fn top(&self, bus: Bus) -> f64 {
        self.tops[bus as usize]
    }

    /// Bottom of a lane.
    pub fn bottom(&self, bus: Bus) -> f64 {
        self.top(bus) + lane(&self.rows)
    }

    /// Top of a row of a lane.
    pub fn row_top(&self, bus: Bus, row: usize) -> f64 {
        self.top(bus) + 5.0 + row as f64 * ROW
    }
}

/// Height of a lane with these rows.
pub fn lane(rows: &[Kind]) -> f64 {
    rows.len() as f64 * ROW + 6.0
}

/// Title of a lane.
pub fn lane_title(bus: Bus) -> String {
    let mut letters = bus.name().chars();
    let capital = letters.next().map(|first| first.to_ascii_uppercase());
    format!("{} bus", capital.into_iter().chain(letters).collect::<String>())
}
