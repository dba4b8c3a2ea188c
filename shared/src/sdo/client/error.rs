//! How a transfer fails.

use crate::types::AbortCode;

/// Why a transfer of a client ended without success.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error {
    /// The server aborted the transfer.
    Abort(AbortCode),
    /// The server aborted the transfer, with a code that CiA 301 does not define.
    UnknownAbort(u32),
    /// No answer in time, or an application that did not give or take data in time. The server was told.
    Timeout,
    /// What the server sent does not belong to the transfer or is not what it said. It was told this code.
    Protocol(AbortCode),
    /// The value has more bytes than the application takes. The server was told.
    TooLarge,
    /// The active bus changed. The server was told, on the bus that is active now.
    BusChanged,
}

impl Error {
    /// The abort code that was received or sent; every failed transfer has one.
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
