//! Communication profile area, 1000h..=1FFFh: what every node has (CiA 301 7.5.2).

use crate::emcy::ErrorField;
use crate::nmt::NmtStartup;
use crate::od::{INVALID, Objects, Record};
use crate::types::{CobId, NodeId};

/// The communication profile of a node but for its heartbeat consumers and PDOs, of which each device has as many as it
/// needs.
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct Communication {
    /// Device type
    #[object(0x1000, ro)]
    pub device_type: u32,
    /// Error register
    #[object(0x1001, ro, pdo)]
    pub error_register: u8,
    /// Manufacturer status register
    #[object(0x1002, ro, pdo)]
    pub status_register: u32,
    /// Pre-defined error field
    #[object(0x1003, record, array)]
    pub errors: ErrorField,
    /// COB-ID SYNC message
    #[object(0x1005, rw, default = 0x80)]
    pub sync_cob_id: u32,
    /// Communication cycle period
    ///
    /// Microseconds.
    #[object(0x1006, rw)]
    pub cycle_period: u32,
    /// Synchronous window length
    ///
    /// Microseconds.
    #[object(0x1007, rw)]
    pub synchronous_window: u32,
    /// Manufacturer device name
    #[object(0x1008, constant)]
    pub device_name: &'static str,
    /// Manufacturer hardware version
    #[object(0x1009, constant)]
    pub hardware_version: &'static str,
    /// Manufacturer software version
    #[object(0x100A, constant)]
    pub software_version: &'static str,
    /// Store parameters
    ///
    /// All, communication, application, manufacturer. Bit 0: on command; zero without a parameter store.
    #[object(0x1010, array, rw, volatile)]
    pub store: [u32; 4],
    /// Restore default parameters
    ///
    /// All, communication, application, manufacturer. Bit 0: possible; zero without a parameter store.
    #[object(0x1011, array, rw, volatile)]
    pub restore: [u32; 4],
    /// COB-ID EMCY
    #[object(0x1014, rw, default = INVALID)]
    pub emcy_cob_id: u32,
    /// Inhibit time EMCY
    ///
    /// Multiples of 100 us. Ten a second: an error that comes and goes must not fill the bus.
    #[object(0x1015, rw, default = 1_000)]
    pub emcy_inhibit: u16,
    /// Producer heartbeat time
    ///
    /// Milliseconds.
    #[object(0x1017, rw)]
    pub producer_heartbeat: u16,
    /// Identity object
    #[object(0x1018, record)]
    pub identity: Identity,
    /// Synchronous counter overflow value
    #[object(0x1019, rw, high = 240)]
    pub sync_overflow: u8,
    /// Verify configuration
    ///
    /// Date (days since 1984) and time (milliseconds since midnight) of the configuration. Zero: it was changed.
    #[object(0x1020, array, rw)]
    pub configuration: [u32; 2],
    /// Error behaviour
    ///
    /// Communication error: 0 pre-operational, 1 no change, 2 stopped.
    #[object(0x1029, array, rw, high = 2)]
    pub error_behaviour: [u8; 1],
    /// NMT startup
    ///
    /// Bit 0: NMT master. Bit 2: not to Operational without a command. What is stored of it holds from the next reset on.
    #[object(0x1F80, rw, default = NmtStartup::of_slave(false).raw())]
    pub nmt_startup: u32,
}

impl Communication {
    /// The defaults of a node.
    pub fn new(node: NodeId) -> Self {
        Self { emcy_cob_id: u32::from(CobId::emcy(node).raw()), ..Self::default() }
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
