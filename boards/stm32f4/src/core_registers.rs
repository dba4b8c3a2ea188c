//! Registers of the core in use: system control, SysTick, interrupt controller (PM0214 4.3 to 4.5).

use crate::registers::{Kept, Register};

/// Priority of the interrupts of the controllers, and of all others but SysTick.
const CAN: u32 = 0x60;
const OTHERS: u32 = 0x10;

/// System control and SysTick.
pub(crate) static CORE: [Register; 8] = [
    // VTOR: vector table.
    Register::kept(0xE000_ED08, !0, Kept::Vectors),
    // SCR: no deep sleep, no sleep after an interrupt, no event for a pending one.
    Register::of(0xE000_ED10, 1 << 4 | 1 << 2 | 1 << 1, 0),
    // CCR: no trap of divisions by zero and of unaligned accesses; the stack is aligned.
    Register::of(0xE000_ED14, 1 << 9 | 1 << 4 | 1 << 3, 1 << 9),
    // SHPR3: SysTick has the highest priority.
    Register::of(0xE000_ED20, 0xFF << 24, 0),
    // SHCSR: faults that have handlers of their own.
    Register::kept(0xE000_ED24, 0b111 << 16, Kept::Faults),
    // CPACR: floating-point unit.
    Register::kept(0xE000_ED88, 0xF << 20, Kept::Coprocessor),
    // SYST_CSR: clock of the core, interrupt, enabled.
    Register::of(0xE000_E010, 0b111, 0b111),
    // SYST_RVR: period of the tick.
    Register::kept(0xE000_E014, 0xFF_FFFF, Kept::Tick),
];

/// Interrupts of both controllers and of the time driver: 19, 20, 22, 28, 63, 64, 66. A board with one controller has
/// those of the second one disabled.
pub(crate) static INTERRUPTS: [Register; 6] = [
    // ISER0 to ISER2.
    Register::of(0xE000_E100, 1 << 19 | 1 << 20 | 1 << 22 | 1 << 28, 1 << 19 | 1 << 20 | 1 << 22 | 1 << 28),
    Register::kept(0xE000_E104, 1 << 31, Kept::Interrupts1),
    Register::kept(0xE000_E108, 1 << 0 | 1 << 2, Kept::Interrupts2),
    // IPR4, IPR5, IPR7: priorities, one byte each.
    Register::of(0xE000_E410, 0xFF << 24, CAN << 24),
    Register::of(0xE000_E414, 0xFF << 16 | 0xFF, CAN << 16 | CAN),
    Register::of(0xE000_E41C, 0xFF, OTHERS),
];
