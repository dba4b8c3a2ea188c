//! What happened in a world.

use can_wire::time::Time;
use ecss_can::node::minimal::MinimalEvent;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::types::NodeId;

use crate::key::NodeKey;

/// One entry, in the order of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// When.
    pub at: Time,
    /// On which node.
    pub node: NodeId,
    /// On which board.
    pub key: NodeKey,
    /// What.
    pub what: NodeEvent,
}

/// What a node did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeEvent {
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
