//! Faults of the cable, at once or at a given time.

/// Something that happens to the cable. Positions are metres from its left end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Both wires break here; a node at exactly this position belongs to the right piece. A second cut at the same
    /// position changes nothing.
    Cut {
        /// Where.
        position_m: f64,
    },
    /// The break at exactly this position heals; without one nothing changes.
    Restore {
        /// Where.
        position_m: f64,
    },
    /// Every break heals.
    RestoreAll,
}
