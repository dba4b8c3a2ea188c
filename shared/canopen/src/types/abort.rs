//! Why an access to the object dictionary is refused: SDO abort codes (CiA 301 7.2.4.3.17).

/// Abort code, with its value on the bus.
#[doc(alias = "SDO abort code")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)]
pub enum AbortCode {
    /// Toggle bit not alternated.
    Toggle = 0x0503_0000,
    /// SDO protocol timed out.
    Timeout = 0x0504_0000,
    /// Client or server command specifier not valid or unknown.
    CommandSpecifier = 0x0504_0001,
    /// Invalid block size.
    BlockSize = 0x0504_0002,
    /// Invalid sequence number.
    SequenceNumber = 0x0504_0003,
    /// CRC error of a block transfer.
    Crc = 0x0504_0004,
    /// Out of memory.
    OutOfMemory = 0x0504_0005,
    /// Unsupported access to an object.
    UnsupportedAccess = 0x0601_0000,
    /// Attempt to read a write-only object.
    WriteOnly = 0x0601_0001,
    /// Attempt to write a read-only object.
    ReadOnly = 0x0601_0002,
    /// Object does not exist in the object dictionary.
    NoObject = 0x0602_0000,
    /// Object cannot be mapped to the PDO.
    NotMappable = 0x0604_0041,
    /// The number and length of the objects to be mapped would exceed PDO length.
    PdoLength = 0x0604_0042,
    /// General parameter incompatibility.
    ParameterIncompatible = 0x0604_0043,
    /// General internal incompatibility in the device.
    InternalIncompatible = 0x0604_0047,
    /// Access failed due to a hardware error.
    Hardware = 0x0606_0000,
    /// Data type does not match, length of service parameter does not match.
    Length = 0x0607_0010,
    /// Data type does not match, length of service parameter too high.
    TooLong = 0x0607_0012,
    /// Data type does not match, length of service parameter too low.
    TooShort = 0x0607_0013,
    /// Sub-index does not exist.
    NoSubIndex = 0x0609_0011,
    /// Invalid value for parameter.
    ValueRange = 0x0609_0030,
    /// Value of parameter written too high.
    ValueTooHigh = 0x0609_0031,
    /// Value of parameter written too low.
    ValueTooLow = 0x0609_0032,
    /// Maximum value is less than minimum value.
    MaximumBelowMinimum = 0x0609_0036,
    /// Resource not available: SDO connection.
    NoConnection = 0x060A_0023,
    /// General error without a better code.
    General = 0x0800_0000,
    /// Data cannot be transferred or stored to the application.
    CannotTransfer = 0x0800_0020,
    /// Data cannot be transferred or stored because of local control.
    LocalControl = 0x0800_0021,
    /// Data cannot be transferred or stored because of the present device state.
    DeviceState = 0x0800_0022,
    /// Object dictionary dynamic generation fails or no object dictionary is present.
    NoDictionary = 0x0800_0023,
    /// No data available.
    NoData = 0x0800_0024,
}

impl AbortCode {
    /// All codes that CiA 301 defines.
    pub const ALL: [AbortCode; 31] = [
        AbortCode::Toggle,
        AbortCode::Timeout,
        AbortCode::CommandSpecifier,
        AbortCode::BlockSize,
        AbortCode::SequenceNumber,
        AbortCode::Crc,
        AbortCode::OutOfMemory,
        AbortCode::UnsupportedAccess,
        AbortCode::WriteOnly,
        AbortCode::ReadOnly,
        AbortCode::NoObject,
        AbortCode::NotMappable,
        AbortCode::PdoLength,
        AbortCode::ParameterIncompatible,
        AbortCode::InternalIncompatible,
        AbortCode::Hardware,
        AbortCode::Length,
        AbortCode::TooLong,
        AbortCode::TooShort,
        AbortCode::NoSubIndex,
        AbortCode::ValueRange,
        AbortCode::ValueTooHigh,
        AbortCode::ValueTooLow,
        AbortCode::MaximumBelowMinimum,
        AbortCode::NoConnection,
        AbortCode::General,
        AbortCode::CannotTransfer,
        AbortCode::LocalControl,
        AbortCode::DeviceState,
        AbortCode::NoDictionary,
        AbortCode::NoData,
    ];

    /// Returns the value on the bus.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// Returns the code of a value on the bus. `None` for a value that CiA 301 does not define.
    pub fn from_code(code: u32) -> Option<AbortCode> {
        Self::ALL.into_iter().find(|known| known.code() == code)
    }
}
