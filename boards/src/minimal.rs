//! What a board hands to the image of a minimal slave (ECSS 9).

use ecss_can::runner::Platform;
use ecss_can::types::{NodeId, PerBus};

use crate::Uptime;
use crate::bxcan::Port;
use crate::common::Leds;
use crate::straps::StrapError;

/// What a minimal slave needs of its board: no capture of edges, no parameter store, no post-mortem record.
///
/// A program that panics, faults or hangs is reset, and its controllers are silent from then on until it has started again.
pub struct MinimalBoard {
    /// The CAN controllers, off their buses.
    pub ports: PerBus<Port>,
    /// Time since power-on.
    pub clock: Uptime,
    /// The LEDs, dark.
    pub leds: Leds,
    /// Node-ID from the straps.
    pub node_id: Result<NodeId, StrapError>,
}

impl Platform for MinimalBoard {
    type Port = Port;
    type Clock = Uptime;
}
