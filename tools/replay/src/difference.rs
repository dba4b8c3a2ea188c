//! A difference between a machine and its board, as people read it.

use std::fmt;

use can_wire::time::Time;

/// First difference of a stream of outputs, or of bus and state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Name of the board.
    pub board: String,
    /// Instant on the time axis of the run.
    pub at: Time,
    /// What was compared.
    pub what: String,
    /// What the machine did.
    pub expected: String,
    /// What the board did.
    pub flown: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Difference { board, at, what, expected, flown } = self;
        write!(f, "{board}, {:.6} s, {what}: the machine {expected}, the board {flown}", at.as_secs_f64())
    }
}
