//! Steps of the search.

use model::world::{Fault, Report};

/// A step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Time advances.
    Tick,
    /// A fault or a repair.
    Fault(Fault),
    /// A report of a slave.
    Report(Report),
    /// The end of faults and reports, from which the bounds count.
    Calm,
}
