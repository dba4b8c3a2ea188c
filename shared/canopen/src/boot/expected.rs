//! Slaves that the master boots: their assignment, their expected identity and their settings.

use crate::od::CobIdEntry;
use crate::pdo::PdoObjects;
use crate::types::{Address, CobId, NodeId};

/// Entry of 1F81h, slave assignment (CiA 302-2).
#[doc(alias("1F81h", "slave assignment"))]
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

    /// Views the value of the object as an assignment.
    pub const fn from_raw(raw: u32) -> Assignment {
        Assignment(raw)
    }

    /// Returns the value of the object.
    pub const fn raw(self) -> u32 {
        self.0
    }

    /// Returns whether the node is a slave of this master (bit 0).
    pub const fn is_slave(self) -> bool {
        self.0 & Self::SLAVE != 0
    }

    /// Returns whether the master runs the boot-up process with the slave (bit 2).
    pub(crate) const fn is_booted(self) -> bool {
        self.0 & (Self::SLAVE | Self::BOOT) == Self::SLAVE | Self::BOOT
    }

    /// Returns whether SYNC waits for the slave (bit 3).
    pub(crate) const fn is_mandatory(self) -> bool {
        self.is_booted() && self.0 & Self::MANDATORY != 0
    }
}

/// Values that identify the right slave. A value of zero is not compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Expected {
    /// Expected device type (1000h).
    pub device_type: u32,
    /// Expected vendor-ID, product code, revision number and serial number (1018h).
    pub identity: [u32; 4],
    /// Expected date and time of the configuration (1020h). If the slave has both, its settings are not compared
    /// one by one.
    pub stamp: [u32; 2],
}

/// A slave that the master boots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AssignedSlave {
    /// Node-ID of the slave.
    pub node: NodeId,
    /// `true`: SYNC waits until this slave is started.
    pub mandatory: bool,
    /// Identity that the master expects.
    pub expected: Expected,
}

impl AssignedSlave {
    /// Returns the entry of 1F81h of this slave.
    pub const fn assignment(&self) -> Assignment {
        let mandatory = if self.mandatory { Assignment::MANDATORY } else { 0 };
        Assignment(Assignment::SLAVE | Assignment::BOOT | mandatory)
    }
}

/// Value that the master writes to a slave during boot-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Setting {
    /// Node-ID of the slave that is configured.
    pub node: NodeId,
    /// Object of the slave that is written.
    pub at: Address,
    /// Value, little-endian, at most [`STAGING`](crate::sdo::STAGING) bytes.
    pub value: &'static [u8],
}

/// TPDO 1, communication parameter.
const TPDO: u16 = <PdoObjects>::TPDOS.nth(0).index();
/// TPDO 512.
const LAST_TPDO: u16 = TPDO + 0x1FF;

impl Setting {
    /// The COB-ID that it gives a transmit PDO, if it does.
    pub(super) fn transmits(&self) -> Option<CobId> {
        let is_cob_id = matches!(self.at, Address { index: TPDO..=LAST_TPDO, sub: 1 });
        let raw = u32::from_le_bytes(self.value.try_into().ok()?);
        CobIdEntry::from_raw(raw).cob_id().filter(|_| is_cob_id)
    }
}

/// Limits of the time that the network waits for mandatory slaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BootPolicy {
    /// Boot time (1F89h), in whole milliseconds. A mandatory slave that was not heard by then is reported. Zero:
    /// no limit.
    pub time: crate::types::Duration,
    /// `true`: after the boot time SYNC begins even if mandatory slaves are not started. `false`: SYNC waits for
    /// them without a limit.
    pub goes_on: bool,
}
