//! Edges at pins, with their true instants.

use can_wire::time::{TICKS_PER_US, Time};

use crate::pin::Pin;

/// A timer changed the level of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The tick that has begun.
    pub at: Time,
    /// How much of that tick has passed, 0 to 1.
    pub fraction: f64,
    /// Which pin.
    pub pin: Pin,
    /// The level from then on.
    pub high: bool,
}

impl Edge {
    /// Nanoseconds since the start of the simulation, exact to a picosecond in the first hour.
    pub fn ns(&self) -> f64 {
        (self.at.0 as f64 + self.fraction) * 1000.0 / TICKS_PER_US as f64
    }
}
