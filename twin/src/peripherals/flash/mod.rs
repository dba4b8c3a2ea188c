//! FLASH: the interface in front of the program memory, which programs and erases it.
//!
//! RM0090 chapter 3. Modelled: the keys, programming at x8, x16 and x32, sector erase, write protection, flags and
//! interrupt, option bytes. Not modelled, and refused: mass erase, x64. The effect of ACR on reads is in
//! [`accelerator`](crate::accelerator). The content is in the core's memory; the board changes it when an operation
//! ends.

mod geometry;
mod options;
#[cfg(test)]
mod tests;
mod upset;

use std::ops::Range;

pub use geometry::FlashSpeed;
use options::Options;

use crate::accelerator::{DCEN, DCRST, ICEN, ICRST, LATENCY};
use crate::mmio::{Refusal, Width};
use crate::part::{Family, Part};
use crate::wire::time::Time;

pub const ACR: u32 = 0x00;
const KEYR: u32 = 0x04;
const OPTKEYR: u32 = 0x08;
const SR: u32 = 0x0C;
const CR: u32 = 0x10;
const OPTCR: u32 = 0x14;

/// Each cache may be reset only while it is off.
const CACHES: [(u32, u32); 2] = [(ICEN, ICRST), (DCEN, DCRST)];
const ACR_BITS: u32 = 0x1F0F;

const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

const EOP: u32 = 1 << 0;
const OPERR: u32 = 1 << 1;
const WRPERR: u32 = 1 << 4;
const PGAERR: u32 = 1 << 5;
const PGPERR: u32 = 1 << 6;
const PGSERR: u32 = 1 << 7;
const BSY: u32 = 1 << 16;
/// Flags that are cleared by writing one.
const SR_FLAGS: u32 = EOP | OPERR | 0xF << 4;

const PG: u32 = 1 << 0;
const SER: u32 = 1 << 1;
const MER: u32 = 1 << 2;
/// In parts with a second bank: fifth bit of SNB, mass erase of that bank.
const SNB4: u32 = 1 << 7;
const MER1: u32 = 1 << 15;
const STRT: u32 = 1 << 16;
const EOPIE: u32 = 1 << 24;
const ERRIE: u32 = 1 << 25;
const LOCK: u32 = 1 << 31;
const CR_BITS: u32 = PG | SER | MER | 0xF << 3 | 0b11 << 8 | EOPIE | ERRIE | LOCK;

/// Change of the content by an operation, with offsets from 0800 0000h.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// Clears the bits that are zero in `value`.
    Program {
        /// First byte.
        offset: u32,
        /// Width of the access.
        width: Width,
        /// The bits.
        value: u32,
    },
    /// Sets all bits to one.
    Erase(Range<u32>),
    /// Programs the option bytes from OPTCR; the memory does not change.
    Options,
}

impl Change {
    /// Returns the range of the bytes that change.
    pub fn range(&self) -> Range<u32> {
        match self {
            Change::Program { offset, width, .. } => *offset..*offset + width.bytes(),
            Change::Erase(range) => range.clone(),
            Change::Options => 0..0,
        }
    }

    /// Changes the content.
    pub fn apply(&self, content: &mut [u8]) {
        match self {
            Change::Program { value, .. } => {
                content.iter_mut().zip(value.to_le_bytes()).for_each(|(byte, new)| *byte &= new);
            }
            Change::Erase(_) => content.fill(0xFF),
            Change::Options => {}
        }
    }
}

/// State of a lock and its key register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Keys {
    /// Waits for the first key.
    Locked,
    /// Waits for the second.
    Half,
    Unlocked,
    /// A wrong key was written: locked until the next reset.
    Shut,
}

impl Keys {
    /// Writes a key. Any sequence other than the two keys in order is a bus error and locks until reset (RM0090 3.6.1).
    fn turn(&mut self, keys: [u32; 2], key: u32) -> Result<(), Refusal> {
        *self = match *self {
            Keys::Locked if key == keys[0] => Keys::Half,
            Keys::Half if key == keys[1] => Keys::Unlocked,
            _ => Keys::Shut,
        };
        if *self == Keys::Shut { Err(Refusal::Misuse) } else { Ok(()) }
    }
}

/// The registers and the operation in progress.
#[derive(Clone, Debug)]
pub struct Flash {
    part: Part,
    /// Times of operations that start from now on.
    pub speed: FlashSpeed,
    pub acr: u32,
    /// ACR was written since it was last taken.
    acr_written: bool,
    sr: u32,
    cr: u32,
    keys: Keys,
    options: Options,
    operation: Option<(Change, Time)>,
}

impl Flash {
    /// After a reset.
    pub fn new(part: Part, speed: FlashSpeed) -> Self {
        Flash {
            part,
            speed,
            acr: 0,
            acr_written: false,
            sr: 0,
            cr: 0,
            keys: Keys::Locked,
            options: Options::default(),
            operation: None,
        }
    }

    /// Resets the registers, for any reset of the chip.
    pub fn reset(&mut self) {
        let mut options = self.options.clone();
        options.reset();
        *self = Flash { options, ..Flash::new(self.part, self.speed) };
    }

    /// A load; `None` for what is not there.
    pub fn read(&self, offset: u32) -> Option<u32> {
        let erasing = matches!(self.operation, Some((Change::Erase(_), _)));
        Some(match offset {
            ACR => self.acr,
            KEYR | OPTKEYR => 0,
            SR => self.sr | if self.operation.is_some() { BSY } else { 0 },
            CR => self.cr | if self.is_unlocked() { 0 } else { LOCK } | if erasing { STRT } else { 0 },
            OPTCR => self.options.read(matches!(self.operation, Some((Change::Options, _)))),
            _ => return None,
        })
    }

    /// Returns the value of the bytes that a narrow store does not write: zero where writing a one has an effect.
    pub fn kept(&self, offset: u32) -> Option<u32> {
        match offset {
            SR => Some(0),
            CR => self.read(CR).map(|cr| cr & !STRT),
            _ => self.read(offset),
        }
    }

    /// A store.
    ///
    /// # Errors
    /// [`Refusal::Misuse`] for wrong keys, a locked or busy CR and what cannot be erased, [`Refusal::Unmodelled`] for
    /// what is not there.
    pub fn write(&mut self, now: Time, offset: u32, value: u32) -> Result<(), Refusal> {
        match offset {
            ACR if CACHES.iter().any(|&(on, reset)| self.acr & on != 0 && value & reset != 0) => {
                return Err(Refusal::Misuse);
            }
            ACR => (self.acr, self.acr_written) = (value & ACR_BITS, true),
            KEYR => return self.keys.turn(KEYS, value),
            OPTKEYR => return self.options.turn(value),
            SR => self.sr &= !(value & SR_FLAGS),
            CR => return self.write_cr(now, value),
            OPTCR if self.operation.is_some() => return Err(Refusal::Misuse),
            OPTCR => {
                if self.options.write(self.part, value)? {
                    self.operation = Some((Change::Options, now + geometry::options(self.speed)));
                }
            }
            _ => return Err(Refusal::Unmodelled),
        }
        Ok(())
    }

    /// ACR, if it was written since the last call.
    pub fn take_acr(&mut self) -> Option<u32> {
        std::mem::take(&mut self.acr_written).then_some(self.acr)
    }

    /// Returns whether the wait states suffice for `hclk` Hz at 2.7 to 3.6 V (RM0090 table 10, RM0390 table 5).
    pub fn is_fast_enough(&self, hclk: u64) -> bool {
        const STEP: u64 = 30_000_000;
        hclk.div_ceil(STEP) <= u64::from(self.acr & LATENCY) + 1
    }

    fn is_unlocked(&self) -> bool {
        self.keys == Keys::Unlocked
    }

    fn write_cr(&mut self, now: Time, value: u32) -> Result<(), Refusal> {
        // While BSY is set the real bus waits for its end, which no program should rely on.
        if !self.is_unlocked() || self.operation.is_some() {
            return Err(Refusal::Misuse);
        }
        self.cr = value & self.cr_bits() & !LOCK;
        if value & LOCK != 0 {
            self.keys = Keys::Locked;
        }
        if value & STRT != 0 { self.erase(now) } else { Ok(()) }
    }

    /// Bits of CR that the part has (FLASH_CR in RM0090, RM0390, RM0386).
    const fn cr_bits(&self) -> u32 {
        match self.part.family() {
            Family::F405 | Family::F446 => CR_BITS,
            Family::F42x | Family::F469 => CR_BITS | SNB4 | MER1,
        }
    }

    fn psize(&self) -> u32 {
        self.cr >> 8 & 0b11
    }

    fn erase(&mut self, now: Time) -> Result<(), Refusal> {
        match self.cr & (SER | MER | MER1) {
            SER => {}
            bits if bits & SER == 0 && bits != 0 => return Err(Refusal::Unmodelled),
            _ => return Err(Refusal::Misuse),
        }
        // x64 needs a supply on VPP that no board has.
        let number = geometry::sector_by_code(self.cr >> 3 & 0x1F).ok_or(Refusal::Misuse)?;
        let sector = geometry::sector(self.part, number).filter(|_| self.psize() < 3);
        let sector = sector.ok_or(Refusal::Misuse)?;
        if self.options.protects(number) {
            self.fail(WRPERR);
            return Ok(());
        }
        let ends = now + geometry::erase(self.speed, sector.end - sector.start, self.psize());
        self.operation = Some((Change::Erase(sector), ends));
        Ok(())
    }

    /// Stores to the memory itself, at `offset` from 0800 0000h. Wrong sequences, widths and addresses set their flags.
    ///
    /// # Errors
    /// [`Refusal::Misuse`] while the interface is locked or busy: a stray store.
    pub fn program(&mut self, now: Time, offset: u32, width: Width, value: u32) -> Result<(), Refusal> {
        if !self.is_unlocked() || self.operation.is_some() {
            return Err(Refusal::Misuse);
        }
        const ROW: u32 = 16;
        let error = if self.cr & (PG | SER | MER | MER1) != PG {
            PGSERR
        } else if offset / ROW != (offset + width.bytes() - 1) / ROW {
            PGAERR
        } else if width.bytes() != 1 << self.psize() {
            PGPERR
        } else if geometry::sector_of(self.part, offset).is_some_and(|sector| self.options.protects(sector)) {
            WRPERR
        } else {
            self.operation =
                Some((Change::Program { offset, width, value }, now + geometry::program(self.speed)));
            return Ok(());
        };
        self.fail(error);
        Ok(())
    }

    fn fail(&mut self, error: u32) {
        self.sr |= error;
        if self.cr & ERRIE != 0 {
            self.sr |= OPERR;
        }
    }

    /// Sets error flags as left by a debug probe; bits as in SR.
    pub fn leave_errors(&mut self, sr: u32) {
        self.sr |= sr & SR_FLAGS;
    }

    /// Programs the option bytes as a debug probe does; bits as in OPTCR.
    pub fn set_options(&mut self, optcr: u32) {
        self.options.set(optcr);
    }

    /// The option bytes in memory, by their offset from 1FFF C000h.
    pub fn options(&self, offset: u32) -> Option<u32> {
        self.options.memory(offset)
    }

    /// Returns whether the option bytes select a brown-out level, and whether every reset starts the watchdog.
    pub fn watches(&self) -> (bool, bool) {
        (self.options.watches_supply(), self.options.starts_watchdog())
    }

    /// The operation under way, and when it ends.
    pub fn operation(&self) -> Option<&(Change, Time)> {
        self.operation.as_ref()
    }

    /// Ends the operation in progress and returns its change. A change of option bytes takes effect only if it is
    /// `complete`.
    pub fn finish(&mut self, complete: bool) -> Option<Change> {
        let (change, _) = self.operation.take()?;
        if complete && change == Change::Options {
            self.options.program();
        }
        if self.cr & EOPIE != 0 {
            self.sr |= EOP;
        }
        Some(change)
    }

    /// Returns the interrupt line. EOP and OPERR are set only if they are enabled.
    pub fn irq(&self) -> bool {
        self.sr & EOP != 0 && self.cr & EOPIE != 0 || self.sr & OPERR != 0 && self.cr & ERRIE != 0
    }
}
