//! Error register, object 1001h (CiA 301 7.5.2.2).

use super::ErrorCode;

/// Which kinds of error are active.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorRegister(u8);

impl ErrorRegister {
    /// Set with every error.
    pub const GENERIC: ErrorRegister = ErrorRegister(1 << 0);
    /// Current.
    pub const CURRENT: ErrorRegister = ErrorRegister(1 << 1);
    /// Voltage.
    pub const VOLTAGE: ErrorRegister = ErrorRegister(1 << 2);
    /// Temperature.
    pub const TEMPERATURE: ErrorRegister = ErrorRegister(1 << 3);
    /// Communication: overrun, error state, protocol.
    pub const COMMUNICATION: ErrorRegister = ErrorRegister(1 << 4);
    /// Specific to the device profile.
    pub const PROFILE: ErrorRegister = ErrorRegister(1 << 5);
    /// Specific to the manufacturer.
    pub const MANUFACTURER: ErrorRegister = ErrorRegister(1 << 7);

    /// What an error of this code sets. CiA 301 names the bits but not the codes that set them; here additional
    /// functions (F0xxh) belong to the device profile and device specific errors (FFxxh) to the manufacturer.
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

    /// As it stands in a message.
    pub const fn from_bits(bits: u8) -> ErrorRegister {
        ErrorRegister(bits)
    }

    /// The value of the object.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The bits of both.
    #[must_use]
    pub const fn and(self, other: ErrorRegister) -> ErrorRegister {
        ErrorRegister(self.0 | other.0)
    }

    /// Whether all bits of `other` are set.
    pub const fn contains(self, other: ErrorRegister) -> bool {
        self.0 & other.0 == other.0
    }
}
