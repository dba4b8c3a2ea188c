//! Log of a world.

use can_twin::wire::time::Time;
use ecss_can::node::minimal::MinimalEvent;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::types::NodeId;

use crate::key::NodeKey;

/// One entry of the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Instant of the event.
    pub at: Time,
    /// Node of the event.
    pub node: NodeId,
    /// Board of the event.
    pub key: NodeKey,
    /// The event.
    pub what: NodeEvent,
}

/// Event of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeEvent {
    /// Power was switched on, or the chip was reset.
    PowerOn,
    /// Power was switched off.
    PowerOff,
    /// The application of the master took an event.
    Master(MasterEvent),
    /// The application of a slave took an event.
    Slave(SlaveEvent),
    /// The application of a minimal slave took an event.
    Minimal(MinimalEvent),
}
