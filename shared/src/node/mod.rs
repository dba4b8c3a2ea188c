//! Nodes: all services put together, without input and output of their own.
//!
//! A *node* takes events of its buses and the time, and puts commands and events into an [`Outbox`](extend::Outbox). A *device* is
//! the user's part of a node: its objects, its PDOs and its names, by the trait [`Device`].
//!
//! | node | for |
//! | --- | --- |
//! | [`Slave`] | a slave of a spacecraft: CANopen, redundancy, spacecraft time |
//! | [`Master`] | the master of a spacecraft, alone or as one of [`TwoBoards`](crate::redundancy::TwoBoards) |
//! | [`minimal::MinimalSlave`] | a slave of the minimal set (ECSS 9) |
//!
//! [`async_canopen::node::CanopenSlave`] is a plain CANopen slave on one bus.
//!
//! The [`runner`](crate::runner) runs a node on two CAN controllers. A test can call it directly:
//!
//! ```
//! use ecss_can::node::extend::{BusCommand, Outbox, Turn};
//! use ecss_can::prelude::*;
//! # /// A device without objects.
//! # #[derive(Objects)]
//! # #[objects(device)]
//! # struct Bare {}
//! # impl Device for Bare {
//! #     type Pdos = PdoObjects<0, 0>;
//! #     type Consumers = HeartbeatConsumers<1>;
//! #     const PDOS: PdoSet = PdoSet::NONE;
//! # }
//!
//! let mut slave = Slave::builder(NodeId::of::<3>(), &Profile::DEFAULT, Bare::default()).build();
//! let mut out = Outbox::new();
//! slave.start(&mut Turn::new(Instant::ZERO, &mut out));
//!
//! let mut sent = Vec::new();
//! while let Some((bus, command)) = out.pop_command() {
//!     if let BusCommand::Send(outgoing) = command {
//!         sent.push((bus, outgoing.frame.id().raw(), outgoing.frame.data().to_vec()));
//!     }
//! }
//! assert_eq!(sent, [(Bus::Nominal, 0x703, vec![0])]); // the boot-up message
//! assert!(matches!(out.pop_event(), Some(SlaveEvent::State(NmtState::PreOperational) | SlaveEvent::ActiveBus { .. })));
//! assert!(slave.deadline().is_some()); // call `poll` then
//! ```
//!
//! # Limits
//!
//! - A node has the depth of its queues in its type, [`Node::Depth`]: 32 places, a minimal slave 8. A full queue
//!   refuses a frame and reports it.
//! - A slow application loses events. They are counted, and the node never waits.

mod device;
mod events;
mod extension;
mod hardware;
mod index;
mod master;
mod master_api;
pub mod minimal;
mod network_objects;
mod objects;
#[cfg(test)]
pub(crate) mod probe;
mod services;
mod settings;
mod slave;
mod slave_api;
mod spacecraft;
mod status;
mod stored;
mod time_pdos;
mod upsets;

pub(crate) use async_canopen::node::extend::{BusCommand, ClientNode, Filters, FullDepth, LinkEvent, Turn};

pub use async_canopen::node::{
    Communication, Counters, Device, DeviceNode, DeviceObjects, FailCause, Identity, Node, extend,
};
pub use device::{DeviceTime, SpacecraftDevice, TimeKeeper};
pub use events::SpacecraftEvent;
pub use hardware::Hardware;
pub use master::{Master, MasterBuilder, MasterObjects};
pub use master_api::{MasterEvent, MasterRequest, Refusal};
pub use network_objects::{MasterRole, NetworkObjects, Ranging};
pub use objects::{NodeObjects, assert_device};
pub use slave::{Slave, SlaveBuilder};
pub use slave_api::{ParallelAccess, SlaveEvent};
pub use spacecraft::{BusHealth, OverBudget, ProtectedIdentity, SelfTest, Spacecraft};
pub use status::Status;
pub use time_pdos::{LOCAL_TIME, LOCAL_TIME_PDO, MASTER_TIME, SPACECRAFT_TIME};
pub use upsets::{FoundUpsets, ProgramState, UpsetObjects, Upsets};

#[cfg(test)]
mod tests {
    use super::probe::Probe;
    use super::{Master, Slave};

    const fn assert_send<T: Send>() {}

    /// A node may run at another priority than its application (docs/decisions/tasks-and-storage.md).
    const _: () = {
        assert_send::<Slave<Probe>>();
        assert_send::<Master<Probe>>();
    };
}
