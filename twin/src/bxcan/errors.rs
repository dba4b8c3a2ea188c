//! ESR of one controller: RM0090 32.7.6 and 32.9.2.
//!
//! The protocol engine maintains the counters; this module derives flags and interrupts of the chip.

use super::regs::{ESR_BOFF, ESR_EPVF, ESR_EWGF, ESR_LEC};
use crate::wire::controller::{ErrorCounters, ErrorKind};

/// Value of a counter from which on EWGF is set.
const WARNING: u16 = 96;
/// State that ESR shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct ErrorState {
    pub counters: ErrorCounters,
    pub(super) lec: u8,
}

impl ErrorState {
    /// The register.
    pub fn esr(&self) -> u32 {
        self.flags()
            | u32::from(self.lec) << 4
            | (u32::from(self.counters.transmit) & 0xFF) << 16
            | (u32::from(self.counters.receive) & 0xFF) << 24
    }

    /// EWGF, EPVF and BOFF.
    pub fn flags(&self) -> u32 {
        let ErrorCounters { transmit, receive } = self.counters;
        let raised = [
            (transmit.max(receive) >= WARNING, ESR_EWGF),
            (self.counters.error_passive(), ESR_EPVF),
            (self.counters.bus_off(), ESR_BOFF),
        ];
        raised.into_iter().fold(0, |flags, (is_raised, flag)| if is_raised { flags | flag } else { flags })
    }

    /// Software may write LEC (7 to see the next update), nothing else.
    pub fn write(&mut self, value: u32) {
        self.lec = ((value & ESR_LEC) >> 4) as u8;
    }

    /// Records a successful transmission or reception.
    pub fn succeeded(&mut self) {
        self.lec = 0;
    }

    /// Records an error.
    pub fn failed(&mut self, kind: ErrorKind) {
        self.lec = lec(kind);
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
