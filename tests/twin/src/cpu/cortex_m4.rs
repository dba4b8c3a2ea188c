//! The core of a part: a [`twin_core::Core`] with the memories and the link of its board.

use std::sync::Arc;

use twin_core::{Config, Core, Stop};

use super::memories::Memories;
use super::{NotMemory, Registers, Step};
use crate::link::{Link, RefusedAccess};
use crate::mmio::Refusal;
use crate::model::Part;

const HARD_FAULT: u16 = 3;
/// `B .`
const BRANCH_TO_ITSELF: u16 = 0xE7FE;
/// Interrupt lines of the core, of which the parts use fewer.
const LINES: u16 = 97;
/// Bytes from the base of a stack frame to the return address (DDI 0403E B1.5.6).
const FRAME_PC: u32 = 0x18;
/// Bit of EXC_RETURN: the frame is on the process stack (B1.5.8).
const ON_PROCESS_STACK: u32 = 1 << 2;

/// A Cortex-M4F with flash, 128 KiB of RAM and the CCM of its part.
pub struct CortexM4 {
    core: Core,
    memories: Memories,
}

impl CortexM4 {
    /// A core after power-on, at the present of `link`.
    ///
    /// `image` is the content of flash from 0800 0000h on; the rest is erased. Accesses outside of the memories and stores to flash go to
    /// `link`.
    ///
    /// # Panics
    /// The image is larger than the flash of the part.
    pub fn new(part: Part, image: &[u8], link: Arc<Link>) -> Self {
        let mut core = Core::new(Config::stm32f4(part.flash_bytes()));
        core.advance_to(link.now().cycle);
        CortexM4 { core, memories: Memories::new(part, image, link) }
    }

    fn branches_to_itself(&self) -> bool {
        self.memories.half_at(self.core.pc()) == Some(BRANCH_TO_ITSELF)
    }

    /// Runs one instruction, exception entry or reset sequence.
    ///
    /// SysTick first counts the cycles up to the present of the link ([`Link::set_now`]).
    pub fn step(&mut self) -> Step {
        self.core.advance_to(self.memories.link().now().cycle);
        let (began, pc, was) = (self.core.cycle(), self.core.pc(), self.core.exception());
        let outcome = self.core.step(&mut self.memories);
        let cycles = (self.core.cycle() - began) as u32;
        let stopped = Step { cycles, systick: u64::MAX, ..Step::default() };
        let step = match outcome {
            Ok(step) => step,
            Err(Stop::Breakpoint { .. }) => return Step { breakpoint: true, ..stopped },
            Err(Stop::ResetRequest) => return Step { reset_request: true, ..stopped },
            Err(Stop::Unmodelled { address, write, .. }) => {
                let refused = RefusedAccess { address, write, refusal: Refusal::SystemRegister };
                return Step { refused: Some(refused), ..stopped };
            }
            Err(Stop::Unpredictable { address, word }) => {
                let refusal = Refusal::Unpredictable { word };
                let refused = RefusedAccess { address, write: false, refusal };
                return Step { refused: Some(refused), ..stopped };
            }
        };
        let is = self.core.exception();
        // Asked only of instructions that are their own successor.
        let spins = !step.asleep && self.core.pc() == pc && is == was && self.branches_to_itself();
        Step {
            cycles,
            asleep: step.asleep,
            systick: if step.asleep || spins { self.core.systick_event() } else { u64::MAX },
            spins,
            hard_fault: is == HARD_FAULT && was != HARD_FAULT,
            stuck: is == HARD_FAULT && self.branches_to_itself(),
            ..Step::default()
        }
    }

    /// Drives an NVIC input, 0 to 96. Level-sensitive.
    ///
    /// # Panics
    /// `irq` is above 96.
    pub fn set_irq(&mut self, irq: u16, asserted: bool) {
        self.core.set_irq(irq, asserted);
    }

    /// Drives the input of the NMI. Level-sensitive.
    pub fn set_nmi(&mut self, asserted: bool) {
        self.core.set_nmi(asserted);
    }

    /// Resets the core: all lines are low, and the next step reads the vector table. Memories keep their content.
    pub fn reset(&mut self) {
        (0..LINES).for_each(|irq| self.core.set_irq(irq, false));
        self.core.set_nmi(false);
        self.core.reset();
    }

    /// Returns whether a fault came up at a priority that no handler can preempt.
    pub fn is_locked_up(&self) -> bool {
        self.core.is_locked_up()
    }

    /// Returns the address of the next instruction.
    pub fn pc(&self) -> u32 {
        self.core.pc()
    }

    /// Returns where the exception just entered returns to: after a fault, the instruction that caused it.
    pub fn return_address(&self) -> Option<u32> {
        let registers = self.core.registers();
        // In Handler mode R13 is the main stack pointer.
        let frame =
            if registers.r[14] & ON_PROCESS_STACK != 0 { registers.other_sp } else { registers.r[13] };
        self.memories.word_at(frame.wrapping_add(FRAME_PC))
    }

    /// Returns where memory or bus refused an access since the last call.
    pub fn take_bus_fault(&mut self) -> Option<u32> {
        self.core.take_refused()
    }

    /// Returns whether the next sleep is Stop or Standby: SLEEPDEEP is set in SCR.
    pub fn sleeps_deeply(&self) -> bool {
        self.core.sleeps_deeply()
    }

    /// Sets C_DEBUGEN in DHCSR, as a debugger does: the program reads it there, and BKPT halts.
    pub fn enable_debug(&mut self) {
        self.core.attach_debugger();
    }

    /// Lets time pass up to `cycle` in which the core was halted: SysTick and the cycle counter stood still.
    pub fn skip_to(&mut self, cycle: u64) {
        self.core.skip_to(cycle);
    }

    /// Returns all core registers.
    pub fn registers(&self) -> Registers {
        let registers = self.core.registers();
        Registers { r: registers.r, xpsr: registers.xpsr }
    }

    /// Copies from flash or RAM without side effects.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves flash and RAM.
    pub fn read_memory(&self, address: u32, bytes: &mut [u8]) -> Result<(), NotMemory> {
        self.memories.copy_out(address, bytes)
    }

    /// Copies into RAM without side effects.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves RAM.
    pub fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        self.memories.copy_in(address, bytes)
    }

    /// Puts content into flash, `address` from 0800 0000h on, as a debug probe or the end of an operation does.
    ///
    /// # Errors
    /// [`NotMemory`] when the range leaves flash.
    pub fn write_flash(&mut self, address: u32, bytes: &[u8]) -> Result<(), NotMemory> {
        let changed = self.memories.program(address, bytes)?;
        self.core.invalidate(changed);
        Ok(())
    }
}
