//! Board, by the types that the protocol needs.

use crate::link::port::CanPort;
use crate::time::Clock;

/// Board, by the types that the protocol needs.
pub trait Platform: 'static {
    /// Type of its CAN controllers.
    type Port: CanPort;
    /// Type of its clock.
    type Clock: Clock;
}
