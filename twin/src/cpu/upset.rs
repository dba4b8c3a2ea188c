//! Upsets: one bit of the state of the core changes.
//!
//! An *upset* inverts one flip-flop, as a particle does. [`Core::flip`] inverts a bit of a core register, which has no address.
//! [`Core::flip_system`] inverts a bit of a system register, which [`system_registers`] lists. Both change the state itself: keys,
//! locks and access rights play no part.
//!
//! ```
//! use can_twin::cpu::{Config, Core, CoreRegister};
//!
//! let mut core = Core::new(Config::stm32f4(1024));
//! core.flip(CoreRegister::R(3), 4);
//! assert_eq!(core.registers().r[3], 16);
//! ```
//!
//! The registers of the MPU regions, of the DWT and of the debugger are not listed, nor the shadows of the pipeline.

use std::fmt;
use std::ops::Range;

use crate::cpu::core::{Core, Unpredictable};
use crate::cpu::registers::{APSR, Control, EPSR_IT, EPSR_T, Flags};
use crate::cpu::system::fpb::Fpb;
use crate::cpu::system::nvic::{PRIORITY_BITS, lines};
use crate::cpu::system::scb::{CCR_BITS, SCR_BITS};
use crate::cpu::trap::INTERRUPTS;

/// A register without address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CoreRegister {
    /// R0 to R15. R13 is the stack pointer in use, R15 the address of the next instruction.
    R(u8),
    /// APSR, and T, IT and ICI of EPSR, at their places in xPSR.
    Xpsr,
    /// S0 to S31.
    S(u8),
    /// PRIMASK.
    Primask,
    /// BASEPRI.
    Basepri,
    /// FAULTMASK.
    Faultmask,
    /// CONTROL.
    Control,
}

impl CoreRegister {
    /// All of them.
    pub fn all() -> impl Iterator<Item = CoreRegister> {
        use CoreRegister::*;
        let others = [Xpsr, Primask, Basepri, Faultmask, Control];
        (0..16).map(R).chain((0..32).map(S)).chain(others)
    }

    /// The bits that hold state.
    #[must_use]
    pub const fn bits(self) -> u32 {
        match self {
            CoreRegister::R(13) => !0b11,
            CoreRegister::R(15) => !0b1,
            CoreRegister::R(_) | CoreRegister::S(_) => u32::MAX,
            CoreRegister::Xpsr => APSR | EPSR_T | EPSR_IT,
            CoreRegister::Primask | CoreRegister::Faultmask => 1,
            CoreRegister::Basepri => PRIORITY_BITS as u32,
            CoreRegister::Control => 0b111,
        }
    }
}

impl fmt::Display for CoreRegister {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CoreRegister::R(13) => f.write_str("SP"),
            CoreRegister::R(14) => f.write_str("LR"),
            CoreRegister::R(15) => f.write_str("PC"),
            CoreRegister::R(n) => write!(f, "R{n}"),
            CoreRegister::S(n) => write!(f, "S{n}"),
            CoreRegister::Xpsr => f.write_str("xPSR"),
            CoreRegister::Primask => f.write_str("PRIMASK"),
            CoreRegister::Basepri => f.write_str("BASEPRI"),
            CoreRegister::Faultmask => f.write_str("FAULTMASK"),
            CoreRegister::Control => f.write_str("CONTROL"),
        }
    }
}

/// A register with an address, and its bits that hold state.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StateRegister {
    /// Block and register, such as `NVIC.ISER0`.
    pub name: String,
    /// Address of the word.
    pub address: u32,
    /// Bits that an upset can invert.
    pub bits: u32,
}

const SYSTICK: u32 = 0xE000_E010;
const SYSTICK_NAMES: [(&str, u32); 3] = [("CTRL", 0x1_0007), ("LOAD", 0xFF_FFFF), ("VAL", 0xFF_FFFF)];
const ISER: Range<u32> = 0xE000_E100..0xE000_E110;
const ISPR: Range<u32> = 0xE000_E200..0xE000_E210;
const IABR: Range<u32> = 0xE000_E300..0xE000_E310;
const IPR: Range<u32> = 0xE000_E400..0xE000_E464;
const FPB: u32 = 0xE000_2000;
const FPB_END: u32 = 0xE000_2028;
const AIRCR: u32 = 0xE000_ED0C;
/// PRIGROUP in AIRCR.
const PRIGROUP: u32 = 8;
/// Registers whose content a store replaces.
const STORED: [(&str, u32, u32); 8] = [
    ("SCB.VTOR", 0xE000_ED08, !0x7F),
    ("SCB.SCR", 0xE000_ED10, SCR_BITS),
    ("SCB.CCR", 0xE000_ED14, CCR_BITS),
    ("SCB.SHPR1", 0xE000_ED18, 0x00F0_F0F0),
    ("SCB.SHPR2", 0xE000_ED1C, 0xF000_0000),
    ("SCB.SHPR3", 0xE000_ED20, 0xF0F0_00F0),
    ("SCB.CPACR", 0xE000_ED88, 0xF << 20),
    ("MPU.CTRL", 0xE000_ED94, 0b111),
];

/// Returns the registers of FPB, NVIC, SysTick, system control block and MPU that [`Core::flip_system`] can change.
#[must_use]
pub fn system_registers() -> Vec<StateRegister> {
    let register = |name: String, address, bits| StateRegister { name, address, bits };
    let sets = [("ISER", ISER), ("ISPR", ISPR), ("IABR", IABR)];
    let of_sets = sets.into_iter().flat_map(|(name, range)| {
        range.step_by(4).zip(0..).map(move |(address, n)| (format!("NVIC.{name}{n}"), address, lines(n)))
    });
    let priorities = IPR.step_by(4).zip(0..).map(|(address, n)| {
        let there = (0..4).filter(|byte| lines((4 * n + byte) / 32) >> ((4 * n + byte) % 32) & 1 == 1);
        let bits = there.fold(0, |bits, byte| bits | u32::from(PRIORITY_BITS) << (8 * byte));
        (format!("NVIC.IPR{n}"), address, bits)
    });
    let systick = SYSTICK_NAMES.into_iter().zip((SYSTICK..).step_by(4));
    let systick = systick.map(|((name, bits), address)| (format!("SysTick.{name}"), address, bits));
    let stored = STORED.into_iter().map(|(name, address, bits)| (name.to_owned(), address, bits));
    let fpb = Fpb::stored().zip(0..).map(|((offset, bits), n)| {
        let name = match n {
            0 => "FPB.FP_CTRL".to_owned(),
            1 => "FPB.FP_REMAP".to_owned(),
            _ => format!("FPB.FP_COMP{}", n - 2),
        };
        (name, FPB + offset, bits)
    });
    let prigroup = std::iter::once(("SCB.AIRCR".to_owned(), AIRCR, 0b111 << PRIGROUP));
    let all = of_sets.chain(priorities).chain(systick).chain(stored).chain(prigroup).chain(fpb);
    all.map(|(name, address, bits)| register(name, address, bits)).collect()
}

impl Core {
    /// Selects what an UNPREDICTABLE encoding does from now on.
    pub fn set_unpredictable(&mut self, reaction: Unpredictable) {
        self.config.unpredictable = reaction;
    }

    /// Inverts a bit of a core register. Has no effect on a bit that is not in [`CoreRegister::bits`].
    pub fn flip(&mut self, register: CoreRegister, bit: u32) {
        let mask = register.bits() & 1_u32.checked_shl(bit).unwrap_or(0);
        match register {
            CoreRegister::R(n) => self.r[usize::from(n & 15)] ^= mask,
            CoreRegister::S(n) => self.fpu.s[usize::from(n & 31)] ^= mask,
            CoreRegister::Xpsr => {
                self.flags = Flags::from_bits(self.flags.bits() ^ mask & APSR);
                self.epsr ^= mask & !APSR;
            }
            CoreRegister::Primask => self.masks.primask ^= mask != 0,
            CoreRegister::Faultmask => self.masks.faultmask ^= mask != 0,
            CoreRegister::Basepri => self.masks.basepri ^= mask as u8,
            CoreRegister::Control => self.flip_control(mask),
        }
        self.attention = 0;
    }

    /// Inverts bits of CONTROL. The other stack pointer comes into use with SPSEL in Thread mode (B1.4.1).
    fn flip_control(&mut self, mask: u32) {
        let bits = self.control.bits() ^ mask;
        let changes_stack = mask & 0b10 != 0 && self.ipsr == 0;
        self.control =
            Control { unprivileged: bits & 1 != 0, process_stack: bits & 2 != 0, fp_active: bits & 4 != 0 };
        if changes_stack {
            std::mem::swap(&mut self.r[13], &mut self.other_sp);
        }
    }

    /// Inverts a bit of a register of [`system_registers`]. Returns `false` for any other bit.
    pub fn flip_system(&mut self, address: u32, bit: u32) -> bool {
        let is_there =
            |register: &StateRegister| register.address == address && register.bits >> bit & 1 == 1;
        if bit > 31 || !system_registers().iter().any(is_there) {
            return false;
        }
        self.attention = 0;
        let set = [ISER, ISPR, IABR].iter().position(|range| range.contains(&address));
        let sets = [&mut self.nvic.enabled, &mut self.nvic.pending, &mut self.nvic.active];
        if let Some(n) = set {
            let exception = INTERRUPTS + (8 * (address & 0xF) + bit) as u16;
            let is_set = sets[n].contains(exception);
            sets[n].set(exception, !is_set);
            return true;
        }
        match address {
            _ if IPR.contains(&address) => {
                let first = INTERRUPTS + (address - IPR.start) as u16;
                let new = self.nvic.priorities(first) ^ 1 << bit;
                self.nvic.set_priorities(first, new, u32::MAX);
            }
            FPB..FPB_END => self.change_fpb(|fpb| fpb.flip(address - FPB, 1 << bit)),
            AIRCR => self.scb.prigroup ^= 1 << (bit - PRIGROUP),
            SYSTICK..=0xE000_E018 => self.systick.flip(address - SYSTICK, bit, self.cycle),
            _ => return self.flip_stored(address, bit),
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu::core::Config;

    fn core() -> Core {
        Core::new(Config::stm32f4(1024))
    }

    #[test]
    fn each_bit_of_a_core_register_flips_and_flips_back() {
        let start = core();
        for register in CoreRegister::all() {
            for bit in (0..32).filter(|bit| register.bits() >> bit & 1 == 1) {
                let mut core = start.clone();
                core.flip(register, bit);
                assert_ne!(core, start, "{register}.{bit}");
                core.flip(register, bit);
                assert_eq!(core, start, "{register}.{bit}");
            }
        }
    }

    #[test]
    fn each_bit_of_a_system_register_flips() {
        let start = core();
        for StateRegister { name, address, bits } in system_registers() {
            for bit in (0..32).filter(|bit| bits >> bit & 1 == 1) {
                let mut core = start.clone();
                assert!(core.flip_system(address, bit), "{name}.{bit}");
                assert_ne!(core, start, "{name}.{bit}");
            }
        }
    }

    #[test]
    fn other_bits_do_not_flip() {
        let mut core = core();
        let start = core.clone();
        core.flip(CoreRegister::R(13), 0);
        core.flip(CoreRegister::Primask, 32);
        assert!(!core.flip_system(0xE000_ED10, 0), "a reserved bit of SCR");
        assert!(!core.flip_system(0xE000_ED00, 0), "CPUID");
        assert_eq!(core, start);
    }

    #[test]
    fn stack_pointers_change_places_with_spsel() {
        let mut core = core();
        core.r[13] = 0x2000_0100;
        core.flip(CoreRegister::Control, 1);
        assert_eq!((core.r[13], core.other_sp), (0, 0x2000_0100));
    }
}
