//! Criteria of a mission file: what must hold for a node, in addition to the checks of each flight.

use can_twin::wire::time::Time;

use super::record::Node;

/// What must hold for a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Criterion {
    /// The node.
    pub node: Node,
    /// What must hold.
    pub must: Must,
    /// Line and key of the mission file: for messages.
    pub origin: String,
}

/// What must hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Must {
    /// The node is operational at this time.
    OperationalAt(Time),
    /// The node need not be operational at the end of the flight.
    MayBeLost,
    /// It works on the other bus within this time after the first cut.
    FailOverWithin(Time),
    /// Its clock, once settled, differs from the master's by at most this number of microseconds.
    ClockWithin(f64),
    /// It answers each SDO request, and each request for telemetry of the shipped master, within this time.
    AnswerWithin(Time),
}
