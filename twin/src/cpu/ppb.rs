//! System registers at E000_0000h to E003_FFFFh: which register an access reaches (B3.2 to B3.5, C1.6, C1.8).
//!
//! Loads and stores of less than a word reach the word that contains them. A register that is not modelled stops the core with
//! [`Stop::Unmodelled`](crate::cpu::Stop::Unmodelled).

use crate::cpu::core::{Core, Result};
use crate::cpu::memory::Place;
use crate::cpu::system::debug::{MON_EN, MON_PEND};
use crate::cpu::system::fpb::Fpb;
use crate::cpu::system::nvic::Nvic;
use crate::cpu::system::{debug, nvic, scb};
use crate::cpu::trap::{
    BUS_FAULT, DEBUG_MONITOR, INTERRUPTS, MEM_MANAGE, NMI, PEND_SV, SV_CALL, SYSTICK, Trap, USAGE_FAULT,
};

const DWT_CTRL: u32 = 0xE000_1000;
const DWT_CYCCNT: u32 = 0xE000_1004;
/// The FPB, of whose registers the last one is FP_COMP7.
const FPB: u32 = 0xE000_2000;
const FPB_LAST: u32 = 0xE000_2024;
const ICTR: u32 = 0xE000_E004;
const ACTLR: u32 = 0xE000_E008;
const SYST_CSR: u32 = 0xE000_E010;
const SYST_CVR: u32 = 0xE000_E018;
const SYST_CALIB: u32 = 0xE000_E01C;
const NVIC: u32 = 0xE000_E100;
const NVIC_ISPR: u32 = 0xE000_E200;
const NVIC_ISPR_END: u32 = 0xE000_E240;
const NVIC_END: u32 = 0xE000_E4F0;
const CPUID: u32 = 0xE000_ED00;
const ICSR: u32 = 0xE000_ED04;
const VTOR: u32 = 0xE000_ED08;
const AIRCR: u32 = 0xE000_ED0C;
const SCR: u32 = 0xE000_ED10;
const CCR: u32 = 0xE000_ED14;
const SHPR1: u32 = 0xE000_ED18;
const SHPR3: u32 = 0xE000_ED20;
const SHCSR: u32 = 0xE000_ED24;
const CFSR: u32 = 0xE000_ED28;
const HFSR: u32 = 0xE000_ED2C;
const DFSR: u32 = 0xE000_ED30;
const MMFAR: u32 = 0xE000_ED34;
const BFAR: u32 = 0xE000_ED38;
const AFSR: u32 = 0xE000_ED3C;
const ID_PFR0: u32 = 0xE000_ED40;
const ID_END: u32 = 0xE000_ED74;
const CPACR: u32 = 0xE000_ED88;
const MPU: u32 = 0xE000_ED90;
const MPU_END: u32 = 0xE000_EDBC;
const DHCSR: u32 = 0xE000_EDF0;
const DEMCR: u32 = 0xE000_EDFC;
const STIR: u32 = 0xE000_EF00;
const FPCCR: u32 = 0xE000_EF34;
const FPCAR: u32 = 0xE000_EF38;
const FPDSCR: u32 = 0xE000_EF3C;
const MVFR0: u32 = 0xE000_EF40;
const MVFR1: u32 = 0xE000_EF44;

/// Cortex-M4 r0p1 (TRM 4.1).
const CPUID_VALUE: u32 = 0x410F_C241;
/// ID_PFR0 to ID_ISAR4 (TRM 4.1).
const ID_VALUES: [u32; 13] = [
    0x0000_0030,
    0x0000_0200,
    0x0010_0000,
    0x0000_0000,
    0x0010_0030,
    0x0000_0000,
    0x0100_0000,
    0x0000_0000,
    0x0110_1110,
    0x0211_2000,
    0x2123_2231,
    0x0111_1131,
    0x0131_0132,
];
const MVFR0_VALUE: u32 = 0x1011_0021;
const MVFR1_VALUE: u32 = 0x1100_0011;
const AIRCR_KEY: u32 = 0x05FA;
/// Only for a halted core.
const VECTRESET: u32 = 1;
const VECTCLRACTIVE: u32 = 1 << 1;
const SYSRESETREQ: u32 = 1 << 2;
const CP10_CP11: u32 = 0xF << 20;

/// Exceptions with a bit in SHCSR: active, pending, enabled (B3.2.13).
const SHCSR_ACTIVE: [(u32, u16); 7] = [
    (0, MEM_MANAGE),
    (1, BUS_FAULT),
    (3, USAGE_FAULT),
    (7, SV_CALL),
    (8, DEBUG_MONITOR),
    (10, PEND_SV),
    (11, SYSTICK),
];
const SHCSR_PENDED: [(u32, u16); 4] = [(12, USAGE_FAULT), (13, MEM_MANAGE), (14, BUS_FAULT), (15, SV_CALL)];
const SHCSR_ENABLED: [(u32, u16); 3] = [(16, MEM_MANAGE), (17, BUS_FAULT), (18, USAGE_FAULT)];

impl Core {
    /// A debugger sets C_DEBUGEN: the program reads it in DHCSR, and BKPT stops the core.
    pub fn attach_debugger(&mut self) {
        self.debug.attached = true;
    }

    pub(in crate::cpu) fn read_system(&mut self, at: Place) -> Result<u32> {
        if !at.privileged {
            return Err(self.raise(Trap::DataBus(at.address)));
        }
        let word = self.read_register(at.address & !3)?;
        Ok(word >> (8 * (at.address & 3)) & at.width.mask())
    }

    pub(in crate::cpu) fn write_system(&mut self, at: Place, value: u32) -> Result {
        let user_trigger = at.address == STIR && self.scb.ccr & scb::CCR_USERSETMPEND != 0;
        if !at.privileged && !user_trigger {
            return Err(self.raise(Trap::DataBus(at.address)));
        }
        let shift = 8 * (at.address & 3);
        let mask = at.width.mask() << shift;
        self.write_register(at.address & !3, value << shift & mask, mask)?;
        // The core evaluates priorities, enables and pending bits again.
        self.attention = 0;
        Ok(())
    }

    /// Inverts a bit of a register that reads as it was written.
    pub(in crate::cpu) fn flip_stored(&mut self, address: u32, bit: u32) -> bool {
        let flipped = self.read_register(address).map(|word| word ^ 1 << bit);
        flipped.and_then(|word| self.write_register(address, word, u32::MAX)).is_ok()
    }

    fn read_register(&mut self, address: u32) -> Result<u32> {
        Ok(match address {
            DWT_CTRL => self.debug.dwt_control(),
            DWT_CYCCNT => self.debug.cycle_count(self.cycle),
            FPB..=FPB_LAST => self.fpb.read(address - FPB),
            ICTR => u32::from((nvic::LINES - 1) / 32),
            ACTLR => self.scb.actlr,
            SYST_CSR..=SYST_CVR => self.systick.read(address - SYST_CSR, self.cycle),
            SYST_CALIB => self.config.systick_calibration,
            NVIC..NVIC_END => self.nvic.read(address - NVIC),
            CPUID => CPUID_VALUE,
            ICSR => self.interrupt_state(),
            VTOR => self.scb.vtor,
            AIRCR => 0xFA05_0000 | u32::from(self.scb.prigroup) << 8,
            SCR => self.scb.scr,
            CCR => self.scb.ccr,
            SHPR1..=SHPR3 => self.nvic.priorities(MEM_MANAGE + (address - SHPR1) as u16),
            SHCSR => self.handler_state(),
            CFSR => self.scb.cfsr,
            HFSR => self.scb.hfsr,
            DFSR => self.debug.dfsr,
            MMFAR => self.scb.mmfar,
            BFAR => self.scb.bfar,
            AFSR => 0,
            ID_PFR0..ID_END => ID_VALUES[((address - ID_PFR0) / 4) as usize],
            CPACR => self.scb.cpacr,
            MPU..MPU_END => self.mpu.read(address - MPU),
            DHCSR => self.debug.dhcsr(),
            DEMCR => {
                let pending = if self.nvic.pending.contains(DEBUG_MONITOR) { MON_PEND } else { 0 };
                self.debug.demcr & !MON_PEND | pending
            }
            FPCCR => self.fpu.fpccr,
            FPCAR => self.fpu.fpcar,
            FPDSCR => self.fpu.fpdscr,
            MVFR0 => MVFR0_VALUE,
            MVFR1 => MVFR1_VALUE,
            STIR => 0,
            _ => return Err(self.raise(Trap::Unmodelled { address, write: false })),
        })
    }

    fn write_register(&mut self, address: u32, value: u32, mask: u32) -> Result {
        let merged = |old: u32| old & !mask | value;
        let unmodelled = Trap::Unmodelled { address, write: true };
        match address {
            DWT_CTRL => {
                if !self.debug.set_dwt_control(merged(self.debug.dwt_control()), self.cycle) {
                    return Err(self.raise(unmodelled));
                }
            }
            DWT_CYCCNT => {
                let count = merged(self.debug.cycle_count(self.cycle));
                self.debug.set_cycle_count(count, self.cycle);
            }
            FPB..=FPB_LAST => {
                let new = merged(self.fpb.read(address - FPB));
                self.change_fpb(|fpb| fpb.write(address - FPB, new));
            }
            ACTLR => {
                let new = merged(self.scb.actlr);
                if new & !scb::ACTLR_BITS != 0 {
                    return Err(self.raise(unmodelled));
                }
                self.scb.actlr = new;
            }
            SYST_CSR..=SYST_CVR => self.systick.write(address - SYST_CSR, value, self.cycle),
            NVIC_ISPR..NVIC_ISPR_END => {
                for exception in Nvic::named(address - NVIC, value) {
                    self.pend(exception);
                }
            }
            NVIC..NVIC_END => self.nvic.write(address - NVIC, value, mask),
            ICSR => self.write_interrupt_state(value),
            VTOR => self.scb.vtor = merged(self.scb.vtor) & !0x7F,
            AIRCR if value >> 16 == AIRCR_KEY => {
                self.scb.prigroup = (value >> 8 & 7) as u8;
                if value & (VECTRESET | VECTCLRACTIVE) != 0 {
                    return Err(self.raise(Trap::Unpredictable));
                }
                if value & SYSRESETREQ != 0 {
                    return Err(self.raise(Trap::ResetRequest));
                }
            }
            SCR => self.scb.scr = merged(self.scb.scr) & scb::SCR_BITS,
            CCR => {
                let new = merged(self.scb.ccr);
                if new & scb::CCR_BFHFNMIGN != 0 {
                    return Err(self.raise(unmodelled));
                }
                self.scb.ccr = new & scb::CCR_BITS;
            }
            SHPR1..=SHPR3 => self.nvic.set_priorities(MEM_MANAGE + (address - SHPR1) as u16, value, mask),
            SHCSR => self.write_handler_state(merged(self.handler_state())),
            CFSR => self.scb.cfsr &= !value,
            HFSR => self.scb.hfsr &= !(value & scb::HFSR_BITS),
            DFSR => self.debug.dfsr &= !value,
            MMFAR => self.scb.mmfar = merged(self.scb.mmfar),
            BFAR => self.scb.bfar = merged(self.scb.bfar),
            CPACR => self.scb.cpacr = merged(self.scb.cpacr) & CP10_CP11,
            MPU..MPU_END => {
                let new = merged(self.mpu.read(address - MPU));
                self.mpu.write(address - MPU, new);
            }
            DEMCR => {
                let new = merged(self.debug.demcr);
                if new & !debug::DEMCR_BITS != 0 {
                    return Err(self.raise(unmodelled));
                }
                self.write_monitor(new);
            }
            STIR if value & 0x1FF < u32::from(nvic::LINES) => self.pend(INTERRUPTS + (value & 0x1FF) as u16),
            FPCCR => self.fpu.set_fpccr(merged(self.fpu.fpccr)),
            FPCAR => self.fpu.fpcar = merged(self.fpu.fpcar) & !7,
            FPDSCR => self.fpu.set_fpdscr(merged(self.fpu.fpdscr)),
            // Read-only registers, AIRCR without its key, and STIR of an interrupt that is not there. C_DEBUGEN is the debugger's.
            ICTR | SYST_CALIB | CPUID | AIRCR | AFSR | ID_PFR0..ID_END | DHCSR | STIR | MVFR0 | MVFR1 => {}
            _ => return Err(self.raise(unmodelled)),
        }
        Ok(())
    }

    /// Changes the FPB, and forgets decoded instructions that it may replace now. Those that it replaced were not kept.
    pub(in crate::cpu) fn change_fpb(&mut self, change: impl FnOnce(&mut Fpb)) {
        change(&mut self.fpb);
        for word in self.fpb.words() {
            self.invalidate(word..word + 4);
        }
    }

    /// ICSR (B3.2.4).
    fn interrupt_state(&self) -> u32 {
        let pending = |exception| u32::from(self.nvic.pending.contains(exception));
        let first = self.nvic.first_pending(self.scb.group_mask()).map_or(0, |(exception, _)| exception);
        let others = self.nvic.active.count() - u32::from(self.nvic.active.contains(self.ipsr));
        u32::from(self.ipsr)
            | u32::from(others == 0) << 11
            | u32::from(first) << 12
            | u32::from(self.nvic.is_interrupt_pending()) << 22
            | pending(SYSTICK) << 26
            | pending(PEND_SV) << 28
            | pending(NMI) << 31
    }

    fn write_interrupt_state(&mut self, value: u32) {
        for (set, exception) in [(31, NMI), (28, PEND_SV), (26, SYSTICK)] {
            if value >> set & 1 == 1 {
                self.pend(exception);
            } else if exception != NMI && value >> (set - 1) & 1 == 1 {
                self.nvic.pending.set(exception, false);
            }
        }
    }

    /// SHCSR.
    fn handler_state(&self) -> u32 {
        let bits = |table: &[(u32, u16)], set: nvic::Exceptions| {
            table.iter().fold(0, |bits, &(bit, exception)| bits | u32::from(set.contains(exception)) << bit)
        };
        bits(&SHCSR_ACTIVE, self.nvic.active)
            | bits(&SHCSR_PENDED, self.nvic.pending)
            | bits(&SHCSR_ENABLED, self.nvic.enabled)
    }

    fn write_handler_state(&mut self, value: u32) {
        let tables = [
            (&SHCSR_ACTIVE[..], &mut self.nvic.active),
            (&SHCSR_PENDED[..], &mut self.nvic.pending),
            (&SHCSR_ENABLED[..], &mut self.nvic.enabled),
        ];
        for (table, set) in tables {
            for &(bit, exception) in table {
                set.set(exception, value >> bit & 1 == 1);
            }
        }
    }

    /// DEMCR.
    fn write_monitor(&mut self, value: u32) {
        self.debug.set_demcr(value, self.cycle);
        self.nvic.enabled.set(DEBUG_MONITOR, value & MON_EN != 0);
        if value & MON_PEND != 0 {
            self.pend(DEBUG_MONITOR);
        } else {
            self.nvic.pending.set(DEBUG_MONITOR, false);
        }
    }
}
