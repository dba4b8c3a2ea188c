//! The services put together: a master and a slave, both sans-IO [`crate::runner::Node`]s.

mod buses;
mod device;
mod master;
mod master_api;
mod objects;
mod slave;
mod slave_api;

pub use buses::{Counters, Status};
pub use master::{Master, MasterDictionary, MasterObjects};
pub use master_api::{MasterEvent, MasterRequest, RefusalCause};
pub use objects::NodeObjects;
pub use slave::Slave;
pub use slave_api::{BusCause, ParallelAccess, SlaveEvent};
