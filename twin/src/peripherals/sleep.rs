//! Clocks while the core sleeps: AHB1LPENR, APB1LPENR and APB2LPENR (RM0090 7.3.14 to 7.3.18).
//!
//! Without its low-power enable, a timer stands while the core sleeps, a CAN controller takes no part in its bus and a DMA
//! controller moves nothing. A wire sees the state at the end of a quantum. The enables of ports, memories and interfaces have no
//! effect.

use super::Peripherals;
use super::map::{CAN1_BIT, CAN2_BIT, DMA_BITS};
use super::rcc::{AHB1, APB1, APB2, Gate, Rcc};

/// Peripherals that have an effect while the core sleeps: DMA, CAN and TIM1 to TIM14.
const ACTIVE: [(u32, u32); 3] = [
    (AHB1, 1 << DMA_BITS[0] | 1 << DMA_BITS[1]),
    (APB1, 1 << CAN1_BIT | 1 << CAN2_BIT | 0x1FF),
    (APB2, 0x0007_0003),
];

impl Rcc {
    /// Returns whether a peripheral has its low-power enable.
    pub fn runs_in_sleep(&self, gate: Gate) -> bool {
        self.low_power(gate.bus) >> gate.bit & 1 == 1
    }

    /// Returns whether an enabled peripheral stops while the core sleeps.
    pub fn stops_in_sleep(&self) -> bool {
        ACTIVE.iter().any(|&(bus, bits)| self.enabled(bus) & !self.low_power(bus) & bits != 0)
    }
}

impl Peripherals {
    /// Returns whether [`Peripherals::sleep`] has an effect.
    pub(crate) fn has_sleepers(&self) -> bool {
        self.rcc.has_sleepers || self.is_asleep
    }

    /// Stops or starts the clocks of peripherals without low-power enable. Returns whether the core fell asleep or woke up.
    pub(crate) fn sleep(&mut self, cycle: u64, asleep: bool) -> bool {
        if asleep == self.is_asleep {
            return false;
        }
        self.run_timers(cycle);
        self.is_asleep = asleep;
        let rcc = &self.rcc;
        self.timers.clock(cycle, !asleep, |gate| !rcc.runs_in_sleep(gate));
        true
    }

    /// Returns whether a peripheral has its clock now.
    pub(super) fn is_running(&self, gate: Gate) -> bool {
        self.rcc.is_clocked(gate) && (!self.is_asleep || self.rcc.runs_in_sleep(gate))
    }
}
