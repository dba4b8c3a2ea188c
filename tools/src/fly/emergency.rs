//! Emergencies as text: error codes (CiA 301 table 26) and bits of the error register (CiA 301 7.5.2.2).
//!
//! Written from the standard and not with the protocol crate, as [`super::meaning`].

/// Codes with a specific meaning.
const CODES: [(u16, &str); 21] = [
    (0x2100, "current, input side"),
    (0x2200, "current inside the device"),
    (0x2300, "current, output side"),
    (0x3100, "mains voltage"),
    (0x3200, "voltage inside the device"),
    (0x3300, "output voltage"),
    (0x4100, "ambient temperature"),
    (0x4200, "device temperature"),
    (0x6100, "internal software"),
    (0x6200, "user software"),
    (0x6300, "data set"),
    (0x8110, "CAN overrun, frames were lost"),
    (0x8120, "CAN in error passive mode"),
    (0x8130, "heartbeat lost"),
    (0x8140, "recovered from bus-off"),
    (0x8150, "CAN-ID collision"),
    (0x8210, "PDO not processed, too short"),
    (0x8220, "PDO too long"),
    (0x8230, "MPDO destination not available"),
    (0x8240, "SYNC of unexpected length"),
    (0x8250, "RPDO timeout"),
];

/// Classes of codes by their high byte: the device defines the low byte.
const CLASSES: [(u8, &str); 14] = [
    (0x10, "generic error"),
    (0x20, "current"),
    (0x30, "voltage"),
    (0x40, "temperature"),
    (0x50, "device hardware"),
    (0x60, "device software"),
    (0x70, "additional modules"),
    (0x80, "monitoring"),
    (0x81, "communication"),
    (0x82, "protocol error"),
    (0x90, "external error"),
    (0xF0, "additional functions"),
    (0xFF, "device-specific"),
    (0x00, "error ended, or no error"),
];

/// Names of the bits of the error register, from bit 0.
const BITS: [&str; 8] = [
    "generic",
    "current",
    "voltage",
    "temperature",
    "communication",
    "device profile",
    "reserved",
    "manufacturer",
];

/// Returns the meaning of an error code.
pub fn meaning(code: u16) -> &'static str {
    let exact = || CODES.iter().find(|(own, _)| *own == code || *own == code & 0xFF00).map(|(_, text)| *text);
    let [class, _] = code.to_be_bytes();
    let class = || CLASSES.iter().find(|(own, _)| *own == class).map(|(_, text)| *text);
    exact().or_else(class).unwrap_or("unknown code")
}

/// Returns the names of the bits that are set in an error register.
pub fn register(register: u8) -> String {
    let names = BITS.iter().enumerate().filter(|(bit, _)| register >> bit & 1 == 1).map(|(_, name)| *name);
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "no error".into() } else { names.join(", ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_have_the_meanings_of_the_standard() {
        for (code, expected) in [
            (0x0000, "error ended, or no error"),
            (0x8130, "heartbeat lost"),
            (0x8131, "communication"),
            (0x6101, "internal software"),
            (0x6000, "device software"),
            (0x5030, "device hardware"),
            (0xFF42, "device-specific"),
            (0xA000, "unknown code"),
        ] {
            assert_eq!(meaning(code), expected, "{code:04X}h");
        }
    }

    #[test]
    fn register_lists_its_bits() {
        assert_eq!(register(0), "no error");
        assert_eq!(register(0x11), "generic, communication");
        assert_eq!(register(0x81), "generic, manufacturer");
    }
}
