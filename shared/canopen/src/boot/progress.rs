//! Progress of the boot-up of a slave, and the reason if it failed.

use thiserror::Error;

use crate::types::{Address, CobId, NodeId};

/// Step that the boot-up of a slave reached. Object 2040h has its byte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum BootProgress {
    /// The master does not boot this node.
    #[default]
    Unassigned,
    /// The slave was not heard on the active bus.
    Awaited,
    /// The slave was heard. The master boots others first.
    Queued,
    /// The master reads device type and identity.
    Checking,
    /// The master compares the configuration.
    Comparing,
    /// The master writes the configuration.
    Configuring,
    /// The slave is started. It did not yet follow a SYNC.
    Started,
    /// The slave is Operational and follows SYNC.
    Booted,
    /// The slave was not started. The error has the reason.
    Failed,
}

/// Error of the boot-up of a slave, with the letter of CiA 302-2. Object 2041h has its character code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum BootError {
    /// The device type (1000h) could not be read.
    NoResponse = b'B',
    /// The device type is not the one in 1F84h.
    DeviceType = b'C',
    /// The vendor-ID is not the one in 1F85h, or could not be read.
    Vendor = b'D',
    /// A mandatory slave was not heard within the boot time.
    Silent = b'E',
    /// The configuration could not be read or written.
    Configuration = b'J',
    /// The heartbeat of the slave stopped during the boot-up.
    Lost = b'K',
    /// The product code is not the one in 1F86h, or could not be read.
    Product = b'M',
    /// The revision number is not the one in 1F87h, or could not be read.
    Revision = b'N',
    /// The serial number is not the one in 1F88h, or could not be read.
    Serial = b'O',
}

/// Value of a slave that differs from the expected one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Difference {
    /// Object that has the value.
    pub at: Address,
    /// Value that the master expects. Of a longer value: the first four bytes.
    pub expected: u32,
    /// Value that the slave has. Of a longer value: the first four bytes.
    pub found: u32,
}

/// Cause of a boot-up that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BootCause {
    /// The slave was never heard, or is not heard any more.
    Silence,
    /// A value differs from the expected one.
    Difference(Difference),
    /// Another node sends a COB-ID of the slave.
    CobIdInUse {
        /// Object of the slave: 1014h or a TPDO.
        at: Address,
        /// COB-ID that both send.
        id: CobId,
        /// The other node.
        other: NodeId,
    },
    /// The network has more COB-IDs than the master compares. They are not known to be unique.
    TooManyCobIds,
    /// An SDO transfer with the slave failed.
    Transfer {
        /// Object of the slave.
        at: Address,
        /// SDO abort code.
        code: u32,
    },
}

impl BootCause {
    /// Returns the SDO abort code for object 2042h, zero if there is none.
    pub const fn abort_code(&self) -> u32 {
        match self {
            BootCause::Transfer { code, .. } => *code,
            _ => 0,
        }
    }
}

/// Reason why the boot-up of a slave failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("boot-up failed at step {} of CiA 302-2", .error.letter())]
pub struct BootFailure {
    /// Step that failed. Object 2041h has its letter.
    pub error: BootError,
    /// Cause, with the object that is concerned.
    pub cause: BootCause,
}

impl BootError {
    /// Returns the letter of CiA 302-2, as object 2041h has it.
    pub const fn letter(self) -> char {
        self as u8 as char
    }

    /// Returns the error of a sub-index of the identity.
    pub(super) const fn of_identity(sub: u8) -> BootError {
        match sub {
            1 => BootError::Vendor,
            2 => BootError::Product,
            3 => BootError::Revision,
            _ => BootError::Serial,
        }
    }
}

/// Phase of the boot-up of the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Mandatory slaves are awaited.
    Configuring,
    /// SYNC may begin.
    Released,
    /// A SYNC went out.
    Synchronising,
    /// Everybody followed.
    Completed,
}
