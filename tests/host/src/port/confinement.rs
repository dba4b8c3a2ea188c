//! Fault confinement of one controller (ISO 11898-1 12.1).

use can_wire::controller::ErrorKind;
use ecss_can::link::port::{ErrorState, Health, LastError};

/// Transmit and receive error counters.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Confinement {
    /// Bus-off above 255.
    tec: u16,
    rec: u16,
    last_error: LastError,
}

impl Confinement {
    pub fn state(&self) -> ErrorState {
        match (self.tec, self.rec) {
            (256.., _) => ErrorState::BusOff,
            (128.., _) | (_, 128..) => ErrorState::Passive,
            _ => ErrorState::Active,
        }
    }

    /// Error warning (a counter at 96 or above, RM0090 32.9.2 EWGF), state, unacknowledged while error passive: a change
    /// of these is news.
    pub fn flags(&self) -> (bool, ErrorState, bool) {
        let unacknowledged = self.state() == ErrorState::Passive && self.last_error == LastError::Ack;
        (self.tec.max(self.rec) >= 96, self.state(), unacknowledged)
    }

    pub fn health(&self) -> Health {
        let byte = |counter: u16| u8::try_from(counter).unwrap_or(u8::MAX);
        Health { state: self.state(), tec: byte(self.tec), rec: byte(self.rec), last_error: self.last_error }
    }

    pub fn transmitted(&mut self) {
        self.tec = self.tec.saturating_sub(1);
        self.last_error = LastError::None;
    }

    pub fn received(&mut self) {
        self.rec = if self.rec > 127 { 127 } else { self.rec.saturating_sub(1) };
        self.last_error = LastError::None;
    }

    pub fn transmit_error(&mut self, kind: ErrorKind) {
        // A lone transmitter never goes bus-off: missing acknowledgements do not count when passive.
        let exempt = kind == ErrorKind::Ack && self.state() == ErrorState::Passive;
        if !exempt {
            self.tec += 8;
        }
        self.last_error = last_error(kind);
    }

    pub fn receive_error(&mut self, kind: ErrorKind) {
        self.rec = (self.rec + 1).min(255);
        self.last_error = last_error(kind);
    }
}

fn last_error(kind: ErrorKind) -> LastError {
    match kind {
        ErrorKind::Stuff => LastError::Stuff,
        ErrorKind::Form => LastError::Form,
        ErrorKind::Ack => LastError::Ack,
        ErrorKind::BitRecessive => LastError::BitRecessive,
        ErrorKind::BitDominant => LastError::BitDominant,
        ErrorKind::Crc => LastError::Crc,
    }
}
