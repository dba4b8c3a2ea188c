//! The services put together: a master and a slave, both sans-IO [`crate::node::Node`]s.

mod buses;
mod canopen;
mod canopen_slave;
mod communication;
mod contract;
mod device;
mod extension;
mod index;
mod master;
mod master_api;
pub mod minimal;
mod objects;
mod services;
mod slave;
mod slave_api;
mod spacecraft;

pub use buses::{Counters, Status};
pub use canopen_slave::CanopenSlave;
pub use communication::{Communication, Identity};
pub use contract::{
    BusCommand, FailCause, Filters, LinkEvent, MAX_FILTERS, Node, Outbox, QUEUE_DEPTH, Usual,
};
pub use device::{Device, DeviceNode, TimeKeeper};
pub use extension::{Extension, Nothing};
pub use master::{
    Master, MasterBoards, MasterObjects, MasterRole, NetworkObjects, OneBoard, Ranging, TwoBoards,
};
pub use master_api::{MasterEvent, MasterRequest, Refusal};
pub use objects::{NodeObjects, assert_device};
pub use slave::Slave;
pub use slave_api::{BusCause, ParallelAccess, SlaveEvent};
pub use spacecraft::{BusHealth, OverBudget, ProtectedIdentity, SelfTest, Spacecraft};
