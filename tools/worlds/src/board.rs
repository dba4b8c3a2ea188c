//! The board of a node in a world.

use ecss_can::node::Hardware;
use ecss_can::runner::Platform;
use ecss_can::types::NodeId;

use crate::clock::MockClock;
use crate::port::BoardPort;

/// The board of a node in a world, as `boards_stm32f4::Board` is one of metal: what its node is made with.
pub struct MockBoard {
    /// Its straps.
    pub node_id: NodeId,
    /// For the builder of its node: flash for parameters, two words of RAM that outlive a reset, and a pattern of late heartbeats,
    /// another one for each board. The flash outlives a loss of power, has room for sets of any length, and never fails. There is
    /// no record of a reset.
    pub hardware: Hardware,
}

impl Platform for MockBoard {
    type Port = BoardPort;
    type Clock = MockClock;
}
