//! Option bytes: BOR level, watchdog of hardware, protections (RM0090 3.7, RM0390 3.5).
//!
//! OPTCR has them as they were loaded by the last reset or programmed since; a store changes OPTCR alone until OPTSTRT
//! programs it. Their time is not published: it is that of the smallest sector. An interrupted operation leaves the old
//! ones. The effect of read-out protection level 1 on a debugger is not modelled. Leaving level 1 erases the memory and
//! is refused, as is level 2, which cannot be left. The second bank of a part with 2 MiB (OPTCR1), DB1M and BFB2 are
//! refused: no sector of that bank is protected.

use super::geometry::{IN_BANK, sectors};
use super::{Keys, Refusal};
use crate::part::Part;

/// As delivered: no protection of any kind, no brown-out reset, watchdog of software, locked.
const DELIVERED: u32 = 0x0FFF_AAED;
const OPTLOCK: u32 = 1 << 0;
const OPTSTRT: u32 = 1 << 1;
const BOR_OFF: u32 = 0b11;
const WDG_SW: u32 = 1 << 5;
const BITS: u32 = 0x0FFF_FFEC;
const LEVEL_0: u32 = 0xAA;
const LEVEL_2: u32 = 0xCC;

/// The option bytes and their registers.
#[derive(Clone, Debug)]
pub(super) struct Options {
    /// Content of the memory, bits as in OPTCR.
    stored: u32,
    optcr: u32,
    keys: Keys,
}

impl Default for Options {
    fn default() -> Self {
        Options { stored: DELIVERED & BITS, optcr: DELIVERED & BITS, keys: Keys::Locked }
    }
}

impl Options {
    /// Loads the option bytes, at a reset.
    pub fn reset(&mut self) {
        (self.optcr, self.keys) = (self.stored, Keys::Locked);
    }

    /// Programs the option bytes as a debug probe does.
    pub fn set(&mut self, optcr: u32) {
        self.stored = optcr & BITS;
        self.optcr = self.stored;
    }

    /// Stores to OPTKEYR.
    pub fn turn(&mut self, key: u32) -> Result<(), Refusal> {
        const KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
        self.keys.turn(KEYS, key)
    }

    /// OPTCR.
    pub fn read(&self, is_busy: bool) -> u32 {
        let lock = if self.keys == Keys::Unlocked { 0 } else { OPTLOCK };
        self.optcr | lock | if is_busy { OPTSTRT } else { 0 }
    }

    /// Stores to OPTCR. Returns whether it starts the programming.
    pub fn write(&mut self, part: Part, value: u32) -> Result<bool, Refusal> {
        if self.keys != Keys::Unlocked {
            return Err(Refusal::Misuse);
        }
        let sectors = ((1 << sectors(part).min(IN_BANK)) - 1) << 16;
        // SPRMOD, DB1M, BFB2, and the bits of sectors that the part lacks.
        if value & !(BITS | OPTLOCK | OPTSTRT) != 0 || !value & (BITS & 0x0FFF_0000) & !sectors != 0 {
            return Err(Refusal::Unmodelled);
        }
        self.optcr = value & BITS;
        if value & OPTLOCK != 0 {
            self.keys = Keys::Locked;
        }
        if value & OPTSTRT == 0 {
            return Ok(false);
        }
        let level = |options: u32| options >> 8 & 0xFF;
        match (level(self.stored), level(self.optcr)) {
            (_, LEVEL_2) => Err(Refusal::Irrevocable),
            (old, LEVEL_0) if old != LEVEL_0 => Err(Refusal::Unmodelled),
            _ => Ok(true),
        }
    }

    /// Completes the programming.
    pub fn program(&mut self) {
        self.stored = self.optcr;
    }

    /// Returns the memory at `offset` from 1FFF C000h: the low half-words, with ones above them.
    pub fn memory(&self, offset: u32) -> Option<u32> {
        // The lowest bits are not used and read 01b (RM0090 table 14).
        match offset {
            0x0 => Some(0xFFFF_0000 | self.stored & 0xFFFC | 1),
            0x8 => Some(0xFFFF_F000 | self.stored >> 16 & 0xFFF),
            0x4 | 0xC => Some(u32::MAX),
            _ => None,
        }
    }

    /// Returns whether nWRP of a sector is clear.
    pub fn protects(&self, sector: u32) -> bool {
        sector < IN_BANK && self.stored >> (16 + sector) & 1 == 0
    }

    /// Returns whether a brown-out level is selected.
    pub fn watches_supply(&self) -> bool {
        self.stored >> 2 & 0b11 != BOR_OFF
    }

    /// Returns whether every reset starts the watchdog.
    pub fn starts_watchdog(&self) -> bool {
        self.stored & WDG_SW == 0
    }
}
