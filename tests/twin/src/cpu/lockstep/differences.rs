//! Kinds of differences between the cores, and how one is recognised.

use std::fmt;

use rsemu::cpu::arm::v7m::Regs;
use twin_core::{Registers, View};

const EXCEPTION: u32 = 0x1FF;
const T: u32 = 1 << 24;

/// Known kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    AfterReset,
    EventRegister,
    SysTickAhead,
    SysTickPendedEarly,
    SysTickReference,
    SysTickWithoutReload,
    CycleCounter,
    NmiAgain,
    EdgeWhileActive,
    ShortPulse,
    DebugRegister,
    LongMultiplyCycles,
    DivideCycles,
    FailedStrexCycles,
    FpFrameCycles,
    FpCycles,
    FpscrAtEntry,
    EvenBranch,
    OwnAddressStacked,
    MaskedWakeUp,
    SpLowBits,
    StackingFault,
    Unknown,
}

/// The leader before a step.
pub struct Before {
    pub cycle: u64,
    pub registers: Registers,
    pub view: View,
    /// The next two half-words of code.
    pub code: u32,
}

/// Both cores after a step.
pub struct After {
    pub registers: Registers,
    pub view: View,
    pub cycles: u64,
    pub old: Regs,
    pub old_cycles: u64,
    /// An access that only one of them made.
    pub problem: Option<String>,
}

impl fmt::Display for Before {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:08X} at {:08X} xPSR {:08X}", self.code, self.registers.r[15], self.registers.xpsr)
    }
}

impl After {
    fn stack_pointers(&self) -> (u32, u32) {
        let process = self.registers.xpsr & EXCEPTION == 0 && self.view.control & 2 != 0;
        match process {
            true => (self.registers.other_sp, self.registers.r[13]),
            false => (self.registers.r[13], self.registers.other_sp),
        }
    }

    pub fn differs(&self) -> Option<String> {
        let (new, old, view) = (&self.registers, &self.old, &self.view);
        let masks = (view.primask, view.faultmask, view.basepri, view.control);
        let old_masks = (old.primask, old.faultmask, old.basepri, old.control);
        if new.r == old.r
            && new.xpsr == old.xpsr
            && (old.msp, old.psp) == self.stack_pointers()
            && masks == old_masks
        {
            return None;
        }
        let mut text = String::new();
        for register in (0..16).filter(|&register| new.r[register] != old.r[register]) {
            text += &format!(" r{register} {:X} old {:X}", new.r[register], old.r[register]);
        }
        if new.xpsr != old.xpsr {
            text += &format!(" xPSR {:X} old {:X}", new.xpsr, old.xpsr);
        }
        if (old.msp, old.psp) != self.stack_pointers() {
            text += &format!(" SPs {:X?} old {:X?}", self.stack_pointers(), (old.msp, old.psp));
        }
        if masks != old_masks {
            text += &format!(" masks {masks:X?} old {old_masks:X?}");
        }
        Some(text)
    }

    fn entered(&self, before: &Before) -> bool {
        let exception = self.registers.xpsr & EXCEPTION;
        exception != 0 && exception != before.registers.xpsr & EXCEPTION
    }
}

/// The address that a load of one register reads, for the encodings that compilers use.
fn loaded_address(before: &Before) -> Option<u32> {
    let (code, r) = (before.code, &before.registers.r);
    let (first, second) = (code >> 16, code & 0xFFFF);
    let reg = |number: u32| r[(number & 15) as usize];
    Some(match first {
        _ if first & 0xF800 == 0x6800 => reg(first >> 3 & 7).wrapping_add((first >> 6 & 0x1F) * 4),
        _ if first & 0xF800 == 0x7800 => reg(first >> 3 & 7).wrapping_add(first >> 6 & 0x1F),
        _ if first & 0xFE00 == 0x5800 || first & 0xFE00 == 0x5C00 => {
            reg(first >> 3 & 7).wrapping_add(reg(first >> 6 & 7))
        }
        _ if matches!(first & 0xFFF0, 0xF8D0 | 0xF890 | 0xF8B0) => reg(first).wrapping_add(second & 0xFFF),
        _ if matches!(first & 0xFFF0, 0xF850 | 0xF810) && second & 0xFC0 == 0 => {
            reg(first).wrapping_add(reg(second) << (second >> 4 & 3))
        }
        _ if matches!(first & 0xFFF0, 0xF850 | 0xF810) && second & 0x800 != 0 => {
            let offset = second & 0xFF;
            match (second >> 10 & 1, second >> 9 & 1) {
                (0, _) => reg(first),
                (_, 1) => reg(first).wrapping_add(offset),
                _ => reg(first).wrapping_sub(offset),
            }
        }
        _ => return None,
    })
}

/// Registers that the library reads as zero or has without the bits of debug: ICTR, ACTLR, SYST_CALIB, DFSR, ID registers, DHCSR, DEMCR, DWT.
fn is_debug_register(address: u32) -> bool {
    matches!(
        address & !3,
        0xE000_E004
            | 0xE000_E008
            | 0xE000_E01C
            | 0xE000_ED30
            | 0xE000_ED40..=0xE000_ED73
            | 0xE000_EDF0..=0xE000_EDFF
            | 0xE000_1000..=0xE000_1FFF
    )
}

/// The kind of a difference of registers, masks, sleep or FPU.
pub fn kind(before: &Before, after: &After, old_asleep: bool, difference: &str) -> Kind {
    let (new, old) = (&after.registers, &after.old);
    let others_equal = |except: &[usize]| {
        (0..16).all(|register| except.contains(&register) || new.r[register] == old.r[register])
    };
    // Awake of the old without an exception that it can take.
    if before.view.asleep && after.view.asleep && !old_asleep {
        return Kind::MaskedWakeUp;
    }
    if before.view.asleep && !after.view.asleep && old_asleep {
        return Kind::EventRegister;
    }
    if loaded_address(before).is_some_and(is_debug_register)
        && (0..16).filter(|&register| new.r[register] != old.r[register]).count() == 1
        && new.xpsr == old.xpsr
    {
        return Kind::DebugRegister;
    }
    if new.xpsr & T == 0 && old.xpsr & EXCEPTION != new.xpsr & EXCEPTION {
        return Kind::EvenBranch;
    }
    if others_equal(&[13]) && new.r[13] == old.r[13] & !3 && new.r[13] != old.r[13] {
        return Kind::SpLowBits;
    }
    if difference.starts_with("FPSCR") && after.entered(before) {
        return Kind::FpscrAtEntry;
    }
    Kind::Unknown
}

/// The kind of a difference in the accesses alone. After a refused word of a frame (STKERR) the old core goes on with the next word.
pub fn kind_of_access(before: &Before, after: &After) -> Kind {
    const STKERR: u32 = 1 << 12;
    if after.entered(before) && after.view.faults[0] & STKERR != 0 {
        Kind::StackingFault
    } else {
        Kind::Unknown
    }
}

/// The kind of a difference in cycles alone.
pub fn kind_of_cycles(before: &Before, after: &After) -> Kind {
    let first = before.code >> 16;
    let changed = (before.registers.xpsr ^ after.registers.xpsr) & EXCEPTION != 0;
    let more = after.cycles as i64 - after.old_cycles as i64;
    match first {
        _ if changed && more == 17 => Kind::FpFrameCycles,
        _ if changed => Kind::Unknown,
        0xFB80..=0xFB8F | 0xFBA0..=0xFBAF | 0xFBC0..=0xFBEF if more == -1 => Kind::LongMultiplyCycles,
        0xFB10..=0xFB7F if more == -1 => Kind::LongMultiplyCycles,
        0xFB90..=0xFB9F | 0xFBB0..=0xFBBF => Kind::DivideCycles,
        0xE840..=0xE84F | 0xE8C0..=0xE8CF if more == 1 => Kind::FailedStrexCycles,
        0xEC00..=0xEFFF | 0xFC00..=0xFFFF if before.view.fp[0] & 1 != 0 => Kind::FpFrameCycles,
        0xEC00..=0xEFFF | 0xFC00..=0xFFFF => Kind::FpCycles,
        _ => Kind::Unknown,
    }
}

/// The kind of a difference in a frame.
pub fn kind_of_frame(before: &Before, new: &[u8; 0x20], old: &[u8; 0x20]) -> Kind {
    let first = before.code >> 16;
    let only_pc = new[..0x18] == old[..0x18] && new[0x1C..] == old[0x1C..];
    if only_pc && matches!(first >> 8, 0xBE | 0xDF) { Kind::OwnAddressStacked } else { Kind::Unknown }
}
