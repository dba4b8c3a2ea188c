//! RCC: oscillators, the clock tree, clock gates, peripheral resets, reset flags.
//!
//! RM0090 chapters 7 (F405) and 6 (F42x), RM0390 chapter 6 (F446), RM0386 chapter 6 (F469). HSE and the PLL take their
//! datasheet's time to get ready; HSE never becomes ready while HSEBYP does not match the oscillator of the board, or
//! if that is broken. The bus enforces gated clocks; `sleep` has the effect of the low-power enables (LPENR).
//! PLLI2S and PLLSAI lock at once.

use crate::mmio::Now;
use crate::model::Model;
use crate::part::Family;
use crate::wire::time::Time;

const HSI_HZ: u64 = 16_000_000;
/// DS8626 table 34: start-up of a 4..26 MHz crystal.
const HSE_STARTUP: Time = Time::from_ms(2);
/// DS8626 table 35: start-up of LSE.
const LSE_STARTUP: Time = Time::from_ms(2_000);
/// DS8626 table 36: PLL lock time at 2 MHz input, upper bound at 1 MHz is 300 µs.
const PLL_LOCK: Time = Time::from_us(200);

const CR: u32 = 0x00;
const PLLCFGR: u32 = 0x04;
const CFGR: u32 = 0x08;
const CIR: u32 = 0x0C;
pub(super) const AHB1RSTR: u32 = 0x10;
const APB2RSTR: u32 = 0x24;
pub(super) const AHB1ENR: u32 = 0x30;
const APB2ENR: u32 = 0x44;
const AHB1LPENR: u32 = 0x50;
const APB2LPENR: u32 = 0x64;
pub const BDCR: u32 = 0x70;
const CSR: u32 = 0x74;
const DCKCFGR: u32 = 0x8C;
/// Number of registers; the last one is DCKCFGR2 of the F446.
const WORDS: usize = 0x94 / 4 + 1;

const CR_HSION: u32 = 1 << 0;
const CR_HSIRDY: u32 = 1 << 1;
const CR_HSEON: u32 = 1 << 16;
const CR_HSERDY: u32 = 1 << 17;
const CR_HSEBYP: u32 = 1 << 18;
const CR_CSSON: u32 = 1 << 19;
const CR_PLLON: u32 = 1 << 24;
const CR_PLLRDY: u32 = 1 << 25;
const CR_PLLI2SON: u32 = 1 << 26;
const CR_PLLI2SRDY: u32 = 1 << 27;
const CR_PLLSAION: u32 = 1 << 28;
const CR_PLLSAIRDY: u32 = 1 << 29;
const CR_READY: u32 = CR_HSIRDY | CR_HSERDY | CR_PLLRDY | CR_PLLI2SRDY | CR_PLLSAIRDY;
const PLLCFGR_SRC_HSE: u32 = 1 << 22;

const BDCR_LSEON: u32 = 1 << 0;
const BDCR_LSERDY: u32 = 1 << 1;
const BDCR_LSEBYP: u32 = 1 << 2;
const BDCR_RTCSEL: u32 = 0b11 << 8;
const BDCR_BDRST: u32 = 1 << 16;

const CIR_CSSF: u32 = 1 << 7;
const CIR_CSSC: u32 = 1 << 23;

const CSR_LSION: u32 = 1 << 0;
const CSR_LSIRDY: u32 = 1 << 1;
const CSR_RMVF: u32 = 1 << 24;
const CSR_FLAGS: u32 = 0xFE00_0000;

/// AHB1ENR, the five LPENR, PLLI2SCFGR and PLLSAICFGR after a reset, of the families F405, F42x, F446 and F469.
pub(super) const AT_RESET: [(u32, [u32; 4]); 8] = [
    (AHB1ENR, [0x0010_0000, 0x0010_0000, 0, 0x0010_0000]),
    (0x50, [0x7E67_91FF, 0x7EEF_97FF, 0x6067_90FF, 0x7EEF_97FF]),
    (0x54, [0x0000_00F1, 0x0000_00F1, 0x0000_0081, 0x0000_00F1]),
    (0x58, [0x0000_0001, 0x0000_0001, 0x0000_0003, 0x0000_0003]),
    (0x60, [0x36FE_C9FF, 0xF6FE_C9FF, 0x3FFF_C9FF, 0xF6FE_C9FF]),
    (0x64, [0x0007_5F33, 0x0477_7F33, 0x00C7_7F33, 0x0C77_7F33]),
    (0x84, [0x2000_3000, 0x2000_3000, 0x2400_3010, 0x2000_3000]),
    (0x88, [0, 0x2400_3000, 0x0400_3010, 0x2400_3000]),
];

/// Cause of the last reset (RCC_CSR).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResetCause {
    /// Power came up.
    PowerOn,
    /// The supply fell below the threshold of the brown-out reset, but not below that of the power-on reset.
    BrownOut,
    /// The reset pin.
    Pin,
    /// AIRCR.SYSRESETREQ.
    Software,
    /// The independent watchdog ran out.
    Watchdog,
}

impl ResetCause {
    /// PORRSTF and BORRSTF, PINRSTF, SFTRSTF, IWDGRSTF. Every reset pulls the pin low (RM0090 7.1.1).
    const fn flags(self) -> u32 {
        match self {
            ResetCause::PowerOn => 0x0E00_0000,
            ResetCause::BrownOut => 0x0600_0000,
            ResetCause::Pin => 0x0400_0000,
            ResetCause::Software => 0x1400_0000,
            ResetCause::Watchdog => 0x2400_0000,
        }
    }
}

/// Offsets of the registers of a bus relative to those of AHB1.
pub(super) const AHB1: u32 = 0x00;
pub(super) const APB1: u32 = 0x10;
pub(super) const APB2: u32 = 0x14;

/// A clock gate and the reset of the same peripheral: register by bus, and bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gate {
    /// Offset from AHB1ENR: [`AHB1`], [`APB1`] or [`APB2`].
    pub bus: u32,
    /// Bit in ENR and RSTR.
    pub bit: u32,
}

/// Frequencies configured by the registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// HCLK in Hz, nominal.
    pub hclk: u64,
    /// HCLK cycles per PCLK1 cycle.
    pub apb1_divider: u64,
    /// HCLK cycles per PCLK2 cycle.
    pub apb2_divider: u64,
    /// HCLK cycles per APB1 timer clock.
    pub timer1_divider: u64,
    /// The board's oscillator drives the clock tree, with its error.
    pub from_crystal: bool,
}

/// The registers.
#[derive(Clone, Debug)]
pub struct Rcc {
    pub(super) model: Model,
    pub(super) words: [u32; WORDS],
    /// HSE starts when it is next switched on.
    pub hse_starts: bool,
    /// Instant before which HSE does not start.
    pub hse_from: Time,
    /// The prescaler of APB1 is broken: it divides by 2.
    pub apb1_stuck: bool,
    hse_ready: Time,
    pll_ready: Time,
    /// `None`: LSE is off, or bypassed with nothing on its pin.
    lse_ready: Option<Time>,
    /// Peripherals put into reset by the last write, as (bus as in [`Gate`], bits).
    pub resets: Option<(u32, u32)>,
    /// An enabled peripheral stops while the core sleeps.
    pub has_sleepers: bool,
}

impl Rcc {
    /// After power-on.
    pub fn new(model: Model) -> Self {
        let mut rcc = Rcc {
            model,
            words: [0; WORDS],
            hse_starts: true,
            hse_from: Time::ZERO,
            apb1_stuck: false,
            hse_ready: Time::NEVER,
            pll_ready: Time::NEVER,
            lse_ready: None,
            resets: None,
            has_sleepers: false,
        };
        rcc.reset(ResetCause::PowerOn);
        rcc
    }

    /// Stops HSE permanently. The clock security system then switches to HSI and raises the NMI (RM0090 7.2.7).
    ///
    /// # Panics
    /// Without clock security system on HSE that runs: a chip without clock is not modelled.
    pub fn fail_hse(&mut self) {
        assert!(
            self.word(CR) & CR_CSSON != 0 && self.word(CR) & CR_HSEON != 0,
            "the program did not start the CSS"
        );
        self.hse_starts = false;
        self.hse_ready = Time::NEVER;
        if self.clocks().from_crystal {
            *self.word_mut(CFGR) &= !0b11;
        }
        let pll = if self.word(PLLCFGR) & PLLCFGR_SRC_HSE != 0 { CR_PLLON } else { 0 };
        let cr = self.word_mut(CR);
        *cr = *cr & !(CR_HSEON | CR_CSSON | pll) | CR_HSION;
        *self.word_mut(CIR) |= CIR_CSSF;
    }

    /// Returns whether the clock security system raises the NMI.
    pub fn nmi(&self) -> bool {
        self.word(CIR) & CIR_CSSF != 0
    }

    /// Resets all registers except the reset flags, which accumulate until RMVF or a reset of the supply clears them.
    pub fn reset(&mut self, cause: ResetCause) {
        let flags = match cause {
            ResetCause::PowerOn | ResetCause::BrownOut => 0,
            ResetCause::Pin | ResetCause::Software | ResetCause::Watchdog => self.word(CSR) & CSR_FLAGS,
        };
        // The backup domain has no supply of its own on our boards: VBAT is VDD.
        let backup = if cause == ResetCause::PowerOn { 0 } else { self.word(BDCR) };
        if backup == 0 {
            self.lse_ready = None;
        }
        self.words = [0; WORDS];
        *self.word_mut(BDCR) = backup;
        let family = self.model.part.family() as usize;
        let of_family = AT_RESET.map(|(offset, values)| (offset, values[family]));
        let of_all = [(CR, 0x83), (PLLCFGR, 0x2400_3010), (CSR, flags | cause.flags())];
        for (offset, value) in of_family.into_iter().chain(of_all) {
            *self.word_mut(offset) = value;
        }
        self.has_sleepers = self.stops_in_sleep();
        self.hse_ready = Time::NEVER;
        self.pll_ready = Time::NEVER;
    }

    fn word(&self, offset: u32) -> u32 {
        self.words[offset as usize / 4]
    }

    fn word_mut(&mut self, offset: u32) -> &mut u32 {
        &mut self.words[offset as usize / 4]
    }

    pub(super) const fn exists(&self, offset: u32) -> bool {
        // PLLSAICFGR; CKGATENR and DCKCFGR2.
        match (self.model.part.family(), offset) {
            (Family::F42x | Family::F469, 0x88) | (Family::F446, 0x88 | 0x90 | 0x94) => return true,
            _ => {}
        }
        // The F405 has no DCKCFGR, but HALs of the family access it on every part.
        matches!(offset, 0x00..=0x18 | 0x20 | 0x24 | 0x30..=0x38 | 0x40 | 0x44 | 0x50..=0x58 | 0x60 | 0x64
            | 0x70 | 0x74 | 0x80 | 0x84 | DCKCFGR)
    }

    /// A load; `None` for a register the part lacks.
    pub fn read(&self, now: Now, offset: u32) -> Option<u32> {
        if !self.exists(offset) {
            return None;
        }
        let word = self.word(offset);
        Some(match offset {
            CR => {
                let ready = |on, at: Time, flag| if word & on != 0 && now.time >= at { flag } else { 0 };
                word & !CR_READY
                    | ready(CR_HSION, Time::ZERO, CR_HSIRDY)
                    | ready(CR_HSEON, self.hse_ready, CR_HSERDY)
                    | ready(CR_PLLON, self.pll_ready, CR_PLLRDY)
                    | ready(CR_PLLI2SON, Time::ZERO, CR_PLLI2SRDY)
                    | ready(CR_PLLSAION, Time::ZERO, CR_PLLSAIRDY)
            }
            CFGR => word & !0b1100 | (word & 0b11) << 2,
            BDCR if self.lse_ready.is_some_and(|at| now.time >= at) => word | BDCR_LSERDY,
            CSR => word & !CSR_LSIRDY | if word & CSR_LSION != 0 { CSR_LSIRDY } else { 0 },
            _ => word,
        })
    }

    /// A store; `None` for a register the part lacks.
    pub fn write(&mut self, now: Now, offset: u32, value: u32) -> Option<()> {
        if !self.exists(offset) {
            return None;
        }
        let old = self.word(offset);
        match offset {
            CR => {
                let value = match self.model.part.family() {
                    Family::F405 => value & !CR_PLLSAION,
                    Family::F42x | Family::F446 | Family::F469 => value,
                };
                let risen = value & !old;
                if risen & CR_HSEON != 0 {
                    self.hse_ready = match (self.model.oscillator.external, value & CR_HSEBYP != 0) {
                        _ if !self.hse_starts => Time::NEVER,
                        (false, false) => now.time.max(self.hse_from) + HSE_STARTUP,
                        (true, true) => now.time.max(self.hse_from),
                        _ => Time::NEVER,
                    };
                }
                if risen & CR_PLLON != 0 {
                    self.pll_ready = now.time + PLL_LOCK;
                }
                // The oscillator that drives SYSCLK cannot be stopped (RM0090 7.3.1).
                let in_use = match (self.word(CFGR) & 0b11, self.word(PLLCFGR) & PLLCFGR_SRC_HSE != 0) {
                    (0, _) => CR_HSION,
                    (1, _) => CR_HSEON,
                    (_, true) => CR_PLLON | CR_HSEON,
                    (_, false) => CR_PLLON | CR_HSION,
                };
                *self.word_mut(CR) = value | old & in_use;
            }
            CIR => {
                let flag = if value & CIR_CSSC != 0 { 0 } else { old & CIR_CSSF };
                *self.word_mut(CIR) = value & !(CIR_CSSF | CIR_CSSC) | flag;
            }
            BDCR => self.write_bdcr(now.time, value),
            CSR => {
                let flags = if value & CSR_RMVF != 0 { 0 } else { old & CSR_FLAGS };
                *self.word_mut(CSR) = flags | value & CSR_LSION;
            }
            AHB1RSTR..=APB2RSTR => {
                self.resets = Some((offset - AHB1RSTR, value & !old));
                *self.word_mut(offset) = value;
            }
            AHB1ENR..=APB2LPENR => {
                *self.word_mut(offset) = value;
                self.has_sleepers = self.stops_in_sleep();
            }
            _ => *self.word_mut(offset) = value,
        }
        Some(())
    }

    /// Writes BDCR. LSE is a crystal on both boards. If it is bypassed, it has no clock and never becomes ready.
    fn write_bdcr(&mut self, now: Time, value: u32) {
        // The source of RTCCLK stays until the backup domain is reset (RM0090 7.3.20).
        let source = match self.word(BDCR) & BDCR_RTCSEL {
            0 => value & BDCR_RTCSEL,
            chosen => chosen,
        };
        let value =
            if value & BDCR_BDRST != 0 { BDCR_BDRST } else { value & !(BDCR_LSERDY | BDCR_RTCSEL) | source };
        self.lse_ready = match value & (BDCR_LSEON | BDCR_LSEBYP) {
            BDCR_LSEON => self.lse_ready.or(Some(now + LSE_STARTUP)),
            _ => None,
        };
        *self.word_mut(BDCR) = value;
    }

    /// Returns whether a peripheral is clocked.
    pub fn is_clocked(&self, gate: Gate) -> bool {
        debug_assert!(AHB1ENR + gate.bus <= APB2ENR);
        self.word(AHB1ENR + gate.bus) >> gate.bit & 1 == 1
    }

    /// Returns the clock enables of a bus, as in [`Gate`].
    pub fn enabled(&self, bus: u32) -> u32 {
        self.word(AHB1ENR + bus)
    }

    /// Returns the low-power enables of a bus, as in [`Gate`].
    pub fn low_power(&self, bus: u32) -> u32 {
        self.word(AHB1LPENR + bus)
    }

    /// Returns whether a peripheral is held in reset.
    pub fn is_held(&self, gate: Gate) -> bool {
        self.word(AHB1RSTR + gate.bus) >> gate.bit & 1 == 1
    }

    /// Returns the frequencies of the present clock tree.
    pub fn clocks(&self) -> Clocks {
        let pllcfgr = self.word(PLLCFGR);
        let cfgr = self.word(CFGR);
        let (sysclk, from_crystal) = match cfgr & 0b11 {
            0 => (HSI_HZ, false),
            1 => (self.model.oscillator.hz, true),
            _ => {
                let crystal = pllcfgr & PLLCFGR_SRC_HSE != 0;
                let input = if crystal { self.model.oscillator.hz } else { HSI_HZ };
                let m = u64::from(pllcfgr & 0x3F).max(1);
                let n = u64::from(pllcfgr >> 6 & 0x1FF);
                let p = (u64::from(pllcfgr >> 16 & 0b11) + 1) * 2;
                ((input * n / (m * p)).max(1), crystal)
            }
        };
        let hpre = match cfgr >> 4 & 0xF {
            0..=7 => 1,
            8..=11 => 2 << (cfgr >> 4 & 0b11),
            // 1100b is 64: there is no 32 (RM0090 7.3.3).
            _ => 64 << (cfgr >> 4 & 0b11),
        };
        let apb_divider = |field: u32| match field & 0b111 {
            0..=3 => 1,
            n => 2 << (n - 4),
        };
        let apb1_divider = if self.apb1_stuck { 2 } else { apb_divider(cfgr >> 10) };
        let apb2_divider = apb_divider(cfgr >> 13);
        // RM0090 7.2, figure 16: timers run at PCLK, or at twice PCLK when it is divided.
        let timer1_divider = if apb1_divider == 1 { 1 } else { apb1_divider / 2 };
        Clocks { hclk: sysclk / hpre, apb1_divider, apb2_divider, timer1_divider, from_crystal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_us(us: u64) -> Now {
        Now { cycle: 0, time: Time::from_us(us) }
    }

    /// PLL M = 6, N = 168, P = 2 from a 12 MHz crystal; AHB 1, APB1 4, APB2 2.
    fn at_168_mhz() -> Rcc {
        let mut rcc = Rcc::new(Model::shipped("pyboard-v11"));
        rcc.write(at_us(0), PLLCFGR, 7 << 24 | PLLCFGR_SRC_HSE | 168 << 6 | 6).unwrap();
        rcc.write(at_us(0), CR, 0x83 | CR_HSEON | CR_PLLON).unwrap();
        rcc.write(at_us(3000), CFGR, 4 << 13 | 5 << 10 | 2).unwrap();
        rcc
    }

    #[test]
    fn the_pyboards_tree_gives_168_mhz_and_84_mhz_timers() {
        let clocks = at_168_mhz().clocks();
        assert_eq!(
            clocks,
            Clocks {
                hclk: 168_000_000,
                apb1_divider: 4,
                apb2_divider: 2,
                timer1_divider: 2,
                from_crystal: true
            }
        );
    }

    /// PLL M = 4, N = 168, P = 2 from 8 MHz; AHB 1, APB1 4, APB2 2.
    #[test]
    fn the_nucleos_tree_gives_168_mhz_from_a_bypassed_oscillator() {
        let mut rcc = Rcc::new(Model::shipped("nucleo-f446re"));
        rcc.write(at_us(0), PLLCFGR, 7 << 24 | PLLCFGR_SRC_HSE | 168 << 6 | 4).unwrap();
        rcc.write(at_us(0), CR, 0x83 | CR_HSEBYP | CR_HSEON | CR_PLLON).unwrap();
        assert_ne!(rcc.read(at_us(0), CR).unwrap() & CR_HSERDY, 0);
        rcc.write(at_us(300), CFGR, 4 << 13 | 5 << 10 | 2).unwrap();
        assert_eq!(rcc.clocks(), at_168_mhz().clocks());
    }

    #[test]
    fn hse_never_gets_ready_in_the_wrong_mode() {
        for (model, wrong) in
            [(Model::shipped("pyboard-v11"), CR_HSEBYP), (Model::shipped("nucleo-f446re"), 0)]
        {
            let mut rcc = Rcc::new(model);
            rcc.write(at_us(0), CR, 0x83 | CR_HSEON | wrong).unwrap();
            assert_eq!(rcc.read(Now { cycle: 0, time: Time::from_ms(60_000) }, CR).unwrap() & CR_HSERDY, 0);
        }
    }

    #[test]
    fn registers_are_those_of_the_part() {
        let (f405, f446) =
            (Rcc::new(Model::shipped("pyboard-v11")), Rcc::new(Model::shipped("nucleo-f446re")));
        for offset in [0x88, 0x90, 0x94] {
            assert_eq!(f405.read(at_us(0), offset), None);
            assert!(f446.read(at_us(0), offset).is_some());
        }
        assert_eq!(f446.read(at_us(0), 0x50), Some(0x6067_90FF));
        assert_eq!(f446.read(at_us(0), PLLCFGR), Some(0x2400_3010));
    }

    #[test]
    fn a_reset_runs_on_hsi() {
        let clocks = Rcc::new(Model::shipped("pyboard-v11")).clocks();
        assert_eq!((clocks.hclk, clocks.timer1_divider, clocks.from_crystal), (16_000_000, 1, false));
    }

    #[test]
    fn hse_gets_ready_after_its_start_up_time() {
        let mut rcc = Rcc::new(Model::shipped("pyboard-v11"));
        rcc.write(at_us(100), CR, 0x83 | CR_HSEON).unwrap();
        assert_eq!(rcc.read(at_us(2099), CR).unwrap() & CR_HSERDY, 0);
        assert_ne!(rcc.read(at_us(2100), CR).unwrap() & CR_HSERDY, 0);
    }

    #[test]
    fn the_clock_security_system_switches_to_hsi_and_raises_the_nmi() {
        let mut rcc = at_168_mhz();
        rcc.write(at_us(3000), CR, 0x83 | CR_HSEON | CR_PLLON | CR_CSSON).unwrap();
        assert!(!rcc.nmi());
        rcc.fail_hse();
        assert!(rcc.nmi());
        assert_eq!((rcc.clocks().hclk, rcc.clocks().from_crystal), (16_000_000, false));
        assert_eq!(rcc.read(at_us(9000), CR).unwrap() & (CR_HSERDY | CR_PLLRDY), 0);
        rcc.write(at_us(9000), CIR, CIR_CSSC).unwrap();
        assert!(!rcc.nmi());
        // It does not start again.
        rcc.write(at_us(9000), CR, 0x83 | CR_HSEON).unwrap();
        assert_eq!(rcc.read(at_us(60_000_000), CR).unwrap() & CR_HSERDY, 0);
    }

    #[test]
    fn the_oscillator_in_use_cannot_be_stopped() {
        let mut rcc = at_168_mhz();
        rcc.write(at_us(4000), CR, 0).unwrap();
        let cr = rcc.read(at_us(4000), CR).unwrap();
        assert_eq!(cr & (CR_HSEON | CR_PLLON | CR_HSION), CR_HSEON | CR_PLLON);
    }

    /// LSE continues during a reset of the part and stops at a reset of the backup domain.
    #[test]
    fn lse_gets_ready_after_its_start_up_time() {
        let mut rcc = Rcc::new(Model::shipped("pyboard-v11"));
        rcc.write(at_us(100), BDCR, BDCR_LSEON).unwrap();
        assert_eq!(rcc.read(at_us(2_000_099), BDCR).unwrap(), BDCR_LSEON);
        assert_eq!(rcc.read(at_us(2_000_100), BDCR).unwrap(), BDCR_LSEON | BDCR_LSERDY);
        rcc.reset(ResetCause::Software);
        assert_eq!(rcc.read(at_us(2_000_200), BDCR).unwrap(), BDCR_LSEON | BDCR_LSERDY);
        rcc.write(at_us(2_000_300), BDCR, BDCR_BDRST).unwrap();
        assert_eq!(rcc.read(at_us(9_000_000), BDCR).unwrap(), BDCR_BDRST);
    }

    #[test]
    fn lse_in_bypass_never_gets_ready() {
        let mut rcc = Rcc::new(Model::shipped("nucleo-f446re"));
        rcc.write(at_us(0), BDCR, BDCR_LSEON | BDCR_LSEBYP).unwrap();
        assert_eq!(rcc.read(at_us(60_000_000), BDCR).unwrap(), BDCR_LSEON | BDCR_LSEBYP);
    }

    #[test]
    fn reset_flags_add_up_until_removed() {
        let mut rcc = Rcc::new(Model::shipped("pyboard-v11"));
        rcc.reset(ResetCause::Software);
        assert_eq!(rcc.read(at_us(0), CSR).unwrap(), 0x1E00_0000);
        rcc.write(at_us(0), CSR, CSR_RMVF).unwrap();
        rcc.reset(ResetCause::Software);
        assert_eq!(rcc.read(at_us(0), CSR).unwrap(), 0x1400_0000);
        rcc.write(at_us(0), CSR, CSR_RMVF).unwrap();
        rcc.reset(ResetCause::Watchdog);
        // IWDGRSTF and PINRSTF (RM0090 7.3.21).
        assert_eq!(rcc.read(at_us(0), CSR).unwrap(), 0x2400_0000);
        rcc.reset(ResetCause::BrownOut);
        // BORRSTF and PINRSTF, no PORRSTF.
        assert_eq!(rcc.read(at_us(0), CSR).unwrap(), 0x0600_0000);
    }
}
