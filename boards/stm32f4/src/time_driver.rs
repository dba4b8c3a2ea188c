//! Registers of the timer of the uptime, which the time driver of embassy-stm32 sets up (RM0090 18.4).

use crate::clocks::TIMERS;
use crate::registers::Register;

/// Address of TIM2, the timer of the uptime.
const TIM2: u32 = 0x4000_0000;
/// Interrupts at the overflow and in the middle between two.
const HALVES: u32 = 1 << 1 | 1 << 0;

/// Registers of the timer of the uptime. Time that went wrong stays wrong, so all of them reset the board. The time driver changes
/// channel 2 and its interrupt, which are no part of it.
pub(crate) static REGISTERS: [Register; 7] = [
    // CR1: counts up, without a divider of the dead time; an overflow is an update.
    Register::of(TIM2, 0x3FF, 1).or_reset(),
    // SMCR: clocked from inside.
    Register::of(TIM2 + 0x08, 0xFFFF, 0).or_reset(),
    // DIER
    Register::of(TIM2 + 0x0C, HALVES, HALVES).or_reset(),
    // PSC: a microsecond.
    Register::of(TIM2 + 0x28, 0xFFFF, TIMERS / 1_000_000 - 1).or_reset(),
    // ARR: 16 bits.
    Register::of(TIM2 + 0x2C, !0, 0xFFFF).or_reset(),
    // CCR1: the middle.
    Register::of(TIM2 + 0x34, !0, 0x8000).or_reset(),
    // NVIC_ISER0
    Register::of(0xE000_E100, 1 << 28, 1 << 28).or_reset(),
];
