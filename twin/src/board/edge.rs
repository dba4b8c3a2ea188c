//! Edges at pins, with their true instants.

use crate::pin::Pin;
use crate::wire::time::{TICKS_PER_US, Time};

/// A timer changed the level of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Instant of the edge, rounded down to a tick.
    pub at: Time,
    /// Fraction of a tick after that instant, 0 to 1.
    pub fraction: f64,
    /// Pin that changed.
    pub pin: Pin,
    /// Level after the edge.
    pub high: bool,
}

impl Edge {
    /// Returns the nanoseconds since the start of the simulation, exact to a picosecond in the first hour.
    pub fn ns(&self) -> f64 {
        (self.at.0 as f64 + self.fraction) * 1000.0 / TICKS_PER_US as f64
    }
}
