//! Builder of a minimal slave.

use async_canopen::node::extend::Buses;

use super::{MinimalDevice, MinimalSlave, PDOS};
use crate::heartbeat;
use crate::link::access::BusAccess;
use crate::profile::Profile;
use crate::redundancy::Selector;
use crate::types::NodeId;

/// Builder of a [`MinimalSlave`].
#[derive(Debug)]
#[must_use = "`build` makes the slave"]
pub struct MinimalSlaveBuilder<'p, D: MinimalDevice> {
    id: NodeId,
    profile: &'p Profile,
    device: D,
    access: BusAccess,
}

impl<D: MinimalDevice> MinimalSlave<D> {
    /// Begins a slave with the parameters of a profile: [`Profile::minimal_redundancy`], [`Profile::access`],
    /// [`Profile::bus_off`]. Telemetry that waits for its bus expires after [`Profile::event`]. `id` is 2 to 126.
    pub fn builder(id: NodeId, profile: &Profile, device: D) -> MinimalSlaveBuilder<'_, D> {
        const { D::PDOS.assert_possible() };
        MinimalSlaveBuilder { id, profile, device, access: profile.access(id) }
    }
}

impl<D: MinimalDevice> MinimalSlaveBuilder<'_, D> {
    /// Makes it a slave on one bus at a time (selective access), for a board with one controller.
    pub fn on_one_bus(self) -> Self {
        MinimalSlaveBuilder { access: BusAccess::Selective, ..self }
    }

    /// Makes the slave, before power-on.
    pub fn build(self) -> MinimalSlave<D> {
        let MinimalSlaveBuilder { id, profile, device, access } = self;
        let redundancy = profile.minimal_redundancy(id);
        MinimalSlave {
            id,
            device,
            redundancy,
            lifetime: profile.event,
            same_lifetime: profile.event,
            buses: Buses::new(access, profile.bus_off),
            selector: Selector::new(redundancy),
            heartbeat: heartbeat::machine::Producer::new(id, redundancy.producer),
            syncs: [0; PDOS],
        }
    }
}
