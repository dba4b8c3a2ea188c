//! System registers with their bits, and instructions of one half-word.

pub const DWT_CTRL: u32 = 0xE000_1000;
pub const DWT_CYCCNT: u32 = 0xE000_1004;
pub const SYST_CSR: u32 = 0xE000_E010;
pub const SYST_RVR: u32 = 0xE000_E014;
pub const SYST_CVR: u32 = 0xE000_E018;
pub const SYST_CALIB: u32 = 0xE000_E01C;
pub const NVIC_ISER: u32 = 0xE000_E100;
pub const NVIC_ISPR: u32 = 0xE000_E200;
pub const NVIC_ICPR: u32 = 0xE000_E280;
pub const NVIC_IPR: u32 = 0xE000_E400;
pub const ICSR: u32 = 0xE000_ED04;
pub const VTOR: u32 = 0xE000_ED08;
pub const AIRCR: u32 = 0xE000_ED0C;
pub const SCR: u32 = 0xE000_ED10;
pub const SEVONPEND: u32 = 1 << 4;
pub const CCR: u32 = 0xE000_ED14;
pub const SHPR1: u32 = 0xE000_ED18;
pub const SHPR2: u32 = 0xE000_ED1C;
pub const SHPR3: u32 = 0xE000_ED20;
pub const SHCSR: u32 = 0xE000_ED24;
/// SHCSR: MemManage, BusFault and UsageFault are enabled.
pub const ALL_FAULTS: u32 = 7 << 16;
pub const CFSR: u32 = 0xE000_ED28;
pub const BFARVALID: u32 = 1 << 15;
pub const UNDEFINSTR: u32 = 1 << 16;
pub const HFSR: u32 = 0xE000_ED2C;
pub const VECTTBL: u32 = 1 << 1;
pub const FORCED: u32 = 1 << 30;
pub const DEBUGEVT: u32 = 1 << 31;
pub const DFSR: u32 = 0xE000_ED30;
pub const MMFAR: u32 = 0xE000_ED34;
pub const BFAR: u32 = 0xE000_ED38;
pub const CPACR: u32 = 0xE000_ED88;
/// CPACR: all code, or privileged code alone, may use the FPU.
pub const FPU_FOR_ALL: u32 = 0x00F0_0000;
pub const FPU_FOR_PRIVILEGED: u32 = 0x0050_0000;
pub const MPU_TYPE: u32 = 0xE000_ED90;
pub const MPU_CTRL: u32 = 0xE000_ED94;
pub const MPU_RNR: u32 = 0xE000_ED98;
pub const MPU_RBAR: u32 = 0xE000_ED9C;
pub const MPU_RASR: u32 = 0xE000_EDA0;
pub const MPU_RBAR_A1: u32 = 0xE000_EDA4;
pub const MPU_RASR_A1: u32 = 0xE000_EDA8;
pub const DHCSR: u32 = 0xE000_EDF0;
pub const DEMCR: u32 = 0xE000_EDFC;
pub const MON_EN: u32 = 1 << 16;
pub const MON_PEND: u32 = 1 << 17;
pub const MON_REQ: u32 = 1 << 19;
pub const TRCENA: u32 = 1 << 24;
pub const STIR: u32 = 0xE000_EF00;
pub const FPCCR: u32 = 0xE000_EF34;
pub const FPCAR: u32 = 0xE000_EF38;
pub const FPDSCR: u32 = 0xE000_EF3C;

/// xPSR.
pub const N: u32 = 1 << 31;
pub const Z: u32 = 1 << 30;
pub const C: u32 = 1 << 29;
pub const V: u32 = 1 << 28;
pub const Q: u32 = 1 << 27;
pub const T: u32 = 1 << 24;

pub const NOP: u16 = 0xBF00;
pub const WFE: u16 = 0xBF20;
pub const WFI: u16 = 0xBF30;
pub const SEV: u16 = 0xBF40;
pub const CPSIE_I: u16 = 0xB662;
pub const CPSID_I: u16 = 0xB672;
pub const CPSID_F: u16 = 0xB671;
pub const UDF: u16 = 0xDE00;
pub const SVC: u16 = 0xDF00;
/// BKPT #3
pub const BKPT: u16 = 0xBE03;
pub const BX_R0: u16 = 0x4700;
pub const BX_LR: u16 = 0x4770;
/// LDR r2, [r0]; STR r1, [r0]
pub const LDR: u16 = 0x6802;
pub const STR: u16 = 0x6001;
