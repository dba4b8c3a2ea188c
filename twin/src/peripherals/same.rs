//! Comparison of two copies of the peripherals.
//!
//! Some registers of the model have no effect but that the core can read them. They do not count when the time in question has no access
//! to them.

use std::ops::Range;

use super::dma::{FIRST_STREAM, STREAM_LEN};
use super::{Dma, Gpio, Peripherals};
use crate::bxcan::BANKS;

/// Registers of a port that are stored without effect: OTYPER, OSPEEDR and LCKR, as indices of words.
const WITHOUT_EFFECT: [u32; 3] = [1, 2, 7];
const PORTS: u32 = 0x4002_0000;
const DMA: u32 = 0x4002_6000;
const CAN: u32 = 0x4000_6400;
/// Bytes from one port or DMA controller to the next.
const BLOCK: u32 = 0x400;

/// Uses of registers in a span of time.
pub trait RegisterUses {
    /// Returns whether the core or DMA accessed one of these words of peripherals.
    fn touches(&self, addresses: Range<u32>) -> bool;

    /// Returns whether this filter bank of CAN was active.
    fn activates(&self, bank: u32) -> bool;
}

impl Peripherals {
    /// Returns whether other peripherals continue exactly alike from `cycle` on. `later`: uses of the other ones.
    pub(crate) fn continues_as(
        &self,
        other: &Peripherals,
        cycle: u64,
        later: Option<&dyn RegisterUses>,
    ) -> bool {
        let state = |peripherals: &Peripherals| format!("{:?}", peripherals.essence(cycle, later));
        state(self) == state(other)
    }

    /// Returns a copy at `cycle` without statistics, and without registers that have no effect and are not accessed later.
    fn essence(&self, cycle: u64, later: Option<&dyn RegisterUses>) -> Peripherals {
        let mut copy = self.clone();
        copy.run_timers(cycle);
        copy.timers.catch_up(cycle);
        copy.pin_changes.clear();
        copy.can.forget_statistics();
        copy.can.take_active_filters();
        let Some(later) = later else { return copy };
        for (port, base) in copy.gpio.iter_mut().zip((PORTS..).step_by(BLOCK as usize)) {
            port.forget(|word| !later.touches(base + 4 * word..base + 4 * word + 4));
        }
        for (dma, base) in copy.dma.iter_mut().zip((DMA..).step_by(BLOCK as usize)) {
            dma.forget(|registers| !later.touches(base + registers..base + registers + STREAM_LEN));
        }
        copy.can.forget_inactive_filters(|bank| {
            let registers = CAN + BANKS + 8 * bank;
            !later.activates(bank) && !later.touches(registers..registers + 8)
        });
        copy
    }
}

impl Gpio {
    /// Forgets words without effect for which `is_forgotten` returns true.
    fn forget(&mut self, is_forgotten: impl Fn(u32) -> bool) {
        for word in WITHOUT_EFFECT.into_iter().filter(|word| is_forgotten(*word)) {
            self.words[word as usize] = 0;
        }
    }
}

impl Dma {
    /// Forgets the registers of streams that are off, have no flags, and for which `is_forgotten` returns true. It is called with the
    /// offset of the first register.
    fn forget(&mut self, is_forgotten: impl Fn(u32) -> bool) {
        for (stream, first) in self.streams.iter_mut().zip((FIRST_STREAM..).step_by(STREAM_LEN as usize)) {
            if is_forgotten(first) {
                stream.forget();
            }
        }
    }
}
