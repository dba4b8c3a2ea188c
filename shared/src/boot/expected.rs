//! What a slave is expected to be, and how it is to be configured.

use super::Boot;
use crate::od::CobIdEntry;
use crate::pdo::PdoObjects;
use crate::types::{Address, CobId, NodeId};

/// View of an entry of 1F81h, slave assignment (CiA 302-2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Assignment(u32);

impl Assignment {
    /// Bit 0: it is a slave of this master.
    const SLAVE: u32 = 1;
    /// Bit 2: it is checked, configured and started.
    const BOOT: u32 = 1 << 2;
    /// Bit 3: the network waits for it.
    const MANDATORY: u32 = 1 << 3;

    /// As it is stored.
    pub const fn from_raw(raw: u32) -> Assignment {
        Assignment(raw)
    }

    /// As it is stored.
    pub const fn raw(self) -> u32 {
        self.0
    }

    /// Whether it is a slave of this master.
    pub const fn is_slave(self) -> bool {
        self.0 & Self::SLAVE != 0
    }

    /// Whether the boot-up process is run with it.
    pub const fn is_booted(self) -> bool {
        self.0 & (Self::SLAVE | Self::BOOT) == Self::SLAVE | Self::BOOT
    }

    /// Whether SYNC waits for it.
    pub const fn is_mandatory(self) -> bool {
        self.is_booted() && self.0 & Self::MANDATORY != 0
    }
}

/// What a slave says of itself when it is the right one. Zero: whatever it says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Expected {
    /// Device type (1000h).
    pub device_type: u32,
    /// Vendor-ID, product code, revision and serial number (1018h).
    pub identity: [u32; 4],
    /// Date and time of its configuration (1020h). When it has these, its settings are not compared one by one.
    pub stamp: [u32; 2],
}

/// A slave that the master boots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AssignedSlave {
    /// Who.
    pub node: NodeId,
    /// SYNC waits for it.
    pub mandatory: bool,
    /// What it should be.
    pub expected: Expected,
}

impl AssignedSlave {
    /// Its entry of 1F81h.
    pub const fn assignment(&self) -> Assignment {
        let mandatory = if self.mandatory { Assignment::MANDATORY } else { 0 };
        Assignment(Assignment::SLAVE | Assignment::BOOT | mandatory)
    }
}

/// A value that a slave is configured with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Setting {
    /// Of which slave.
    pub node: NodeId,
    /// Where.
    pub at: Address,
    /// What, little-endian, at most [`STAGING`](crate::sdo::STAGING) bytes.
    pub value: &'static [u8],
}

/// TPDO 1, communication parameter.
const TPDO: u16 = <PdoObjects>::TPDOS.nth(0).index();
/// TPDO 512.
const LAST_TPDO: u16 = TPDO + 0x1FF;

impl Setting {
    /// The COB-ID that it gives a transmit PDO, if it does.
    fn transmits(&self) -> Option<CobId> {
        let is_cob_id = matches!(self.at, Address { index: TPDO..=LAST_TPDO, sub: 1 });
        let raw = u32::from_le_bytes(self.value.try_into().ok()?);
        CobIdEntry::from_raw(raw).cob_id().filter(|_| is_cob_id)
    }
}

impl Boot {
    /// Who sends PDOs with this COB-ID: as the slaves are configured, else as the pre-defined connection set has it.
    pub fn producer(&self, id: CobId) -> Option<NodeId> {
        let configured = self.settings.iter().find(|setting| setting.transmits() == Some(id));
        configured.map_or_else(|| id.node(), |setting| Some(setting.node))
    }
}

/// How long the network waits for mandatory slaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BootPolicy {
    /// Boot time (1F89h), whole milliseconds: mandatory slaves that were not heard by then are told. Zero: never.
    pub time: crate::types::Duration,
    /// After the boot time SYNC begins without the mandatory slaves that are not started. Else it waits for ever.
    pub goes_on: bool,
}
