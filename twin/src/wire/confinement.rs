//! Fault confinement: error counters and the resulting states (ISO 11898-1, 12.1.4).

/// From this count on a node is error passive.
const PASSIVE: u16 = 128;
/// From this transmit count on a node is bus-off.
const BUS_OFF: u16 = 256;
/// The receive counter has eight bits.
const RECEIVE_LIMIT: u16 = 255;
/// Receive counter of an error passive node after a valid frame (119..=127 allowed).
const RECEIVE_AFTER_PASSIVE: u16 = 120;

/// Error counters of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ErrorCounters {
    /// TEC, 0 to 263; from 256 on the node is bus-off.
    pub transmit: u16,
    /// REC, 0 to 255.
    pub receive: u16,
}

impl ErrorCounters {
    /// Returns whether either counter is above 127 (rules i and k).
    pub fn error_passive(&self) -> bool {
        self.transmit >= PASSIVE || self.receive >= PASSIVE
    }

    /// Returns whether TEC is above 255 (rule j).
    pub fn bus_off(&self) -> bool {
        self.transmit >= BUS_OFF
    }

    /// Rule a: a receiver saw an error.
    pub(in crate::wire) fn receive_error(&mut self) {
        self.add_receive(1);
    }

    /// Rules c to f: `transmitter` adds 8 to TEC, a receiver to REC.
    pub(in crate::wire) fn add_eight(&mut self, transmitter: bool) {
        if transmitter {
            self.transmit = (self.transmit + 8).min(BUS_OFF + 7);
        } else {
            self.add_receive(8);
        }
    }

    /// Rule g.
    pub(in crate::wire) fn transmitted(&mut self) {
        self.transmit = self.transmit.saturating_sub(1);
    }

    /// Rule h; 128 becomes 127, as bxCAN does it (RM0090 32.9.2, REC).
    pub(in crate::wire) fn received(&mut self) {
        self.receive =
            if self.receive > PASSIVE { RECEIVE_AFTER_PASSIVE } else { self.receive.saturating_sub(1) };
    }

    fn add_receive(&mut self, count: u16) {
        self.receive = (self.receive + count).min(RECEIVE_LIMIT);
    }
}
