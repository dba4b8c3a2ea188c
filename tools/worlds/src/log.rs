//! What happened in a world.

use can_wire::time::Time;
use ecss_can::node::minimal::MinimalEvent;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::types::NodeId;

use crate::seat::Seat;

/// One entry, in the order of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// When.
    pub at: Time,
    /// On which node.
    pub node: NodeId,
    /// On which board.
    pub seat: Seat,
    /// What.
    pub what: Happening,
}

/// What a node did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Happening {
    /// Power came, or the chip was reset.
    PowerOn,
    /// Power went.
    PowerOff,
    /// The application of the master took an event.
    Master(MasterEvent),
    /// The application of a slave took an event.
    Slave(SlaveEvent),
    /// The application of a minimal slave took an event.
    Minimal(MinimalEvent),
}
