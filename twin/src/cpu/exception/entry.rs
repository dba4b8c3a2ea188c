//! Exception entry: stacking, late arrival of a fault on the way, and the vector (B1.5.6, B1.5.7, B1.5.11).

use crate::cpu::bus::{Bus, Width};
use crate::cpu::core::{Core, Raised, Result};
use crate::cpu::cycles;
use crate::cpu::fpu::FRAME_WORDS;
use crate::cpu::registers::EPSR_T;
use crate::cpu::system::mpu::Access;
use crate::cpu::system::scb::{CCR_STKALIGN, HFSR_VECTTBL};
use crate::cpu::trap::{BUS_FAULT, HARD_FAULT, MEM_MANAGE, MSTKERR, STKERR, Trap, USAGE_FAULT};

/// Bytes of a frame without and with FPU registers.
pub const BASIC_FRAME: u32 = 0x20;
pub const EXTENDED_FRAME: u32 = 0x68;
/// xPSR bit 9 in a frame: 4 bytes of padding follow the frame.
pub const PADDED: u32 = 1 << 9;

/// EXC_RETURN of a frame without FPU registers; bit 4 is clear if there are some.
const TO_HANDLER: u32 = 0xFFFF_FFF1;
const TO_MAIN: u32 = 0xFFFF_FFF9;
const TO_PROCESS: u32 = 0xFFFF_FFFD;
pub const NO_FP: u32 = 1 << 4;

impl Core {
    /// Stacks the context and enters a handler. `return_address` goes to the frame.
    pub(in crate::cpu) fn enter<B: Bus>(&mut self, bus: &mut B, exception: u16, return_address: u32) {
        self.spent += cycles::ENTRY;
        let fp = if self.control.fp_active { 0 } else { NO_FP };
        let kind = match (self.ipsr != 0, self.control.process_stack) {
            (true, _) => TO_HANDLER,
            (false, false) => TO_MAIN,
            (false, true) => TO_PROCESS,
        };
        let link = kind & !NO_FP | fp;
        match self.push_frame(bus, return_address) {
            Ok(()) => self.take(bus, exception, link),
            Err(Raised) => self.enter_after_stacking_fault(bus, exception, link),
        }
    }

    /// The fault is taken instead if its priority is higher; then the exception stays pending. Otherwise the fault becomes pending.
    /// A fault that is the exception itself does not pend again: its handler runs although the frame is incomplete.
    fn enter_after_stacking_fault<B: Bus>(&mut self, bus: &mut B, exception: u16, link: u32) {
        let derived = match self.raised.take() {
            Some(Trap::DataAccess(_)) => self.fault(MEM_MANAGE, MSTKERR),
            Some(Trap::Usage(bits)) => self.fault(USAGE_FAULT, bits),
            _ => self.fault(BUS_FAULT, STKERR),
        };
        match derived {
            Some(fault) if self.priority(fault) < self.priority(exception) => {
                self.nvic.pending.set(exception, true);
                self.take(bus, fault, link);
            }
            // NMI alone preempts code of priority -1. The fault waits as a HardFault.
            derived => {
                self.nvic.pending.set(derived.unwrap_or(HARD_FAULT), true);
                self.take(bus, exception, link);
            }
        }
    }

    /// Pushes R0 to R3, R12, LR, the return address and xPSR, and makes room for FPU registers if the context has used them.
    pub(super) fn push_frame<B: Bus>(&mut self, bus: &mut B, return_address: u32) -> Result {
        let extended = self.control.fp_active;
        let (size, aligns) = match extended {
            true => (EXTENDED_FRAME, true),
            false => (BASIC_FRAME, self.scb.ccr & CCR_STKALIGN != 0),
        };
        let top = self.r[13];
        let padded = aligns && top & 4 != 0;
        let frame = top.wrapping_sub(size) & if aligns { !7 } else { !3 };
        self.r[13] = frame;
        let xpsr = self.xpsr() & !PADDED | if padded { PADDED } else { 0 };
        let [r0, r1, r2, r3] = [self.r[0], self.r[1], self.r[2], self.r[3]];
        let words = [r0, r1, r2, r3, self.r[12], self.r[14], return_address, xpsr];
        let rights = (self.is_privileged(), self.execution_priority() < 0);
        self.stack(bus, frame, &words, rights)?;
        if extended {
            self.stack_fp(bus, frame.wrapping_add(BASIC_FRAME), rights)?;
        }
        Ok(())
    }

    /// Stores words of a frame. The figures for entry contain its cycles. `rights`: privileged; at a negative priority.
    fn stack<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        words: &[u32],
        (privileged, negative): (bool, bool),
    ) -> Result {
        for (&word, at) in words.iter().zip((address..).step_by(4)) {
            if !self.mpu.permits(at, Access::Write, privileged, negative) {
                return Err(self.raise(Trap::DataAccess(at)));
            }
            self.store_bus(bus, at, Width::Word, word)?;
        }
        Ok(())
    }

    /// Stores the FPU registers of a frame.
    pub(in crate::cpu) fn stack_registers<B: Bus>(
        &mut self,
        bus: &mut B,
        address: u32,
        rights: (bool, bool),
    ) -> Result {
        self.spent += FRAME_WORDS * cycles::ACCESS;
        self.stack(bus, address, &self.fpu.frame(), rights)
    }

    /// Stores the FPU registers, or notes that they are to be stored before the next FPU instruction.
    fn stack_fp<B: Bus>(&mut self, bus: &mut B, address: u32, rights: (bool, bool)) -> Result {
        let (privileged, _) = rights;
        if self.fpu.defers_stacking() {
            let ready = self.handlers_ready();
            self.fpu.defer(address, self.ipsr == 0, !privileged, ready);
            return Ok(());
        }
        self.check_fpu(privileged)?;
        self.stack_registers(bus, address, rights)
    }

    /// Enters a handler whose context is already stacked.
    pub(super) fn take<B: Bus>(&mut self, bus: &mut B, exception: u16, link: u32) {
        let mut exception = exception;
        let mut vector = self.vector(bus, exception);
        if vector.is_none() && exception > HARD_FAULT {
            self.nvic.pending.set(exception, true);
            exception = HARD_FAULT;
            vector = self.vector(bus, exception);
        }
        let (main, process) = self.stack_pointers();
        self.r[14] = link;
        self.ipsr = exception;
        self.control.fp_active = false;
        self.control.process_stack = false;
        self.set_stack_pointers(main, process);
        self.nvic.pending.set(exception, false);
        self.nvic.active.set(exception, true);
        self.event = true;
        self.exclusive = false;
        self.attention = 0;
        match vector {
            Some(vector) => {
                self.epsr = if vector & 1 == 1 { EPSR_T } else { 0 };
                self.next = vector & !1;
                self.r[15] = self.next;
            }
            None => self.lock_up(),
        }
    }

    /// Reads a vector; a failure is noted in HFSR.
    fn vector<B: Bus>(&mut self, bus: &mut B, exception: u16) -> Option<u32> {
        let vector = bus.vector(self.scb.vtor.wrapping_add(4 * u32::from(exception))).ok();
        if vector.is_none() {
            self.scb.hfsr |= HFSR_VECTTBL;
        }
        vector
    }
}
