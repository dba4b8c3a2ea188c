//! Registers of clocks and reset lines in use (RM0090 7.3, 3.9.1).

use crate::registers::{Kept, Register};

/// Addresses of RCC and of the control register of the flash.
const RCC_BASE: u32 = 0x4002_3800;
const FLASH_ACR: u32 = 0x4002_3C00;
/// Clocks and reset lines of ports A to I, of the CRC unit and of DMA1, which are on AHB1.
const ON_AHB1: u32 = 1 << 21 | 1 << 12 | 0x1FF;
/// Those of TIM2 and TIM5, which must not stop, of TIM3, and of both controllers, on APB1.
const TIME: u32 = 1 << 3 | 1 << 0;
const PULSE: u32 = 1 << 1;
const CONTROLLERS: u32 = 1 << 26 | 1 << 25;

/// Registers of clocks and reset lines.
pub(crate) static REGISTERS: [Register; 9] = [
    // RCC_CR: PLL, clock security system and HSE are on.
    Register::of(RCC_BASE, 1 << 24 | 1 << 19 | 1 << 16, 1 << 24 | 1 << 19 | 1 << 16),
    // RCC_PLLCFGR, RCC_CFGR: all but the clock outputs.
    Register::kept(RCC_BASE + 0x04, 0x0F43_7FFF, Kept::PllSettings).or_reset(),
    Register::kept(RCC_BASE + 0x08, 0xFCF3, Kept::ClockSettings).or_reset(),
    // RCC_AHB1RSTR, RCC_APB1RSTR
    Register::of(RCC_BASE + 0x10, ON_AHB1, 0).or_reset(),
    Register::of(RCC_BASE + 0x20, TIME | PULSE | CONTROLLERS, 0).or_reset(),
    // RCC_AHB1ENR, RCC_APB1ENR
    Register::kept(RCC_BASE + 0x30, ON_AHB1, Kept::PortClocks),
    Register::kept(RCC_BASE + 0x40, TIME, Kept::TimerClocks).or_reset(),
    Register::kept(RCC_BASE + 0x40, PULSE | CONTROLLERS, Kept::BusClocks),
    // FLASH_ACR: wait states, prefetch, caches.
    Register::kept(FLASH_ACR, 0x707, Kept::FlashAccess),
];
