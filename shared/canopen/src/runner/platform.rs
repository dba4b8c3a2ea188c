//! Board, by the types that the protocol needs, and its clock.

use crate::link::port::CanPort;
use crate::types::Instant;

/// Board, by the types that the protocol needs.
pub trait Platform: 'static {
    /// Type of its CAN controllers.
    type Port: CanPort;
    /// Type of its clock.
    type Clock: Clock;
}

/// Time source of the protocol: one for each node, monotonic.
#[allow(async_fn_in_trait)] // spawned on single-threaded executors only
pub trait Clock {
    /// Returns the present instant.
    fn now(&self) -> Instant;

    /// Waits until `deadline`. Completes at once if it has passed.
    ///
    /// # Cancel safety
    /// A dropped future must have no effect.
    async fn at(&self, deadline: Instant);

    /// Notes that [the node is on schedule](crate::node::Node::is_on_schedule). The node calls it whenever it did what was
    /// due. A board that gets no such note for longer than its supervisor allows is reset.
    fn on_schedule(&self) {}
}
