//! Error counters and states of one controller: RM0090 32.7.6, ESR in 32.9.2.

use can_wire::controller::ErrorKind;

use super::regs::{ESR_BOFF, ESR_EPVF, ESR_EWGF, ESR_LEC};

/// A counter from this value on raises EWGF.
const WARNING: u16 = 96;
/// A counter above this value makes the controller error passive.
const PASSIVE_ABOVE: u16 = 127;
/// A transmit counter above this value is bus-off.
const BUS_OFF_ABOVE: u16 = 255;

/// What ESR shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorState {
    /// Nine bits; ESR shows the lower eight.
    tec: u16,
    rec: u16,
    lec: u8,
    bus_off: bool,
}

impl ErrorState {
    /// The register.
    pub fn esr(&self) -> u32 {
        self.flags()
            | u32::from(self.lec) << 4
            | (u32::from(self.tec) & 0xFF) << 16
            | (u32::from(self.rec) & 0xFF) << 24
    }

    /// EWGF, EPVF and BOFF.
    pub fn flags(&self) -> u32 {
        let highest = self.tec.max(self.rec);
        let mut flags = 0;
        if highest >= WARNING {
            flags |= ESR_EWGF;
        }
        if highest > PASSIVE_ABOVE {
            flags |= ESR_EPVF;
        }
        if self.bus_off {
            flags |= ESR_BOFF;
        }
        flags
    }

    pub fn passive(&self) -> bool {
        self.flags() & ESR_EPVF != 0
    }

    pub fn bus_off(&self) -> bool {
        self.bus_off
    }

    /// Software may write LEC (7 to see the next update), nothing else.
    pub fn write(&mut self, value: u32) {
        self.lec = ((value & ESR_LEC) >> 4) as u8;
    }

    pub fn transmitted(&mut self) {
        self.lec = 0;
        self.tec = self.tec.saturating_sub(1);
    }

    /// "Decremented by 1 or reset to 120 if its value was higher than 128", RM0090 32.9.2, REC. A counter of exactly
    /// 128 becomes 127: both meet the 119..127 of ISO 11898-1.
    pub fn received(&mut self) {
        self.lec = 0;
        self.rec = if self.rec > 128 { 120 } else { self.rec.saturating_sub(1) };
    }

    /// Adds 8, but for the missing acknowledge of an error passive transmitter (the exception of ISO 11898-1 that
    /// keeps a lone node from bus-off).
    pub fn transmit_error(&mut self, kind: ErrorKind) {
        self.lec = lec(kind);
        if kind == ErrorKind::Ack && self.passive() {
            return;
        }
        self.tec += 8;
        if self.tec > BUS_OFF_ABOVE {
            self.bus_off = true;
        }
    }

    /// Adds 1; the counter has eight bits and stops at their end.
    pub fn receive_error(&mut self, kind: ErrorKind) {
        self.lec = lec(kind);
        self.rec = (self.rec + 1).min(0xFF);
    }

    /// The end of bus-off: error active, both counters zero.
    pub fn recover(&mut self) {
        self.tec = 0;
        self.rec = 0;
        self.bus_off = false;
    }
}

fn lec(kind: ErrorKind) -> u8 {
    match kind {
        ErrorKind::Stuff => 1,
        ErrorKind::Form => 2,
        ErrorKind::Ack => 3,
        ErrorKind::BitRecessive => 4,
        ErrorKind::BitDominant => 5,
        ErrorKind::Crc => 6,
    }
}
