//! Resets by RCC (RM0090 7.3.5 to 7.3.9).

use super::Peripherals;
use super::crc::Crc;
use super::exti::Syscfg;
use super::map::*;
use super::rcc::{AHB1, APB1, APB2};
use super::system::Pwr;
use crate::bxcan::Side;

impl Peripherals {
    /// Resets the blocks whose reset bits were set in RCC.
    pub(super) fn reset_blocks(&mut self, bus: u32, bits: u32) {
        let hit = |on: u32, bit: u32| bus == on && bits >> bit & 1 == 1;
        for (port, gpio) in self.gpio.iter_mut().enumerate() {
            if hit(AHB1, port as u32) {
                gpio.reset();
            }
        }
        if hit(AHB1, CRC_BIT) {
            self.crc = Crc::default();
        }
        for (dma, bit) in self.dma.iter_mut().zip(DMA_BITS) {
            if hit(AHB1, bit) {
                dma.reset();
            }
        }
        self.timers.reset_at(bus, bits);
        for (i2c, bit) in self.i2c.0.iter_mut().zip(I2C_BITS) {
            if hit(APB1, bit) {
                i2c.reset();
            }
        }
        for (side, bit) in [(Side::Can1, CAN1_BIT), (Side::Can2, CAN2_BIT)] {
            if hit(APB1, bit) {
                self.can.reset(side);
            }
        }
        if hit(APB1, PWR_BIT) {
            self.pwr = Pwr::new(self.part);
        }
        if hit(APB2, SYSCFG_BIT) {
            self.syscfg = Syscfg::default();
        }
    }
}
