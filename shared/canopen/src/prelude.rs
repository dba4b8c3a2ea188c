//! Names for a device, its application and its `main`: `use async_canopen::prelude::*;`

pub use crate::emcy::{DeviceError, ErrorCode};
pub use crate::heartbeat::HeartbeatConsumers;
pub use crate::link::bit_timing::BitRate;
pub use crate::nmt::{Command, NmtMessage, Target};
pub use crate::node::{CanopenSlave, Communication, Device, DeviceNode, Event, Identity, Node, Settings};
pub use crate::od::{Domain, Enumeration, Objects, Record, eds};
pub use crate::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, PdoValues, ReceivedPdo};
pub use crate::runner::{
    BusRunner, Clock, Connection, Diagnostics, DueRunner, EventSource, Events, Handle, Platform, Single,
    SingleRunners,
};
pub use crate::types::{AbortCode, Address, Bus, CobId, Duration, Frame, Instant, NmtState, NodeId};
