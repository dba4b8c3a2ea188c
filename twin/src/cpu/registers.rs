//! Program status, masks, CONTROL, and the registers as a debugger sees them (B1.4): their layout.

const N: u32 = 1 << 31;
const Z: u32 = 1 << 30;
const C: u32 = 1 << 29;
const V: u32 = 1 << 28;
const Q: u32 = 1 << 27;
/// Bits of APSR in xPSR.
pub const APSR: u32 = N | Z | C | V | Q | 0xF << 16;
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
