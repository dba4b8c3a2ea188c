//! The CPU as the board sees it: one instruction at a time.
//!
//! A [`CortexM4`] is a core of the crate `twin-core` with flash, RAM and CCM of its part. Everything else it reaches over the
//! [`Link`](crate::link::Link). The board steps it, drives its interrupt lines, and acts on what a [`Step`] reports.

mod cortex_m4;
mod memories;
#[cfg(test)]
mod tests;

pub use cortex_m4::CortexM4;

use crate::link::RefusedAccess;

/// One instruction, exception entry or reset sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// Model cycles, including those in which the core waited for flash.
    pub cycles: u32,
    /// The core sleeps in WFE or WFI. More steps change nothing until an interrupt line rises or [`Step::systick`] comes.
    pub asleep: bool,
    /// While asleep or spinning: the cycle at which SysTick pends its exception. `u64::MAX`: never.
    pub systick: u64,
    /// The instruction branched to itself. More steps do the same until an exception is pending.
    pub spins: bool,
    /// The step entered HardFault.
    pub hard_fault: bool,
    /// The HardFault handler branches to itself, so it never ends.
    pub stuck: bool,
    /// The next instruction is a breakpoint for the debugger. It did not run.
    pub breakpoint: bool,
    /// The program asks for a system reset (AIRCR.SYSRESETREQ).
    pub reset_request: bool,
    /// The core does not go on: the next instruction is UNPREDICTABLE, or accesses a system register that is not modelled.
    pub refused: Option<RefusedAccess>,
}

/// Core registers, for tests and for reports on a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Registers {
    /// R0 to R15. R13 is the stack pointer in use, R15 the next instruction.
    pub r: [u32; 16],
    /// Flags, IT state and exception number.
    pub xpsr: u32,
}

/// A range of addresses that is not memory of the part, or not of the kind that was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotMemory(
    /// First address of the range.
    pub u32,
);
