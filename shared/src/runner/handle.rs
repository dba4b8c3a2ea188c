//! What the handle of a node of a spacecraft has beyond that of a CANopen node.

use super::{Cable, Handle, Platform, SpacecraftClock};
use crate::node::TimeKeeper;
use crate::sdo::Error;
use crate::types::NodeId;

/// Handle of a node that keeps the spacecraft time.
pub trait TimeHandle {
    /// Board of the node.
    type Board: Platform;
    /// Type of the node.
    type Node: TimeKeeper;

    /// Returns the clock of the spacecraft time.
    fn clock(&self) -> SpacecraftClock<Self::Board, Self::Node>;
}

impl<B: Platform, N: TimeKeeper> TimeHandle for Handle<B, N> {
    type Board = B;
    type Node = N;

    fn clock(&self) -> SpacecraftClock<B, N> {
        SpacecraftClock::new(*self)
    }
}

/// Handle of a master.
pub trait MasterHandle {
    /// Measures the cable to a slave on the active bus by 16 of its heartbeats. Its clock has to follow the SYNCs
    /// of this master, and both have to stamp in hardware. For 2014h of the slave add the delay of its receiver,
    /// which this method does not measure.
    ///
    /// # Errors
    /// Those of the SDO client, which reads 2014h and 2016h. [`Error::BusChanged`]. [`Error::Timeout`] if there is
    /// no heartbeat that both have stamped.
    ///
    /// # Cancel safety
    /// A dropped future ends the measurement and aborts a transfer that is running. Call it again to measure from
    /// the start.
    fn measure_cable(&self, node: NodeId) -> impl Future<Output = Result<Cable, Error>>;
}
