//! The object dictionary of a node.

use crate::heartbeat::{ConsumerSlots, HeartbeatTimes};
use crate::node::services::extension::{CanopenOnly, Extension};
use crate::node::{Communication, Device};
use crate::od::Objects;
use crate::sdo::SdoServers;
use crate::types::{Duration, NodeId};

/// All objects of a node. `E`: parts of the node beyond CANopen.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct NodeObjects<D: Device, E: Extension<D>> {
    /// Objects of the application
    #[objects]
    pub application: D,
    /// Objects beyond CANopen
    #[objects]
    pub extension: E,
    /// Objects of the communication profile
    #[objects]
    pub communication: Communication,
    /// Objects of the heartbeat consumers
    #[objects]
    pub consumers: D::Consumers,
    /// Objects of the PDOs
    #[objects]
    pub pdos: D::Pdos,
    /// Objects of the SDO servers
    #[objects]
    pub sdo: D::Sdo,
}

impl<D: Device, E: Extension<D>> NodeObjects<D, E> {
    /// The objects at power-on. An application whose indices are those of the node does not compile.
    pub fn at_power_on(id: NodeId, heartbeats: HeartbeatTimes, application: D) -> Self {
        const { assert_objects::<D, E>() };
        let mut objects = NodeObjects {
            application,
            extension: E::default(),
            communication: D::communication(id),
            consumers: D::consumers(id),
            pdos: D::pdos(id),
            sdo: D::Sdo::at_power_on(id),
        };
        objects.set_heartbeats(heartbeats);
        objects
    }

    /// Restores the communication profile of power-on.
    pub fn restore_communication(&mut self, id: NodeId, heartbeats: HeartbeatTimes) {
        self.communication = D::communication(id);
        self.consumers = D::consumers(id);
        self.pdos = D::pdos(id);
        // Those of the default server are constant.
        if D::Sdo::SECOND_SERVER.is_some() {
            self.sdo = D::Sdo::at_power_on(id);
        }
        self.set_heartbeats(heartbeats);
    }

    /// Objects 1016h and 1017h: the master is consumed first of all, unless its consumer time is zero.
    fn set_heartbeats(&mut self, heartbeats: HeartbeatTimes) {
        // They hold at most 65 535 ms, whose microseconds fit into 32 bits: no division of 64 for them.
        let millis = |time: Duration| (time.as_micros() as u32 / 1_000) as u16;
        if heartbeats.consumer > Duration::ZERO
            && let Some(first) = self.consumers.entries_mut().first_mut()
        {
            *first = u32::from(NodeId::MASTER.get()) << 16 | u32::from(millis(heartbeats.consumer));
        }
        self.communication.heartbeat.time = millis(heartbeats.producer);
    }
}

/// Stops the build if a node cannot have the PDOs of this device, or if the device uses indices of the node.
/// `#[objects(device)]` writes a call of it.
///
/// # Panics
/// When called at run time, for the same reasons.
#[track_caller]
pub const fn assert_device<D: Device>() {
    assert_objects::<D, CanopenOnly>();
}

/// Stops the build as [`assert_device`] does, for nodes with these parts beyond CANopen.
///
/// # Panics
/// When called at run time, for the same reasons.
#[track_caller]
pub const fn assert_objects<D: Device, E: Extension<D>>() {
    let declared = NodeObjects::<D, E>::DECLARED;
    declared.assert_distinct();
    D::PDOS.assert_within::<D::Pdos>(declared);
}
