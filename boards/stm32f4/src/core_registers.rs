//! Registers of the core in use: memory protection, system control and SysTick (PM0214 4.2, 4.4, 4.5).
//!
//! Not listed are those whose loss ends in a fault, and so in a reset: CCR, SHCSR, CPACR.

use crate::registers::{Kept, Register};

/// Registers of memory protection, system control and SysTick.
pub(crate) static REGISTERS: [Register; 6] = [
    // VTOR: vector table.
    Register::kept(0xE000_ED08, !0, Kept::Vectors),
    // SCR: no deep sleep, no sleep after an interrupt, no event for a pending one.
    Register::of(0xE000_ED10, 1 << 4 | 1 << 2 | 1 << 1, 0),
    // SHPR3: SysTick has the highest priority.
    Register::of(0xE000_ED20, 0xFF << 24, 0),
    // MPU_CTRL: enabled, without background region.
    Register::of(0xE000_ED94, 0b111, 1),
    // SYST_CSR: clock of the core, interrupt, enabled.
    Register::of(0xE000_E010, 0b111, 0b111),
    // SYST_RVR: period of the tick.
    Register::kept(0xE000_E014, 0xFF_FFFF, Kept::Tick),
];
