//! Errors of a receive PDO, and their emergencies.

use crate::emcy::ErrorCode;

/// Error of an RPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RpdoError {
    /// The last frame had fewer bytes than are mapped. It was not processed.
    TooShort,
    /// The last frame had more bytes than are mapped.
    TooLong,
    /// No frame arrived in time.
    Overdue,
    /// A value was outside its limits, or none of its enumeration. It was not written.
    OutOfRange,
}

impl RpdoError {
    pub(super) const ALL: [RpdoError; 4] =
        [RpdoError::TooShort, RpdoError::TooLong, RpdoError::Overdue, RpdoError::OutOfRange];

    pub(super) const fn bit(self) -> u8 {
        1 << self as u8
    }

    /// Returns the error code of the emergency that reports it.
    pub const fn code(self) -> ErrorCode {
        match self {
            RpdoError::TooShort => ErrorCode::PDO_LENGTH,
            RpdoError::TooLong => ErrorCode::PDO_LENGTH_EXCEEDED,
            RpdoError::Overdue => ErrorCode::RPDO_TIMEOUT,
            RpdoError::OutOfRange => ErrorCode::PROTOCOL,
        }
    }
}

/// Change of an error of an RPDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RpdoEvent {
    /// An error appeared.
    Error(RpdoError),
    /// An error is gone.
    Resolved(RpdoError),
}
