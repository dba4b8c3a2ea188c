//! What happened in a world.

use can_wire::time::Time;
use ecss_can::node::{MasterEvent, SlaveEvent};
use ecss_can::types::NodeId;
use mission::Command;

/// One entry, in the order of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// When.
    pub at: Time,
    /// On which node.
    pub node: NodeId,
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
    /// The master told its application.
    Master(MasterEvent),
    /// A slave told its application.
    Slave(SlaveEvent),
    /// A slave's application executed a command.
    Executed(Command),
    /// A slave's application dropped a command with this code that repeats the last one.
    Repeated(u16),
    /// A slave's application got a message that is none of this mission.
    Unknown(u16),
}
