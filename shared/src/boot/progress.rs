//! How far the boot-up of a slave is, and why it failed.

use crate::types::Address;

/// How far the boot-up process is with a slave; its byte stands in object 2040h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum BootProgress {
    /// Not a slave that the master boots.
    #[default]
    Unassigned,
    /// Not heard on the active bus.
    Awaited,
    /// Heard; others are before it.
    Queued,
    /// Device type and identity are read.
    Checking,
    /// Its configuration is compared.
    Comparing,
    /// Its configuration is written.
    Configuring,
    /// Started, and not yet seen to have followed a SYNC.
    Started,
    /// Operational, and synchronised.
    Booted,
    /// It was not started: see the error.
    Failed,
}

/// Why the boot-up of a slave failed, by the letters of CiA 302-2. The character code stands in object 2041h.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum BootError {
    /// Its device type (1000h) could not be read.
    NoResponse = b'B',
    /// Another device type than 1F84h says.
    DeviceType = b'C',
    /// Another vendor than 1F85h says, or it could not be read.
    Vendor = b'D',
    /// A mandatory slave was not heard in the boot time.
    Silent = b'E',
    /// Its configuration could not be read or written.
    Configuration = b'J',
    /// Its heartbeat stopped in the middle.
    Lost = b'K',
    /// Another product code than 1F86h says, or it could not be read.
    Product = b'M',
    /// Another revision number than 1F87h says, or it could not be read.
    Revision = b'N',
    /// Another serial number than 1F88h says, or it could not be read.
    Serial = b'O',
}

/// A value of a slave that is not the expected one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Difference {
    /// Object of the slave.
    pub at: Address,
    /// Value that the master expects; of a longer one the first four bytes.
    pub expected: u32,
    /// Value that the slave has; of a longer one the first four bytes.
    pub found: u32,
}

/// How the boot-up of a slave failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BootCause {
    /// The slave was not heard, or is no longer heard.
    Silence,
    /// A value is not the expected one.
    Difference(Difference),
    /// An SDO transfer with the slave failed.
    Transfer {
        /// Object of the slave.
        at: Address,
        /// SDO abort code.
        code: u32,
    },
}

impl BootCause {
    /// The SDO abort code for object 2042h; zero for none.
    pub const fn abort_code(&self) -> u32 {
        match self {
            BootCause::Transfer { code, .. } => *code,
            BootCause::Silence | BootCause::Difference(_) => 0,
        }
    }
}

/// Why the boot-up of a slave failed, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BootFailure {
    /// What failed; its letter stands in object 2041h.
    pub error: BootError,
    /// The object concerned, and what is wrong with it.
    pub cause: BootCause,
}

impl BootError {
    /// The letter of CiA 302-2, as in object 2041h.
    pub const fn letter(self) -> char {
        self as u8 as char
    }

    /// Of the identity's sub-index.
    pub(super) const fn of_identity(sub: u8) -> BootError {
        match sub {
            1 => BootError::Vendor,
            2 => BootError::Product,
            3 => BootError::Revision,
            _ => BootError::Serial,
        }
    }
}

/// How far the boot-up of the network is.
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
