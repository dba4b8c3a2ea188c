//! The 28 filter banks that both controllers share: RM0090 32.7.4 and 32.9.4.

use super::Side;
use super::regs::{
    BANK_BITS, BANKS, BANKS_END, FA1R, FFA1R, FM1R, FMR, FMR_AT_RESET, FMR_CAN2SB, FMR_FINIT, FS1R,
};
use crate::wire::time::Time;

const BANK_COUNT: usize = 28;

/// Destination of an admitted frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Match {
    /// FIFO 0 or 1.
    pub fifo: usize,
    /// Filter match index: number of the filter among those of its FIFO.
    pub index: u8,
}

/// Identifier of a frame as the filters compare it.
#[derive(Clone, Copy, Debug)]
pub struct FilterKey {
    /// As in RIR: STID 31:21, EXID 20:3, IDE 2, RTR 1.
    pub rir: u32,
}

impl FilterKey {
    /// Identifier as a 16-bit filter sees it: STID 15:5, RTR 4, IDE 3, EXID\[17:15\] 2:0.
    fn half(self) -> u16 {
        let stid = self.rir >> 21 & 0x7FF;
        let rtr = self.rir >> 1 & 1;
        let ide = self.rir >> 2 & 1;
        let exid_top = self.rir >> 18 & 0b111;
        (stid << 5 | rtr << 4 | ide << 3 | exid_top) as u16
    }
}

/// The registers from FMR on.
#[derive(Clone, Debug)]
pub struct FilterBlock {
    pub(super) fmr: u32,
    /// Bit set: identifier list, else mask.
    pub(super) fm1r: u32,
    /// Bit set: one 32-bit scale, else two 16-bit.
    pub(super) fs1r: u32,
    /// Bit set: FIFO 1.
    pub(super) ffa1r: u32,
    /// Bit set: bank active.
    pub(super) fa1r: u32,
    pub(super) banks: [[u32; 2]; BANK_COUNT],
    /// Bit set: the bank was active since this was taken.
    was_active: u32,
    /// Instant at which FINIT was last cleared.
    open_since: Time,
}

impl Default for FilterBlock {
    /// As after reset; the banks, undefined there, are zero here.
    fn default() -> Self {
        FilterBlock {
            fmr: FMR_AT_RESET,
            fm1r: 0,
            fs1r: 0,
            ffa1r: 0,
            fa1r: 0,
            banks: [[0; 2]; BANK_COUNT],
            was_active: 0,
            open_since: Time::ZERO,
        }
    }
}

impl FilterBlock {
    /// Returns the register at `offset`; `None` if there is none.
    pub fn read(&self, offset: u32) -> Option<u32> {
        Some(match offset {
            FMR => self.fmr,
            FM1R => self.fm1r,
            FS1R => self.fs1r,
            FFA1R => self.ffa1r,
            FA1R => self.fa1r,
            BANKS..BANKS_END => {
                let (bank, word) = locate(offset);
                self.banks[bank][word]
            }
            _ => return None,
        })
    }

    /// Writes; `Some(false)` when the hardware ignores the value: mode, scale and assignment change only while FINIT
    /// is set, a bank only then or while it is inactive.
    pub fn write(&mut self, offset: u32, value: u32, now: Time) -> Option<bool> {
        let finit = self.initialising();
        match offset {
            FMR => {
                let writable = FMR_FINIT | FMR_CAN2SB;
                self.fmr = self.fmr & !writable | value & writable;
                if finit && !self.initialising() {
                    self.open_since = now;
                }
                return Some(true);
            }
            FA1R => {
                self.fa1r = value & BANK_BITS;
                self.was_active |= self.fa1r;
                return Some(true);
            }
            FM1R | FS1R | FFA1R if !finit => return Some(false),
            FM1R => self.fm1r = value & BANK_BITS,
            FS1R => self.fs1r = value & BANK_BITS,
            FFA1R => self.ffa1r = value & BANK_BITS,
            BANKS..BANKS_END => {
                let (bank, word) = locate(offset);
                if !finit && self.fa1r >> bank & 1 != 0 {
                    return Some(false);
                }
                self.banks[bank][word] = value;
            }
            _ => return None,
        }
        Some(true)
    }

    /// Returns whether FINIT was clear from `start` on. RM0090 says that FINIT deactivates the reception, but not what
    /// happens to a frame during which it is cleared. In this model the frame is lost, the worst case for a program.
    pub fn admit_from(&self, start: Time) -> bool {
        !self.initialising() && self.open_since <= start
    }

    /// A reset: only the banks that were active are kept in mind.
    pub fn reset(&mut self) {
        *self = FilterBlock { was_active: self.was_active, ..FilterBlock::default() };
    }

    /// Returns the banks that were active since the last call.
    pub fn take_active(&mut self) -> u32 {
        std::mem::replace(&mut self.was_active, self.fa1r) | self.fa1r
    }

    /// Forgets the banks that are not active and for which `is_forgotten` returns true.
    pub fn forget_inactive(&mut self, is_forgotten: impl Fn(u32) -> bool) {
        for (n, bank) in (0..).zip(&mut self.banks) {
            if self.fa1r >> n & 1 == 0 && is_forgotten(n) {
                *bank = [0; 2];
            }
        }
    }

    /// Returns FINIT: no reception on either controller.
    pub fn initialising(&self) -> bool {
        self.fmr & FMR_FINIT != 0
    }

    /// The filter that admits a frame on `side`; `None` when none does.
    ///
    /// Several may match: 32-bit scale goes before 16-bit, list before mask, then the lower number (RM0090 32.7.4,
    /// "Filter priority rules"). Numbers count per FIFO over the banks of that controller, inactive banks included.
    /// The manual does not order equal filters of different FIFOs: here the lower bank wins.
    pub fn admit(&self, side: Side, key: FilterKey) -> Option<Match> {
        if self.initialising() {
            return None;
        }
        let first_of_can2 = ((self.fmr & FMR_CAN2SB) >> 8) as usize;
        let mut numbers = [0u8; 2];
        let mut best: Option<((bool, bool), Match)> = None;
        for bank in 0..BANK_COUNT {
            let owner = if bank < first_of_can2 { Side::Can1 } else { Side::Can2 };
            if owner != side {
                continue;
            }
            let bit = |register: u32| register >> bank & 1 != 0;
            let (list, wide, active) = (bit(self.fm1r), bit(self.fs1r), bit(self.fa1r));
            let fifo = usize::from(bit(self.ffa1r));
            let first = numbers[fifo];
            numbers[fifo] += match (wide, list) {
                (true, false) => 1,
                (true, true) | (false, false) => 2,
                (false, true) => 4,
            };
            let hit = if active { self.compare(bank, wide, list, key) } else { None };
            let rank = (!wide, !list);
            if let Some(within) = hit
                && best.is_none_or(|(so_far, _)| rank < so_far)
            {
                best = Some((rank, Match { fifo, index: first + within }));
            }
        }
        best.map(|(_, found)| found)
    }

    /// Returns the number within the bank of the first filter that matches.
    fn compare(&self, bank: usize, wide: bool, list: bool, key: FilterKey) -> Option<u8> {
        let [r1, r2] = self.banks[bank];
        let half = key.half();
        let (low, high) = (|r: u32| r as u16, |r: u32| (r >> 16) as u16);
        let hits: &[bool] = &match (wide, list) {
            // Bit 0 of a 32-bit filter has no counterpart in a frame.
            (true, true) => [same(r1, key.rir, !1), same(r2, key.rir, !1), false, false],
            (true, false) => [same(r1, key.rir, r2 & !1), false, false, false],
            (false, true) => [low(r1) == half, high(r1) == half, low(r2) == half, high(r2) == half],
            (false, false) => {
                let masked = |r: u32| (low(r) ^ half) & high(r) == 0;
                [masked(r1), masked(r2), false, false]
            }
        };
        hits.iter().position(|&hit| hit).map(|n| n as u8)
    }
}

fn same(filter: u32, identifier: u32, mask: u32) -> bool {
    (filter ^ identifier) & mask == 0
}

fn locate(offset: u32) -> (usize, usize) {
    let word = ((offset - BANKS) / 4) as usize;
    (word / 2, word % 2)
}
