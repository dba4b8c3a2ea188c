//! Error status register of a controller, as its program reads it.

use ecss_can::link::port::{ErrorState, Health, LastError};

/// Causes of an error, by the value of LEC.
const CAUSES: [LastError; 7] = [
    LastError::None,
    LastError::Stuff,
    LastError::Form,
    LastError::Ack,
    LastError::BitRecessive,
    LastError::BitDominant,
    LastError::Crc,
];

/// Returns what a value of ESR says (RM0090 32.9.2).
pub fn health(esr: u32) -> Health {
    let [flags, _, tec, rec] = esr.to_le_bytes();
    let state = match flags & 0b111 {
        off if off & 0b100 != 0 => ErrorState::BusOff,
        passive if passive & 0b010 != 0 => ErrorState::Passive,
        _ => ErrorState::Active,
    };
    let last_error = CAUSES.get(usize::from(flags >> 4 & 0b111)).copied().unwrap_or_default();
    Health { state, tec, rec, last_error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_register_says_state_counters_and_cause() {
        let of = |state, tec, rec, last_error| Health { state, tec, rec, last_error };
        assert_eq!(health(0), Health::default());
        assert_eq!(health(0x0700_0021), of(ErrorState::Active, 0, 7, LastError::Form));
        assert_eq!(health(0x0080_0033), of(ErrorState::Passive, 128, 0, LastError::Ack));
        assert_eq!(health(0x00F8_0057), of(ErrorState::BusOff, 248, 0, LastError::BitDominant));
    }
}
