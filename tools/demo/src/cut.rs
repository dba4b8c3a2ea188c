//! The cut of a bus.

use can_wire::time::Time;
use twin::spacecraft::Bus;

/// A cut to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutPlan {
    /// Bus that is cut.
    pub bus: Bus,
    /// Time of the cut.
    pub at: Time,
    /// Metres from the master's end.
    pub position_m: f64,
}
