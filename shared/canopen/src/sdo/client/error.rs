//! Errors of a transfer of the client.

use crate::types::AbortCode;

/// Reason why a transfer of a client ended without success.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// The server aborted the transfer.
    Abort(AbortCode),
    /// The server aborted the transfer, with a code that CiA 301 does not define.
    UnknownAbort(u32),
    /// No response came in time, or the application did not give or take data in time. The client sent an abort.
    Timeout,
    /// The response does not belong to the transfer, or contradicts the request. The client sent an abort with
    /// this code.
    Protocol(AbortCode),
    /// The value has more bytes than the application takes. The client sent an abort.
    TooLarge,
    /// The active bus changed. The client sent an abort on the bus that is active now.
    BusChanged,
}

impl Error {
    /// Returns the abort code that was received or sent. Every failed transfer has one.
    pub const fn code(self) -> u32 {
        match self {
            Error::Abort(code) | Error::Protocol(code) => code.code(),
            Error::UnknownAbort(code) => code,
            Error::Timeout => AbortCode::Timeout.code(),
            Error::TooLarge => AbortCode::OutOfMemory.code(),
            Error::BusChanged => AbortCode::DeviceState.code(),
        }
    }
}
