//! Refused accesses, which stop a board.

use std::fmt;

use super::{EmulatedBoard, State};
use crate::mmio::{Refusal, RefusedAccess};
use crate::peripherals::name;
use crate::wire::time::Time;

/// Bytes from the base of a stack frame to the return address (DDI 0403E B1.5.6).
const FRAME_PC: u32 = 0x18;
/// Bit of EXC_RETURN: the frame is on the process stack (B1.5.8).
const ON_PROCESS_STACK: u32 = 1 << 2;

/// An access of the program that the model refused. The board stops there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AccessError {
    /// Name of the board.
    pub board: String,
    /// Instant of the access.
    pub at: Time,
    /// Address of the instruction.
    pub pc: u32,
    /// Function of the instruction, if the image has symbols.
    pub function: Option<String>,
    /// Address that was accessed.
    pub address: u32,
    /// Peripheral and register there, by the memory map of the part: `DAC.SWTRIGR`; `None` for reserved addresses.
    pub register: Option<String>,
    /// True for a store, false for a load or fetch.
    pub write: bool,
    /// Reason of the refusal.
    pub refusal: Refusal,
}

impl fmt::Display for AccessError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let AccessError { board, at, pc, function, address, register, write, refusal } = self;
        let us = at.as_us();
        let function = function.as_ref().map_or(String::new(), |name| format!(" in {name}"));
        match refusal {
            Refusal::DeepSleep => {
                return write!(f, "{board}: WFI or WFE at {pc:08X}h{function} after {us} us: {refusal}");
            }
            Refusal::Unpredictable { word } => {
                return write!(
                    f,
                    "{board}: UNPREDICTABLE instruction {word:X}h at {pc:08X}h{function} after {us} us: {refusal}"
                );
            }
            _ => {}
        }
        let kind = if *write { "store to" } else { "load from" };
        let unnamed = match refusal {
            Refusal::SystemRegister => "a system register of the core",
            _ => "a reserved address",
        };
        let register = register.as_deref().unwrap_or(unnamed);
        let instruction = format!("the instruction at {pc:08X}h{function}");
        write!(f, "{board}: {kind} {register} ({address:08X}h) by {instruction} after {us} us: {refusal}")
    }
}

impl std::error::Error for AccessError {}

impl EmulatedBoard {
    /// Returns the address to which the exception just entered will return: after a fault, the instruction that caused it.
    fn return_address(&self) -> Option<u32> {
        let registers = self.core.registers();
        // In Handler mode R13 is the main stack pointer.
        let is_on_process_stack = registers.r[14] & ON_PROCESS_STACK != 0;
        let frame = if is_on_process_stack { registers.other_sp } else { registers.r[13] };
        self.chip.memory.word_at(frame.wrapping_add(FRAME_PC))
    }

    /// Stops at an access that was refused.
    pub(super) fn refuse(&mut self, refused: RefusedAccess) -> AccessError {
        let pc = self.return_address().unwrap_or(u32::MAX);
        self.stop_at(pc, refused)
    }

    /// Stops at the instruction `pc`.
    pub(super) fn stop_at(
        &mut self,
        pc: u32,
        RefusedAccess { address, write, refusal }: RefusedAccess,
    ) -> AccessError {
        // Reads the log of the program up to here.
        self.drain();
        let (board, at) = (self.config.name.clone(), self.now());
        let function = self.config.image.function_at(pc).map(str::to_owned);
        let register = name(self.config.model.part, address);
        let error = AccessError { board, at, pc, function, address, register, write, refusal };
        self.state = State::Refused(error.clone());
        error
    }
}
