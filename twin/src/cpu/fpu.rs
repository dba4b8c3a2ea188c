//! Registers of the FPU and their bits (A2.5, B1.4.7, B3.2.20 to B3.2.24).

/// Bits of FPSCR that are there.
pub const FPSCR_BITS: u32 = 0xF7C0_009F;
/// Modes in FPSCR and FPDSCR: AHP, DN, FZ, RMode.
pub const MODES: u32 = 0x07C0_0000;
/// FPCCR: automatic and lazy preservation of the context, and the conditions of a deferred stacking.
pub const ASPEN: u32 = 1 << 31;
pub const LSPEN: u32 = 1 << 30;
pub const MONRDY: u32 = 1 << 8;
pub const BFRDY: u32 = 1 << 6;
pub const MMRDY: u32 = 1 << 5;
pub const HFRDY: u32 = 1 << 4;
pub const THREAD: u32 = 1 << 3;
pub const USER: u32 = 1 << 1;
pub const LSPACT: u32 = 1;
/// Words of a frame that hold FPU registers: S0 to S15 and FPSCR.
pub const FRAME_WORDS: u32 = 17;

/// Registers of the FPU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fpu {
    pub s: [u32; 32],
    pub fpscr: u32,
    pub fpccr: u32,
    pub fpcar: u32,
    pub fpdscr: u32,
    /// An instruction or exception used the registers since this was taken.
    pub is_used: bool,
}

impl Default for Fpu {
    fn default() -> Self {
        Fpu { s: [0; 32], fpscr: 0, fpccr: ASPEN | LSPEN, fpcar: 0, fpdscr: 0, is_used: false }
    }
}

impl Fpu {
    pub fn get(&self, reg: u8) -> u32 {
        self.s[usize::from(reg & 31)]
    }

    pub fn set(&mut self, reg: u8, value: u32) {
        self.s[usize::from(reg & 31)] = value;
    }

    pub fn set_fpccr(&mut self, value: u32) {
        self.fpccr = value & (ASPEN | LSPEN | MONRDY | BFRDY | MMRDY | HFRDY | THREAD | USER | LSPACT);
    }

    pub fn set_fpdscr(&mut self, value: u32) {
        self.fpdscr = value & MODES;
    }

    /// Returns whether exception entry leaves the stacking to the next FPU instruction.
    pub fn defers_stacking(&self) -> bool {
        self.fpccr & LSPEN != 0
    }

    /// Defers the stacking to the next FPU instruction. `ready`: bits of FPCCR for handlers that could run now.
    pub fn defer(&mut self, address: u32, thread: bool, user: bool, ready: u32) {
        self.fpcar = address & !7;
        let kept = self.fpccr & (ASPEN | LSPEN);
        let origin = if thread { THREAD } else { 0 };
        let rights = if user { USER } else { 0 };
        self.fpccr = kept | ready | origin | rights | LSPACT;
    }

    /// On a return: answers `true` if the stacking never happened, so that the registers still hold their values.
    pub fn keep_deferred(&mut self) -> bool {
        let deferred = self.fpccr & LSPACT != 0;
        self.fpccr &= !LSPACT;
        deferred
    }

    /// The words of a frame.
    pub fn frame(&self) -> [u32; FRAME_WORDS as usize] {
        std::array::from_fn(|word| if word < 16 { self.s[word] } else { self.fpscr })
    }

    pub fn set_frame(&mut self, words: &[u32; FRAME_WORDS as usize]) {
        self.s[..16].copy_from_slice(&words[..16]);
        self.fpscr = words[16] & FPSCR_BITS;
    }
}
