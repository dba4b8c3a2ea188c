//! Names for a device, its application and its `main`: `use ecss_can::prelude::*;`

pub use crate::emcy::{DeviceError, ErrorCode};
pub use crate::heartbeat::HeartbeatConsumers;
pub use crate::link::bit_timing::BitRate;
pub use crate::nmt::Target;
pub use crate::node::{
    Communication, Device, DeviceNode, Identity, LOCAL_TIME, LOCAL_TIME_PDO, MASTER_TIME, Master,
    MasterBuilder, MasterEvent, Node, Refusal, SPACECRAFT_TIME, SelfTest, Slave, SlaveBuilder, SlaveEvent,
    SpacecraftDevice, TimeKeeper,
};
pub use crate::od::{Domain, Enumeration, Objects, Record, eds};
pub use crate::pdo::{CobIdOf, Pdo, PdoObjects, PdoSet, PdoValues, ReceivedPdo};
pub use crate::profile::Profile;
pub use crate::redundancy::TwoBoards;
pub use crate::runner::{
    BusRunner, Connection, Diagnostics, DueRunner, EventSource, Events, Handle, MasterHandle, MinimalHandle,
    Platform, Resources, Runners, SdoClient, SlaveHandle, SpacecraftClock, TimeHandle,
};
pub use crate::types::{
    AbortCode, Address, Bus, CobId, Duration, Frame, Instant, NmtState, NodeId, PerBus, Scet,
};
