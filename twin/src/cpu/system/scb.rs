//! System control block (B3.2): its state.

/// HFSR.
pub const HFSR_VECTTBL: u32 = 1 << 1;
pub const HFSR_FORCED: u32 = 1 << 30;
pub const HFSR_DEBUGEVT: u32 = 1 << 31;
pub const HFSR_BITS: u32 = HFSR_VECTTBL | HFSR_FORCED | HFSR_DEBUGEVT;
/// CCR.
pub const CCR_NONBASETHRDENA: u32 = 1;
pub const CCR_USERSETMPEND: u32 = 1 << 1;
pub const CCR_UNALIGN_TRP: u32 = 1 << 3;
pub const CCR_DIV_0_TRP: u32 = 1 << 4;
pub const CCR_BFHFNMIGN: u32 = 1 << 8;
pub const CCR_STKALIGN: u32 = 1 << 9;
pub const CCR_BITS: u32 =
    CCR_NONBASETHRDENA | CCR_USERSETMPEND | CCR_UNALIGN_TRP | CCR_DIV_0_TRP | CCR_STKALIGN;
/// ACTLR: interruption of multi-cycle instructions, write buffer, IT folding. None of them is there, so these bits change nothing.
pub const ACTLR_BITS: u32 = 0x7;
/// SCR.
pub const SCR_SLEEPONEXIT: u32 = 1 << 1;
pub const SCR_SLEEPDEEP: u32 = 1 << 2;
pub const SCR_SEVONPEND: u32 = 1 << 4;
pub const SCR_BITS: u32 = SCR_SLEEPONEXIT | SCR_SLEEPDEEP | SCR_SEVONPEND;

/// Registers of the system control block that hold state of their own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scb {
    pub vtor: u32,
    /// PRIGROUP, 0 to 7.
    pub prigroup: u8,
    pub scr: u32,
    pub ccr: u32,
    pub cfsr: u32,
    pub hfsr: u32,
    pub mmfar: u32,
    pub bfar: u32,
    /// Access to the FPU: CP10 and CP11 in CPACR.
    pub cpacr: u32,
    pub actlr: u32,
}

impl Scb {
    /// After a reset.
    pub fn new(vtor: u32) -> Self {
        Scb { vtor, ccr: CCR_STKALIGN, ..Scb::default() }
    }

    /// The bits of a priority that are its group (B1.5.4, "Priority grouping").
    pub fn group_mask(&self) -> u8 {
        !((2_u32 << self.prigroup) - 1) as u8
    }

    /// Returns whether code with these rights may use the FPU.
    pub fn permits_fpu(&self, privileged: bool) -> bool {
        match self.cpacr >> 20 & 3 {
            0b01 => privileged,
            0b11 => true,
            _ => false,
        }
    }
}
