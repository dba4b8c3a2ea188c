//! Steps of the search.

use model::world::Fault;

/// What happens next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Time goes on.
    Tick,
    /// Something breaks, or is mended.
    Fault(Fault),
    /// No faults happen any more: from now on the bounds count.
    Calm,
}
