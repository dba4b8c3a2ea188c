//! Errors of a device, as its application reports them.

use super::ErrorCode;

/// Error of a device that its application [raises](crate::runner::Handle::raise) and
/// [clears](crate::runner::Handle::clear): an error code and a source.
///
/// The *source* is the part of the device that has the error, 0 to 255. It is the first byte of the
/// manufacturer-specific field of the emergency. Two errors with one code and two sources are different.
///
/// ```
/// use async_canopen::emcy::{DeviceError, ErrorCode};
///
/// /// The sensor at I2C address 48h does not answer.
/// const NO_SENSOR: DeviceError = DeviceError::new(ErrorCode::HARDWARE, 0x48);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DeviceError {
    /// Error code of the emergency.
    pub code: ErrorCode,
    /// Part of the device that has the error.
    pub source: u8,
}

impl DeviceError {
    /// Makes an error from its code and its source.
    pub const fn new(code: ErrorCode, source: u8) -> Self {
        DeviceError { code, source }
    }

    /// Returns the manufacturer-specific field of the emergency: the source, then `info`.
    pub const fn field(self, info: [u8; 4]) -> [u8; 5] {
        let [first, second, third, fourth] = info;
        [self.source, first, second, third, fourth]
    }
}
