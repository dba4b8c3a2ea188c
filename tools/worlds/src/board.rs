//! The board of a node in a world.

use ecss_can::node::Hardware;
use ecss_can::runner::Platform;
use ecss_can::types::NodeId;

use crate::clock::MockClock;
use crate::port::BoardPort;

/// The board of a node in a world, the mock of `ecss_can_stm32f4::Board`.
pub struct MockBoard {
    /// Node-ID by its straps.
    pub node_id: NodeId,
    /// Hardware for the builder of its node: flash for parameters, two words of RAM that keep their values over a
    /// reset, and a pattern of late heartbeats, different for each board. The flash keeps its content without power,
    /// has room for sets of any length, and never fails. There is no record of a reset.
    pub hardware: Hardware,
}

impl Platform for MockBoard {
    type Port = BoardPort;
    type Clock = MockClock;
}
