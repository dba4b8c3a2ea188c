//! The object dictionary of a node of a spacecraft, master or slave.

use async_canopen::node;

use super::{Spacecraft, SpacecraftDevice};
use crate::redundancy::Parameters;
use crate::types::NodeId;

/// All objects of a node of a spacecraft.
pub type NodeObjects<D> = node::NodeObjects<D, Spacecraft>;

/// Makes the objects of a node at power-on. An application that uses indices of the node does not compile.
pub fn at_power_on<D: SpacecraftDevice>(
    id: NodeId,
    redundancy: &Parameters,
    application: D,
) -> NodeObjects<D> {
    let mut objects = NodeObjects::at_power_on(id, redundancy.heartbeats(), application);
    objects.extension.set_redundancy(redundancy);
    objects
}

/// Stops the build if a node of a spacecraft cannot have the PDOs of this device, or if the device uses indices of the node.
/// `#[objects(device)]` writes a call of it.
///
/// # Panics
/// When called at run time, for the same reasons.
#[track_caller]
pub const fn assert_device<D: SpacecraftDevice>() {
    node::extend::assert_objects::<D, Spacecraft>();
}
