//! Access to the registers of the core.

use super::Core;
use crate::cpu::fpu::FPSCR_BITS;
use crate::cpu::registers::{APSR, EPSR_IT, EPSR_T, Flags, IPSR, Registers};

impl Core {
    /// Returns all registers.
    #[must_use]
    pub fn registers(&self) -> Registers {
        Registers {
            r: self.r,
            other_sp: self.other_sp,
            xpsr: self.xpsr(),
            s: self.fpu.s,
            fpscr: self.fpu.fpscr,
        }
    }

    /// Sets all registers but the exception number, as a debugger does between two instructions.
    pub fn set_registers(&mut self, registers: &Registers) {
        self.r = registers.r;
        self.r[13] &= !3;
        self.r[15] &= !1;
        self.other_sp = registers.other_sp & !3;
        self.flags = Flags::from_bits(registers.xpsr);
        self.epsr = registers.xpsr & (EPSR_T | EPSR_IT);
        self.fpu.s = registers.s;
        self.fpu.fpscr = registers.fpscr & FPSCR_BITS;
        self.reset_pending = false;
    }

    /// Returns xPSR: flags, execution state and exception number.
    #[must_use]
    pub fn xpsr(&self) -> u32 {
        self.flags.bits() | self.epsr | u32::from(self.ipsr)
    }

    /// Returns the address of the next instruction.
    #[must_use]
    pub fn pc(&self) -> u32 {
        self.r[15]
    }

    /// Returns the number of the current exception: 0 in Thread mode, 16 + n for interrupt n.
    #[must_use]
    pub fn exception(&self) -> u16 {
        self.ipsr
    }

    /// Returns the cycles since power-on.
    #[must_use]
    pub fn cycle(&self) -> u64 {
        self.cycle
    }

    pub(in crate::cpu) fn set_xpsr(&mut self, xpsr: u32) {
        self.flags = Flags::from_bits(xpsr & APSR);
        self.epsr = xpsr & (EPSR_T | EPSR_IT);
        self.ipsr = (xpsr & IPSR) as u16;
    }

    /// ITSTATE (A7.3.3).
    pub(in crate::cpu) fn itstate(&self) -> u8 {
        (self.epsr >> 8 & 0xFC | self.epsr >> 25 & 3) as u8
    }

    pub(in crate::cpu) fn set_itstate(&mut self, state: u8) {
        let state = u32::from(state);
        self.epsr = self.epsr & !EPSR_IT | (state & 0xFC) << 8 | (state & 3) << 25;
    }

    /// Moves on to the next instruction of the IT block.
    pub(in crate::cpu) fn advance_it(&mut self) {
        let state = self.itstate();
        self.set_itstate(if state & 7 == 0 { 0 } else { state & 0xE0 | state << 1 & 0x1F });
    }

    #[inline]
    pub(in crate::cpu) fn is_privileged(&self) -> bool {
        self.ipsr != 0 || !self.control.unprivileged
    }

    /// Returns whether R13 is the process stack pointer.
    pub(in crate::cpu) fn uses_process_stack(&self) -> bool {
        self.ipsr == 0 && self.control.process_stack
    }

    /// Main and process stack pointer.
    pub(in crate::cpu) fn stack_pointers(&self) -> (u32, u32) {
        if self.uses_process_stack() { (self.other_sp, self.r[13]) } else { (self.r[13], self.other_sp) }
    }

    /// Sets both stack pointers. Mode and CONTROL say which one is in use.
    pub(in crate::cpu) fn set_stack_pointers(&mut self, main: u32, process: u32) {
        (self.r[13], self.other_sp) =
            if self.uses_process_stack() { (process & !3, main & !3) } else { (main & !3, process & !3) };
    }

    #[inline]
    pub(in crate::cpu) fn reg(&self, reg: u8) -> u32 {
        self.r[usize::from(reg & 15)]
    }

    /// Writes a register other than PC. The low two bits of SP stay zero (B1.4.1).
    #[inline]
    pub(in crate::cpu) fn set_reg(&mut self, reg: u8, value: u32) {
        let mask = if reg == 13 { !3 } else { !0 };
        self.r[usize::from(reg & 15)] = value & mask;
    }
}
