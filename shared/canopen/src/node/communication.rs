//! Communication profile area, 1000h to 1FFFh: the objects of every node (CiA 301 7.5.2).

use crate::emcy::EmcyObjects;
use crate::heartbeat::HeartbeatProducer;
use crate::nmt::NmtObjects;
use crate::od::{Objects, Record};
use crate::sync::SyncObjects;
use crate::types::{CobId, NodeId};

/// Communication profile of a node, without its heartbeat consumers and PDOs: their number depends on the device.
/// The module of each service declares its objects.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct Communication {
    /// Device type
    #[object(0x1000, ro)]
    pub device_type: u32,
    /// Manufacturer status register
    #[object(0x1002, ro, pdo)]
    pub status_register: u32,
    /// Manufacturer device name
    #[object(0x1008, constant)]
    pub device_name: &'static str,
    /// Manufacturer hardware version
    #[object(0x1009, constant)]
    pub hardware_version: &'static str,
    /// Manufacturer software version
    #[object(0x100A, constant)]
    pub software_version: &'static str,
    /// Identity object
    #[object(0x1018, record)]
    pub identity: Identity,
    /// Verify configuration
    ///
    /// Date (days since 1984) and time (milliseconds since midnight) of the configuration. Zero: it was changed.
    #[object(0x1020, array, rw)]
    pub configuration: [u32; 2],
    /// Objects of SYNC
    #[objects]
    pub sync: SyncObjects,
    /// Objects of emergencies
    #[objects]
    pub emcy: EmcyObjects,
    /// Objects of the heartbeat producer
    #[objects]
    pub heartbeat: HeartbeatProducer,
    /// Objects of network management
    #[objects]
    pub nmt: NmtObjects,
}

impl Communication {
    /// Makes the objects with the defaults of a node.
    pub fn new(node: NodeId) -> Self {
        let mut all = Self::default();
        all.emcy.cob_id = CobId::emcy(node).raw().into();
        all
    }
}

/// Identity of the device (record 0023h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Record)]
#[record(0x23)]
pub struct Identity {
    /// Vendor-ID
    #[sub(1, ro)]
    pub vendor: u32,
    /// Product code
    #[sub(2, ro)]
    pub product: u32,
    /// Revision number
    #[sub(3, ro)]
    pub revision: u32,
    /// Serial number
    #[sub(4, ro)]
    pub serial: u32,
}
