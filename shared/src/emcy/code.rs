//! Emergency error codes (CiA 301 7.2.7.1).

/// Emergency error code. A code of CiA 301 that ends in 00h stands for a class of 256 codes: the device defines
/// the low byte.
#[doc(alias = "EMCY error code")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ErrorCode(u16);

/// The codes of CiA 301, as constants and in [`ErrorCode::ALL`].
macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident = $code:literal;)*) => {
        impl ErrorCode {
            $($(#[$doc])* pub const $name: ErrorCode = ErrorCode($code);)*

            /// Every code that CiA 301 names (ECSS 6.4b).
            pub const ALL: &[ErrorCode] = &[$(ErrorCode::$name),*];
        }
    };
}

codes! {
    /// Error reset, or no error.
    NO_ERROR = 0x0000;
    /// Generic error.
    GENERIC = 0x1000;
    /// Current.
    CURRENT = 0x2000;
    /// Current, CANopen device input side.
    CURRENT_INPUT = 0x2100;
    /// Current inside the CANopen device.
    CURRENT_INSIDE = 0x2200;
    /// Current, CANopen device output side.
    CURRENT_OUTPUT = 0x2300;
    /// Voltage.
    VOLTAGE = 0x3000;
    /// Mains voltage.
    VOLTAGE_MAINS = 0x3100;
    /// Voltage inside the CANopen device.
    VOLTAGE_INSIDE = 0x3200;
    /// Output voltage.
    VOLTAGE_OUTPUT = 0x3300;
    /// Temperature.
    TEMPERATURE = 0x4000;
    /// Ambient temperature.
    TEMPERATURE_AMBIENT = 0x4100;
    /// Temperature of the CANopen device.
    TEMPERATURE_DEVICE = 0x4200;
    /// Hardware of the CANopen device.
    HARDWARE = 0x5000;
    /// Software of the CANopen device.
    SOFTWARE = 0x6000;
    /// Internal software.
    SOFTWARE_INTERNAL = 0x6100;
    /// User software.
    SOFTWARE_USER = 0x6200;
    /// Data set.
    DATA_SET = 0x6300;
    /// Additional modules.
    MODULES = 0x7000;
    /// Monitoring.
    MONITORING = 0x8000;
    /// Communication.
    COMMUNICATION = 0x8100;
    /// CAN overrun: objects lost.
    CAN_OVERRUN = 0x8110;
    /// CAN in error passive mode.
    CAN_PASSIVE = 0x8120;
    /// Life guard or heartbeat error.
    HEARTBEAT = 0x8130;
    /// Recovered from bus-off.
    BUS_OFF_RECOVERED = 0x8140;
    /// CAN-ID collision.
    CAN_ID_COLLISION = 0x8150;
    /// Protocol error.
    PROTOCOL = 0x8200;
    /// PDO not processed because it is too short.
    PDO_LENGTH = 0x8210;
    /// PDO longer than its mapping.
    PDO_LENGTH_EXCEEDED = 0x8220;
    /// DAM MPDO not processed, destination object not available.
    MPDO_DESTINATION = 0x8230;
    /// Unexpected SYNC data length.
    SYNC_LENGTH = 0x8240;
    /// RPDO timeout.
    RPDO_TIMEOUT = 0x8250;
    /// External error.
    EXTERNAL = 0x9000;
    /// Additional functions.
    ADDITIONAL_FUNCTIONS = 0xF000;
    /// CANopen device specific.
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
