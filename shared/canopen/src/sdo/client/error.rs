//! Errors of a transfer of the client.

use thiserror::Error;

use crate::types::AbortCode;

/// Reason why a transfer of a client ended without success.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// The server aborted the transfer.
    #[error("the server aborted the transfer: {0}")]
    Abort(AbortCode),
    /// The server aborted the transfer, with a code that CiA 301 does not define.
    #[error("the server aborted the transfer with the unknown code {0:08X}h")]
    UnknownAbort(u32),
    /// No response came in time, or the application did not give or take data in time. The client sent an abort.
    #[error("no response of the server in time")]
    Timeout,
    /// The response does not belong to the transfer, or contradicts the request. The client sent an abort with
    /// this code.
    #[error("the response of the server contradicts the request: {0}")]
    Protocol(AbortCode),
    /// The value has more bytes than the application takes. The client sent an abort.
    #[error("the value has more bytes than there is room for")]
    TooLarge,
    /// The value has fewer bytes than its type. The transfer itself succeeded.
    #[error("the value has fewer bytes than its type")]
    TooShort,
    /// The value is none of its enumeration. The transfer itself succeeded.
    #[error("{0:X}h is no value of the enumeration")]
    UnknownValue(u32),
    /// The active bus changed. The client sent an abort on the bus that is active now.
    #[error("the active bus changed during the transfer: repeat it")]
    BusChanged,
}

impl Error {
    /// Returns the abort code that was received or sent, or that describes the error.
    pub const fn code(self) -> u32 {
        match self {
            Error::Abort(code) | Error::Protocol(code) => code.code(),
            Error::UnknownAbort(code) => code,
            Error::Timeout => AbortCode::Timeout.code(),
            Error::TooLarge => AbortCode::OutOfMemory.code(),
            Error::TooShort => AbortCode::TooShort.code(),
            Error::UnknownValue(_) => AbortCode::ValueRange.code(),
            Error::BusChanged => AbortCode::DeviceState.code(),
        }
    }
}
