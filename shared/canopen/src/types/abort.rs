//! Why an access to the object dictionary is refused: SDO abort codes (CiA 301 7.2.4.3.17).

use thiserror::Error;

/// Abort code. In memory it is a small number, so that an image compares and loads it in two bytes: [`AbortCode::code`] returns
/// its value on the bus.
#[doc(alias = "SDO abort code")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u32)]
pub enum AbortCode {
    /// Toggle bit not alternated.
    #[error("toggle bit not alternated (05030000h)")]
    Toggle = 1,
    /// SDO protocol timed out.
    #[error("SDO protocol timed out (05040000h)")]
    Timeout,
    /// Client or server command specifier not valid or unknown.
    #[error("client or server command specifier not valid or unknown (05040001h)")]
    CommandSpecifier,
    /// Invalid block size.
    #[error("invalid block size (05040002h)")]
    BlockSize,
    /// Invalid sequence number.
    #[error("invalid sequence number (05040003h)")]
    SequenceNumber,
    /// CRC error of a block transfer.
    #[error("CRC error of a block transfer (05040004h)")]
    Crc,
    /// Out of memory.
    #[error("out of memory (05040005h)")]
    OutOfMemory,
    /// Unsupported access to an object.
    #[error("unsupported access to an object (06010000h)")]
    UnsupportedAccess,
    /// Attempt to read a write-only object.
    #[error("attempt to read a write-only object (06010001h)")]
    WriteOnly,
    /// Attempt to write a read-only object.
    #[error("attempt to write a read-only object (06010002h)")]
    ReadOnly,
    /// Object does not exist in the object dictionary.
    #[error("object does not exist in the object dictionary (06020000h)")]
    NoObject,
    /// Object cannot be mapped to the PDO.
    #[error("object cannot be mapped to the PDO (06040041h)")]
    NotMappable,
    /// The number and length of the objects to be mapped would exceed PDO length.
    #[error("the number and length of the objects to be mapped would exceed PDO length (06040042h)")]
    PdoLength,
    /// General parameter incompatibility.
    #[error("general parameter incompatibility (06040043h)")]
    ParameterIncompatible,
    /// General internal incompatibility in the device.
    #[error("general internal incompatibility in the device (06040047h)")]
    InternalIncompatible,
    /// Access failed due to a hardware error.
    #[error("access failed due to a hardware error (06060000h)")]
    Hardware,
    /// Data type does not match, length of service parameter does not match.
    #[error("data type does not match, length of service parameter does not match (06070010h)")]
    Length,
    /// Data type does not match, length of service parameter too high.
    #[error("data type does not match, length of service parameter too high (06070012h)")]
    TooLong,
    /// Data type does not match, length of service parameter too low.
    #[error("data type does not match, length of service parameter too low (06070013h)")]
    TooShort,
    /// Sub-index does not exist.
    #[error("sub-index does not exist (06090011h)")]
    NoSubIndex,
    /// Invalid value for parameter.
    #[error("invalid value for parameter (06090030h)")]
    ValueRange,
    /// Value of parameter written too high.
    #[error("value of parameter written too high (06090031h)")]
    ValueTooHigh,
    /// Value of parameter written too low.
    #[error("value of parameter written too low (06090032h)")]
    ValueTooLow,
    /// Maximum value is less than minimum value.
    #[error("maximum value is less than minimum value (06090036h)")]
    MaximumBelowMinimum,
    /// Resource not available: SDO connection.
    #[error("resource not available: SDO connection (060A0023h)")]
    NoConnection,
    /// General error without a better code.
    #[error("general error without a better code (08000000h)")]
    General,
    /// Data cannot be transferred or stored to the application.
    #[error("data cannot be transferred or stored to the application (08000020h)")]
    CannotTransfer,
    /// Data cannot be transferred or stored because of local control.
    #[error("data cannot be transferred or stored because of local control (08000021h)")]
    LocalControl,
    /// Data cannot be transferred or stored because of the present device state.
    #[error("data cannot be transferred or stored because of the present device state (08000022h)")]
    DeviceState,
    /// Object dictionary dynamic generation fails or no object dictionary is present.
    #[error("object dictionary dynamic generation fails or no object dictionary is present (08000023h)")]
    NoDictionary,
    /// No data available.
    #[error("no data available (08000024h)")]
    NoData,
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
        match self {
            AbortCode::Toggle => 0x0503_0000,
            AbortCode::Timeout => 0x0504_0000,
            AbortCode::CommandSpecifier => 0x0504_0001,
            AbortCode::BlockSize => 0x0504_0002,
            AbortCode::SequenceNumber => 0x0504_0003,
            AbortCode::Crc => 0x0504_0004,
            AbortCode::OutOfMemory => 0x0504_0005,
            AbortCode::UnsupportedAccess => 0x0601_0000,
            AbortCode::WriteOnly => 0x0601_0001,
            AbortCode::ReadOnly => 0x0601_0002,
            AbortCode::NoObject => 0x0602_0000,
            AbortCode::NotMappable => 0x0604_0041,
            AbortCode::PdoLength => 0x0604_0042,
            AbortCode::ParameterIncompatible => 0x0604_0043,
            AbortCode::InternalIncompatible => 0x0604_0047,
            AbortCode::Hardware => 0x0606_0000,
            AbortCode::Length => 0x0607_0010,
            AbortCode::TooLong => 0x0607_0012,
            AbortCode::TooShort => 0x0607_0013,
            AbortCode::NoSubIndex => 0x0609_0011,
            AbortCode::ValueRange => 0x0609_0030,
            AbortCode::ValueTooHigh => 0x0609_0031,
            AbortCode::ValueTooLow => 0x0609_0032,
            AbortCode::MaximumBelowMinimum => 0x0609_0036,
            AbortCode::NoConnection => 0x060A_0023,
            AbortCode::General => 0x0800_0000,
            AbortCode::CannotTransfer => 0x0800_0020,
            AbortCode::LocalControl => 0x0800_0021,
            AbortCode::DeviceState => 0x0800_0022,
            AbortCode::NoDictionary => 0x0800_0023,
            AbortCode::NoData => 0x0800_0024,
        }
    }

    /// Returns the code of a value on the bus. `None` for a value that CiA 301 does not define.
    pub fn from_code(code: u32) -> Option<AbortCode> {
        Self::ALL.into_iter().find(|known| known.code() == code)
    }
}
