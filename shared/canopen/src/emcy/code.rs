//! Emergency error codes (CiA 301 7.2.7.1).

use crate::types::Canonical;

/// Emergency error code. A code of CiA 301 that ends in 00h stands for a class of 256 codes: the device defines
/// the low byte.
#[doc(alias = "EMCY error code")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Canonical)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorCode(u16);

/// The codes of CiA 301, as constants and in [`ErrorCode::ALL`].
macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident = $code:literal;)*) => {
        impl ErrorCode {
            $($(#[$doc])* pub const $name: ErrorCode = ErrorCode($code);)*

            /// All codes that CiA 301 names.
            pub const ALL: &[ErrorCode] = &[$(ErrorCode::$name),*];
        }
    };
}

codes! {
    /// Error reset, or no error.
    NO_ERROR = 0x0000;
    /// Generic error without a better code.
    GENERIC = 0x1000;
    /// Error of a current.
    CURRENT = 0x2000;
    /// Error of a current at the input side of the device.
    CURRENT_INPUT = 0x2100;
    /// Error of a current inside the device.
    CURRENT_INSIDE = 0x2200;
    /// Error of a current at the output side of the device.
    CURRENT_OUTPUT = 0x2300;
    /// Error of a voltage.
    VOLTAGE = 0x3000;
    /// Error of the mains voltage.
    VOLTAGE_MAINS = 0x3100;
    /// Error of a voltage inside the device.
    VOLTAGE_INSIDE = 0x3200;
    /// Error of an output voltage.
    VOLTAGE_OUTPUT = 0x3300;
    /// Error of a temperature.
    TEMPERATURE = 0x4000;
    /// Error of the ambient temperature.
    TEMPERATURE_AMBIENT = 0x4100;
    /// Error of the temperature of the device.
    TEMPERATURE_DEVICE = 0x4200;
    /// Error of the hardware of the device.
    HARDWARE = 0x5000;
    /// Error of the software of the device.
    SOFTWARE = 0x6000;
    /// Error of the internal software.
    SOFTWARE_INTERNAL = 0x6100;
    /// Error of the user software.
    SOFTWARE_USER = 0x6200;
    /// Error of a data set.
    DATA_SET = 0x6300;
    /// Error of additional modules.
    MODULES = 0x7000;
    /// Error of the monitoring.
    MONITORING = 0x8000;
    /// Error of the communication.
    COMMUNICATION = 0x8100;
    /// CAN overrun: frames were lost.
    CAN_OVERRUN = 0x8110;
    /// CAN controller in error passive.
    CAN_PASSIVE = 0x8120;
    /// Life guard or heartbeat error.
    HEARTBEAT = 0x8130;
    /// Recovery from bus-off.
    BUS_OFF_RECOVERED = 0x8140;
    /// Collision of a CAN-ID: two nodes send it.
    CAN_ID_COLLISION = 0x8150;
    /// Error of the protocol.
    PROTOCOL = 0x8200;
    /// PDO not processed because it is too short.
    PDO_LENGTH = 0x8210;
    /// PDO longer than its mapping.
    PDO_LENGTH_EXCEEDED = 0x8220;
    /// DAM MPDO not processed, destination object not available.
    MPDO_DESTINATION = 0x8230;
    /// Unexpected SYNC data length.
    SYNC_LENGTH = 0x8240;
    /// Timeout of an RPDO.
    RPDO_TIMEOUT = 0x8250;
    /// Error outside of the device.
    EXTERNAL = 0x9000;
    /// Error of additional functions.
    ADDITIONAL_FUNCTIONS = 0xF000;
    /// Error that the device defines.
    DEVICE_SPECIFIC = 0xFF00;
}

impl ErrorCode {
    /// Makes a code from the value of a message, or a code that a device defines.
    pub const fn new(code: u16) -> ErrorCode {
        ErrorCode(code)
    }

    /// Returns the value that the message carries.
    pub const fn get(self) -> u16 {
        self.0
    }
}
