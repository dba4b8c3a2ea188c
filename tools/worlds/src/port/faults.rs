//! State of fault confinement in the port.

use can_twin::wire::controller::{ErrorCounters, ErrorKind};
use ecss_can::link::port::{ErrorState, Health, LastError};

/// Count from which on a controller sets the error warning (RM0090 32.9.2, EWGF).
const WARNING: u16 = 96;

/// Counters and last error reported by the wire.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Faults {
    pub counters: ErrorCounters,
    pub last_error: LastError,
}

impl Faults {
    pub fn state(&self) -> ErrorState {
        if self.counters.bus_off() {
            ErrorState::BusOff
        } else if self.counters.error_passive() {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    /// Returns error warning, error state, and unacknowledged while error passive. A change of these is reported.
    pub fn flags(&self) -> (bool, ErrorState, bool) {
        let unacknowledged = self.state() == ErrorState::Passive && self.last_error == LastError::Ack;
        (self.counters.transmit.max(self.counters.receive) >= WARNING, self.state(), unacknowledged)
    }

    pub fn health(&self) -> Health {
        let byte = |counter: u16| u8::try_from(counter).unwrap_or(u8::MAX);
        let ErrorCounters { transmit, receive } = self.counters;
        Health { state: self.state(), tec: byte(transmit), rec: byte(receive), last_error: self.last_error }
    }
}

pub(super) fn last_error(kind: ErrorKind) -> LastError {
    match kind {
        ErrorKind::Stuff => LastError::Stuff,
        ErrorKind::Form => LastError::Form,
        ErrorKind::Ack => LastError::Ack,
        ErrorKind::BitRecessive => LastError::BitRecessive,
        ErrorKind::BitDominant => LastError::BitDominant,
        ErrorKind::Crc => LastError::Crc,
    }
}
