//! The board of a node in a world.

use ecss_can::runner::Platform;
use ecss_can::store::{ParameterStore, RetainedMemory};
use ecss_can::types::NodeId;

use crate::clock::MockClock;
use crate::port::BoardPort;

/// The board of a node in a world, as `boards_stm32f4::Board` is one of metal: what its node is made with.
pub struct MockBoard {
    /// Its straps.
    pub node_id: NodeId,
    /// Pattern by the unique ID of its chip, another one for each board; for [`Slave::with_late_heartbeats`].
    ///
    /// [`Slave::with_late_heartbeats`]: ecss_can::node::Slave::with_late_heartbeats
    pub late_heartbeats: u32,
    /// Two words of RAM that outlive a reset.
    pub retained: &'static mut (dyn RetainedMemory + Send),
    /// Flash for parameters, which outlives a loss of power. It has room for sets of any length, and never fails: there is always one.
    pub store: Option<&'static mut (dyn ParameterStore + Send)>,
}

impl Platform for MockBoard {
    type Port = BoardPort;
    type Clock = MockClock;
}
