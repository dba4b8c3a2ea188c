//! Steps of the search.

use model::world::{Fault, Report};

/// What happens next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Time goes on.
    Tick,
    /// Something breaks, or is mended.
    Fault(Fault),
    /// A slave reports something.
    Report(Report),
    /// No faults happen any more, and nothing is reported: from now on the bounds count.
    Calm,
}
