//! State for the comparison with another core. Temporary: it leaves with the other core.

use crate::core::Core;
use crate::exception::Sleep;

/// State beside the registers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct View {
    /// PRIMASK.
    pub primask: bool,
    /// FAULTMASK.
    pub faultmask: bool,
    /// BASEPRI.
    pub basepri: u8,
    /// CONTROL.
    pub control: u32,
    /// Event register.
    pub event: bool,
    /// Exclusive monitor.
    pub exclusive: bool,
    /// WFI or WFE.
    pub asleep: bool,
    /// Locked up.
    pub locked_up: bool,
    /// Active exceptions.
    pub active: [u32; 4],
    /// Pending exceptions.
    pub pending: [u32; 4],
    /// Enabled exceptions.
    pub enabled: [u32; 4],
    /// SYST_CSR, SYST_RVR, SYST_CVR.
    pub systick: [u32; 3],
    /// DWT_CYCCNT, DEMCR.
    pub cyccnt: u32,
    /// DEMCR.
    pub demcr: u32,
    /// CFSR, HFSR, MMFAR, BFAR.
    pub faults: [u32; 4],
    /// FPCCR, FPCAR, FPDSCR.
    pub fp: [u32; 3],
    /// VTOR, SCR, CCR, CPACR, PRIGROUP.
    pub scb: [u32; 5],
}

impl Core {
    /// The state.
    pub fn view(&mut self) -> View {
        View {
            primask: self.masks.primask,
            faultmask: self.masks.faultmask,
            basepri: self.masks.basepri,
            control: self.control.bits(),
            event: self.event,
            exclusive: self.exclusive,
            asleep: self.sleep != Sleep::Awake,
            locked_up: self.locked_up,
            active: self.nvic.active.words(),
            pending: self.nvic.pending.words(),
            enabled: self.nvic.enabled.words(),
            systick: self.systick.peek(self.cycle),
            cyccnt: self.debug.cycle_count(self.cycle),
            demcr: self.debug.demcr,
            faults: [self.scb.cfsr, self.scb.hfsr, self.scb.mmfar, self.scb.bfar],
            fp: [self.fpu.fpccr, self.fpu.fpcar, self.fpu.fpdscr],
            scb: [self.scb.vtor, self.scb.scr, self.scb.ccr, self.scb.cpacr, u32::from(self.scb.prigroup)],
        }
    }
}
