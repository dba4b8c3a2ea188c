//! Program status, masks, CONTROL, and the registers as a debugger sees them (B1.4).

use crate::core::Core;

const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;
const Q: u32 = 1 << 27;
/// Bits of APSR in xPSR.
const APSR: u32 = N | Z | C | V | Q | 0xF << 16;
/// T in EPSR.
pub const EPSR_T: u32 = 1 << 24;
/// IT and ICI in EPSR.
pub const EPSR_IT: u32 = 0x0600_FC00;
/// Exception number in IPSR.
pub const IPSR: u32 = 0x1FF;

/// APSR (B1.4.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flags {
    pub n: bool,
    pub z: bool,
    pub c: bool,
    pub v: bool,
    pub q: bool,
    /// GE, four bits.
    pub ge: u8,
}

impl Flags {
    /// Sets N and Z from a result.
    pub fn set_nz(&mut self, result: u32) {
        self.n = result >> 31 == 1;
        self.z = result == 0;
    }

    /// At their places in APSR.
    pub fn bits(self) -> u32 {
        let flag = |flag, bit| if flag { bit } else { 0 };
        flag(self.n, N)
            | flag(self.z, Z)
            | flag(self.c, C)
            | flag(self.v, V)
            | flag(self.q, Q)
            | u32::from(self.ge) << 16
    }

    /// From their places in APSR.
    pub fn from_bits(bits: u32) -> Self {
        Flags {
            n: bits & N != 0,
            z: bits & Z != 0,
            c: bits & C != 0,
            v: bits & V != 0,
            q: bits & Q != 0,
            ge: (bits >> 16 & 0xF) as u8,
        }
    }

    /// Returns whether a condition of four bits holds (A7.3).
    #[inline]
    pub fn pass(self, condition: u8) -> bool {
        let holds = match condition >> 1 {
            0 => self.z,
            1 => self.c,
            2 => self.n,
            3 => self.v,
            4 => self.c && !self.z,
            5 => self.n == self.v,
            6 => self.n == self.v && !self.z,
            _ => return true,
        };
        holds != (condition & 1 == 1)
    }
}

/// PRIMASK, FAULTMASK, BASEPRI (B1.4.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Masks {
    pub primask: bool,
    pub faultmask: bool,
    /// Priority from which on exceptions are masked; 0 for none.
    pub basepri: u8,
}

/// CONTROL (B1.4.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Control {
    /// Thread mode is unprivileged.
    pub unprivileged: bool,
    /// Thread mode uses the process stack.
    pub process_stack: bool,
    /// The current context has used the FPU.
    pub fp_active: bool,
}

impl Control {
    /// As MRS reads it.
    pub fn bits(self) -> u32 {
        u32::from(self.unprivileged) | u32::from(self.process_stack) << 1 | u32::from(self.fp_active) << 2
    }
}

/// Core registers as a debugger sees them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers {
    /// R0 to R15. R13 is the stack pointer in use, R15 the next instruction.
    pub r: [u32; 16],
    /// The stack pointer that is not in use.
    pub other_sp: u32,
    /// Flags, execution state and exception number.
    pub xpsr: u32,
    /// S0 to S31.
    pub s: [u32; 32],
    /// Status and control of the FPU.
    pub fpscr: u32,
}

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
        self.fpu.fpscr = registers.fpscr & crate::execute::fpu::FPSCR_BITS;
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

    pub(crate) fn set_xpsr(&mut self, xpsr: u32) {
        self.flags = Flags::from_bits(xpsr & APSR);
        self.epsr = xpsr & (EPSR_T | EPSR_IT);
        self.ipsr = (xpsr & IPSR) as u16;
    }

    /// ITSTATE (A7.3.3).
    pub(crate) fn itstate(&self) -> u8 {
        (self.epsr >> 8 & 0xFC | self.epsr >> 25 & 3) as u8
    }

    pub(crate) fn set_itstate(&mut self, state: u8) {
        let state = u32::from(state);
        self.epsr = self.epsr & !EPSR_IT | (state & 0xFC) << 8 | (state & 3) << 25;
    }

    /// Moves on to the next instruction of the IT block.
    pub(crate) fn advance_it(&mut self) {
        let state = self.itstate();
        self.set_itstate(if state & 7 == 0 { 0 } else { state & 0xE0 | state << 1 & 0x1F });
    }

    #[inline]
    pub(crate) fn is_privileged(&self) -> bool {
        self.ipsr != 0 || !self.control.unprivileged
    }

    /// Returns whether R13 is the process stack pointer.
    pub(crate) fn uses_process_stack(&self) -> bool {
        self.ipsr == 0 && self.control.process_stack
    }

    /// Main and process stack pointer.
    pub(crate) fn stack_pointers(&self) -> (u32, u32) {
        if self.uses_process_stack() { (self.other_sp, self.r[13]) } else { (self.r[13], self.other_sp) }
    }

    /// Sets both stack pointers. Mode and CONTROL say which one is in use.
    pub(crate) fn set_stack_pointers(&mut self, main: u32, process: u32) {
        (self.r[13], self.other_sp) =
            if self.uses_process_stack() { (process & !3, main & !3) } else { (main & !3, process & !3) };
    }

    #[inline]
    pub(crate) fn reg(&self, reg: u8) -> u32 {
        self.r[usize::from(reg & 15)]
    }

    /// Writes a register other than PC. The low two bits of SP stay zero (B1.4.1).
    #[inline]
    pub(crate) fn set_reg(&mut self, reg: u8, value: u32) {
        let mask = if reg == 13 { !3 } else { !0 };
        self.r[usize::from(reg & 15)] = value & mask;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_as_in_table_a7_1() {
        let flags = |n, z, c, v| Flags { n, z, c, v, ..Flags::default() };
        assert!(flags(false, true, false, false).pass(0b0000), "EQ");
        assert!(flags(false, false, true, false).pass(0b1000), "HI");
        assert!(!flags(false, true, true, false).pass(0b1000), "HI with Z");
        assert!(flags(false, true, true, false).pass(0b1001), "LS with Z");
        assert!(flags(true, false, false, true).pass(0b1100), "GT");
        assert!(flags(true, false, false, false).pass(0b1101), "LE");
        assert!(flags(false, false, false, false).pass(0b1110), "AL");
    }

    #[test]
    fn flags_keep_their_bits() {
        for bits in [N, Z, C, V, Q, 0xA << 16] {
            assert_eq!(Flags::from_bits(bits).bits(), bits);
        }
    }
}
