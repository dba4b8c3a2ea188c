//! Communication profile area, 1000h..=1FFFh: what every node has (CiA 301 7.5.2).

use crate::emcy::EmcyObjects;
use crate::heartbeat::HeartbeatProducer;
use crate::nmt::NmtObjects;
use crate::od::{Objects, Record};
use crate::sync::SyncObjects;
use crate::types::NodeId;

/// The communication profile of a node but for its heartbeat consumers and PDOs, of which each device has as many as it
/// needs. Objects of a service are declared by its module.
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
    /// SYNC
    #[objects]
    pub sync: SyncObjects,
    /// Emergencies
    #[objects]
    pub emcy: EmcyObjects,
    /// Heartbeat of the node
    #[objects]
    pub heartbeat: HeartbeatProducer,
    /// Network management
    #[objects]
    pub nmt: NmtObjects,
}

impl Communication {
    /// The defaults of a node.
    pub fn new(node: NodeId) -> Self {
        Self { emcy: EmcyObjects::new(node), ..Self::default() }
    }
}

/// Identity (0023h).
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
