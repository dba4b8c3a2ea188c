//! Communication profile area, 1000h..=1FFFh: what every node has (CiA 301 7.5.2).

use crate::emcy::ErrorField;
use crate::heartbeat::MONITORED;
use crate::nmt::NmtStartup;
use crate::od::{INVALID, NO_REMOTE, Objects, Record};
use crate::pdo::{CobIdOf, Mapping, PdoMapping, PdoSet, Rpdo, RpdoParameters, Tpdo, TpdoParameters};
use crate::types::{CobId, NodeId};

/// The communication profile of a node with `R` receive PDOs and `T` transmit PDOs, at most 512 of each. `M` is how they
/// are mapped: [`PdoMapping`] or [`StaticMapping`](crate::pdo::StaticMapping).
#[derive(Clone, Debug, PartialEq, Objects)]
pub struct Communication<const R: usize = 8, const T: usize = 8, M: Mapping = PdoMapping> {
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
    /// Consumer heartbeat time
    ///
    /// Node-ID in bits 16 to 22, milliseconds below.
    #[object(0x1016, array, rw)]
    pub consumer_heartbeat: [u32; MONITORED],
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
    /// Receive PDO communication parameter
    #[object(0x1400.., record)]
    pub rpdos: [RpdoParameters; R],
    /// Receive PDO mapping parameter
    #[object(0x1600.., record)]
    pub rpdo_mappings: [M; R],
    /// Transmit PDO communication parameter
    #[object(0x1800.., record)]
    pub tpdos: [TpdoParameters; T],
    /// Transmit PDO mapping parameter
    #[object(0x1A00.., record)]
    pub tpdo_mappings: [M; T],
}

impl<const R: usize, const T: usize, M: Mapping> Communication<R, T, M> {
    /// The defaults of a node: COB-IDs of the generic pre-defined connection set (CiA 301 7.3.3), all PDOs invalid and
    /// mapped to nothing.
    pub fn new(node: NodeId) -> Self {
        const { assert!(R <= 512 && T <= 512, "at most 512 PDOs each way") };
        let mut objects = Self { emcy_cob_id: u32::from(CobId::emcy(node).raw()), ..Self::default() };
        let bases = [0x200_u32, 0x300, 0x400, 0x500];
        for (pdo, base) in objects.rpdos.iter_mut().zip(bases) {
            pdo.cob_id = INVALID | NO_REMOTE | (base + u32::from(node.get()));
        }
        for (pdo, base) in objects.tpdos.iter_mut().zip(bases) {
            pdo.cob_id = INVALID | NO_REMOTE | (base - 0x80 + u32::from(node.get()));
        }
        objects
    }

    /// With these PDOs; those that are not in the set stay invalid.
    #[must_use]
    pub fn with_pdos(mut self, node: NodeId, pdos: &PdoSet<R, T>) -> Self {
        let cob_id = |id: CobIdOf| NO_REMOTE | u32::from(id.of(node).raw());
        for pdo in pdos.rpdos().iter().map(Rpdo::pdo) {
            let slot = pdo.slot();
            if let (Some(to), Some(mapping)) = (self.rpdos.get_mut(slot), self.rpdo_mappings.get_mut(slot)) {
                (to.cob_id, to.transmission) = (cob_id(pdo.cob_id), pdo.transmission);
                to.event_timer = pdo.event_timer;
                mapping.map(pdo.mapping());
            }
        }
        for pdo in pdos.tpdos().iter().map(Tpdo::pdo) {
            let slot = pdo.slot();
            if let (Some(to), Some(mapping)) = (self.tpdos.get_mut(slot), self.tpdo_mappings.get_mut(slot)) {
                (to.cob_id, to.transmission) = (cob_id(pdo.cob_id), pdo.transmission);
                (to.inhibit, to.event_timer) = (pdo.inhibit, pdo.event_timer);
                to.sync_start = pdo.sync_start;
                mapping.map(pdo.mapping());
            }
        }
        self
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
