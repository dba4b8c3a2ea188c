//! The CPU as the board sees it: one instruction at a time.

mod cortex_m4;
mod follower;
mod lockstep;
mod memories;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::link::{Link, RefusedAccess};
use crate::model::Part;

/// One instruction, exception entry or reset sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// Model cycles, those included in which the core waited for flash.
    pub cycles: u32,
    /// The core sleeps in WFE or WFI; more steps change nothing until an interrupt line rises or [`Step::systick`].
    pub asleep: bool,
    /// While asleep or spinning: the cycle at which SysTick pends its exception; `u64::MAX` for never.
    pub systick: u64,
    /// The instruction branched to itself; more steps do the same until an exception is pending.
    pub spins: bool,
    /// The step entered HardFault.
    pub hard_fault: bool,
    /// The HardFault handler branches to itself: it will never do anything else.
    pub stuck: bool,
    /// The next instruction is a breakpoint for the debugger; it did not run.
    pub breakpoint: bool,
    /// The program asks for a system reset (AIRCR.SYSRESETREQ).
    pub reset_request: bool,
    /// The core does not go on: the next instruction is UNPREDICTABLE, or accesses a system register that is not modelled.
    pub refused: Option<RefusedAccess>,
}

/// Core registers, for tests and for reports on a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Registers {
    /// R0 to R15; R13 is the stack pointer in use, R15 the next instruction.
    pub r: [u32; 16],
    /// Flags, IT state and exception number.
    pub xpsr: u32,
}

/// Memory outside flash and RAM was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotMemory(
    /// The first address outside.
    pub u32,
);

/// An ARMv7E-M core with its flash and RAM.
pub trait Cpu: Send {
    /// Runs one instruction, exception entry or reset sequence. SysTick first counts the cycles that passed since the last
    /// step by [`Link::set_now`].
    fn step(&mut self) -> Step;
    /// Drives an NVIC input; level sensitive.
    fn set_irq(&mut self, irq: u16, asserted: bool);
    /// Drives the input of the NMI; level sensitive.
    fn set_nmi(&mut self, asserted: bool);
    /// System reset: the core starts again from the vector table, memories keep their content.
    fn reset(&mut self);
    /// A fault at a priority that no handler can pre-empt.
    fn is_locked_up(&self) -> bool;
    /// Address of the next instruction.
    fn pc(&self) -> u32;
    /// Where the exception just entered will return to: after a fault, the instruction that caused it.
    fn return_address(&self) -> Option<u32>;
    /// Where memory or bus refused an access since the last call.
    fn take_bus_fault(&mut self) -> Option<u32>;
    /// The next sleep is Stop or Standby: SLEEPDEEP is set in SCR.
    fn sleeps_deeply(&self) -> bool;
    /// Sets C_DEBUGEN in DHCSR, as a debugger does: the program reads it there, and BKPT halts.
    fn enable_debug(&mut self);
    /// The core was halted until `cycle`: SysTick and the cycle counter stood still.
    fn skip_to(&mut self, cycle: u64);
    /// All core registers.
    fn registers(&self) -> Registers;
    /// Copies from flash or RAM without side effects.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves flash and RAM.
    fn read_memory(&self, address: u32, bytes: &mut [u8]) -> Result<(), NotMemory>;
    /// Copies into RAM without side effects.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves RAM.
    fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory>;
    /// Puts content into flash, `address` from 0800 0000h on, as a debug probe or the end of an operation does.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves flash.
    fn write_flash(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory>;
}

/// The core of a part: Cortex-M4F with its flash, 128 KiB RAM and CCM, everything else through `link`, stores to flash
/// among it. `flash` is the content from 0800 0000h on; the rest is erased.
pub fn stm32f4(part: Part, flash: &[u8], link: Arc<Link>) -> Box<dyn Cpu> {
    match std::env::var_os("TWIN_LOCKSTEP") {
        Some(directory) => Box::new(lockstep::LockStep::new(part, flash, link, directory.into())),
        None => Box::new(cortex_m4::CortexM4::new(part, flash, link)),
    }
}
