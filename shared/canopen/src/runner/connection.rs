//! Ports and clock that a board gives to its node.

/// Ports and clock that a board gives to its node: [`Resources::start`](super::Resources::start) or
/// [`Single::start`](super::Single::start) takes them.
///
/// ```
/// use async_canopen::runner::Connection;
/// # let (port, clock) = ((), ());
///
/// let connection = Connection { ports: port, clock }; // a node on one bus: one port
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Connection<P, C> {
    /// Ports of the node, off their buses: the one of [`Single`](super::Single), or
    /// [`PerBus`](crate::types::PerBus) of both for [`Resources`](super::Resources).
    pub ports: P,
    /// Clock of the node.
    pub clock: C,
}
