//! Error register, object 1001h (CiA 301 7.5.2.2).

use super::ErrorCode;
use crate::types::Canonical;

/// Kinds of error that are active (1001h).
#[doc(alias("1001h", "error register"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorRegister(u8);

impl ErrorRegister {
    /// Generic error: set with every error.
    pub const GENERIC: ErrorRegister = ErrorRegister(1 << 0);
    /// Error of a current.
    pub const CURRENT: ErrorRegister = ErrorRegister(1 << 1);
    /// Error of a voltage.
    pub const VOLTAGE: ErrorRegister = ErrorRegister(1 << 2);
    /// Error of a temperature.
    pub const TEMPERATURE: ErrorRegister = ErrorRegister(1 << 3);
    /// Communication error: overrun, error state, protocol.
    pub const COMMUNICATION: ErrorRegister = ErrorRegister(1 << 4);
    /// Error that the device profile defines.
    pub const PROFILE: ErrorRegister = ErrorRegister(1 << 5);
    /// Error that the manufacturer defines.
    pub const MANUFACTURER: ErrorRegister = ErrorRegister(1 << 7);

    /// Returns the bits that an error with this code sets. CiA 301 names the bits but not the codes that set
    /// them. Here additional functions (F0xxh) set the bit of the device profile, and device specific errors
    /// (FFxxh) that of the manufacturer.
    pub const fn of(code: ErrorCode) -> ErrorRegister {
        let kind = match code.get() >> 8 {
            0x00 => return ErrorRegister(0),
            0x20..=0x2F => Self::CURRENT,
            0x30..=0x3F => Self::VOLTAGE,
            0x40..=0x4F => Self::TEMPERATURE,
            0x81 | 0x82 => Self::COMMUNICATION,
            0xF0 => Self::PROFILE,
            0xFF => Self::MANUFACTURER,
            _ => Self::GENERIC,
        };
        kind.and(Self::GENERIC)
    }

    /// Makes a register from the byte of a message.
    pub const fn from_bits(bits: u8) -> ErrorRegister {
        ErrorRegister(bits)
    }

    /// Returns the value of the object.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Returns the bits that are set in at least one of the two.
    #[must_use]
    pub const fn and(self, other: ErrorRegister) -> ErrorRegister {
        ErrorRegister(self.0 | other.0)
    }

    /// Returns whether all bits of `other` are set.
    pub const fn contains(self, other: ErrorRegister) -> bool {
        self.0 & other.0 == other.0
    }
}
