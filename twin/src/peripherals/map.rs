//! Addresses of the blocks and their clocks.

use super::rcc::{AHB1, APB1, APB2, Gate};
use super::timer::{CCR1, CCR4};
use super::timers::{self, TIM3, TIM5};
use crate::mmio::{Refusal, Width};
use crate::part::Part;

pub(super) const CRC_BIT: u32 = 12;
pub(super) const DMA_BITS: [u32; 2] = [21, 22];
pub(super) const I2C_BITS: [u32; 3] = [21, 22, 23];
pub(super) const CAN1_BIT: u32 = 25;
pub(super) const CAN2_BIT: u32 = 26;
pub(super) const PWR_BIT: u32 = 28;
pub(super) const SYSCFG_BIT: u32 = 14;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    Iwdg,
    Can,
    Pwr,
    Syscfg,
    Exti,
    Gpio(usize),
    Crc,
    Rcc,
    Flash,
    Dma(usize),
    I2c(usize),
    Timer(usize),
    Dbgmcu,
    Signature,
}

impl Block {
    /// The block at `address` and where it begins (RM0090 table 1).
    pub(super) fn at(part: Part, address: u32) -> Option<(Block, u32)> {
        let block = match address & !0x3FF {
            0x4000_3000 => Block::Iwdg,
            base @ 0x4000_5400..0x4000_6000 => Block::I2c((base as usize - 0x4000_5400) >> 10),
            0x4000_6400 | 0x4000_6800 => return Some((Block::Can, 0x4000_6400)),
            0x4000_7000 => Block::Pwr,
            0x4001_3800 => Block::Syscfg,
            0x4001_3C00 => Block::Exti,
            base @ 0x4002_0000..0x4002_2C00 => {
                let port = (base as usize - 0x4002_0000) >> 10;
                return (port < part.ports()).then_some((Block::Gpio(port), base));
            }
            0x4002_3000 => Block::Crc,
            0x4002_3800 => Block::Rcc,
            0x4002_3C00 => Block::Flash,
            base @ (0x4002_6000 | 0x4002_6400) => Block::Dma((base as usize - 0x4002_6000) >> 10),
            0xE004_2000 => Block::Dbgmcu,
            0x1FFF_7800 | 0x1FFF_C000 => Block::Signature,
            base => Block::Timer(timers::at(base)?),
        };
        Some((block, address & !0x3FF))
    }

    /// Returns whether an access depends on the state of TIM3 and TIM5 at that instant.
    pub(super) fn shows_timers(self) -> bool {
        matches!(self, Block::Timer(TIM3 | TIM5) | Block::Gpio(_) | Block::Rcc)
    }

    /// Returns whether a load from the register at an offset may change a flag, an interrupt line, a request or the time of an event.
    pub(super) fn changes_when_read(self, register: u32) -> bool {
        match self {
            Block::Can
            | Block::Gpio(_)
            | Block::Crc
            | Block::Rcc
            | Block::Pwr
            | Block::Syscfg
            | Block::Exti
            | Block::Flash
            | Block::Dma(_)
            | Block::Dbgmcu
            | Block::Signature
            | Block::Iwdg => false,
            // A load from a capture register clears its flag.
            Block::Timer(_) => (CCR1..=CCR4).contains(&register),
            Block::I2c(_) => true,
        }
    }

    /// Returns its clock gate; some blocks have none.
    pub(super) fn gate(self, offset: u32) -> Option<Gate> {
        let (bus, bit) = match self {
            Block::Can if offset < 0x400 => (APB1, CAN1_BIT),
            Block::Can => (APB1, CAN2_BIT),
            Block::Pwr => (APB1, PWR_BIT),
            Block::Syscfg => (APB2, SYSCFG_BIT),
            Block::Gpio(port) => (AHB1, port as u32),
            Block::Crc => (AHB1, CRC_BIT),
            Block::Dma(n) => (AHB1, DMA_BITS[n]),
            Block::I2c(n) => (APB1, I2C_BITS[n]),
            Block::Timer(n) => return Some(timers::TIMERS[n].gate),
            Block::Iwdg | Block::Exti | Block::Rcc | Block::Flash | Block::Dbgmcu | Block::Signature => {
                return None;
            }
        };
        Some(Gate { bus, bit })
    }

    /// Checks whether its registers support an access of this width (RM0090 4.4, 10.5, 13.13, 21.4, 32.9,
    /// 38.16).
    pub(super) fn takes(self, width: Width) -> Result<(), Refusal> {
        let taken = match self {
            Block::Can | Block::Crc | Block::Dma(_) | Block::Dbgmcu => width == Width::Word,
            Block::Iwdg => width != Width::Byte,
            _ => true,
        };
        if taken { Ok(()) } else { Err(Refusal::Width) }
    }
}
