//! What stands between a core and its flash: wait states, prefetch, instruction cache, data cache.
//!
//! RM0090 3.5 ("Adaptive real-time memory accelerator") and RM0390 3.4, as FLASH_ACR sets it. Time is counted per access:
//!
//! * The flash gives a line of 128 bits. A read takes LATENCY + 1 cycles and is never broken off; one read at a time.
//! * Instructions in the line in use cost nothing. With PRFTEN the next line is read ahead as soon as a line is in use;
//!   a core that comes before it is there waits for the rest.
//! * With ICEN a line that is neither in use nor read ahead is looked for in 64 lines, the least recently used of which
//!   it replaces when it is not found. Lines that were read ahead are not kept, as the manual says.
//! * With DCEN loads (literals, constants) find 8 lines in the same way. Without it each load reads the flash.
//! * Vectors come over the instruction bus while the core stacks its registers, so they cost nothing and use a line.
//!
//! An erase leaves both caches as they are and programming leaves the instruction cache as it is: until it is reset, such
//! a line shows what the flash held before. A line of the data cache takes what the core stores to flash. Until that cache is
//! reset, it shows the stored bits, which the flash itself may not have taken. A reset of the chip empties both.
//!
//! The model is on the slow side of a real part: the core's own fetch of some halfwords ahead hides none of the
//! cycles, and each halfword of an unaligned load reads anew while the data cache is off. The order of two accesses in
//! one instruction is kept, their distance is not. The line in use and the line read ahead are never stale.

mod cache;
#[cfg(test)]
mod tests;

use std::ops::Range;

use cache::Cache;

/// Bytes of a line.
pub(crate) const LINE: u32 = 16;
/// No line of any flash.
const NO_LINE: u32 = u32::MAX;

/// FLASH_ACR: LATENCY, PRFTEN, ICEN, DCEN, ICRST, DCRST.
pub(crate) const LATENCY: u32 = 0xF;
pub(crate) const PRFTEN: u32 = 1 << 8;
pub(crate) const ICEN: u32 = 1 << 9;
pub(crate) const DCEN: u32 = 1 << 10;
pub(crate) const ICRST: u32 = 1 << 11;
pub(crate) const DCRST: u32 = 1 << 12;

/// How much time flash takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FlashTiming {
    /// As the program sets it in FLASH_ACR.
    #[default]
    AsSet,
    /// The wait states of FLASH_ACR, prefetch and caches off whatever the program sets.
    Unaccelerated,
    /// No wait states and no caches: ideal memory.
    Ideal,
}

/// What the core reads for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// An instruction.
    Fetch,
    /// A literal or constant.
    Load,
    /// The address of a handler.
    Vector,
}

/// The accelerator of one board.
#[derive(Clone, Debug)]
pub(crate) struct Accelerator {
    timing: FlashTiming,
    /// Cycles that the core had to wait since they were last taken.
    waits: u32,
    /// A cache may hold a line that flash no longer holds.
    is_stale: bool,
    lines: Lines,
}

impl Accelerator {
    /// For a flash of `bytes`, as after a reset.
    pub fn new(timing: FlashTiming, bytes: u32) -> Self {
        Accelerator { timing, waits: 0, is_stale: false, lines: Lines::new(bytes / LINE) }
    }

    /// Counts the core's read at `offset` of flash in an instruction that began at `cycle`.
    #[inline]
    pub fn count(&mut self, purpose: Purpose, offset: u32, cycle: u64) {
        let line = offset / LINE;
        // A further fetch from the line in use costs nothing and changes nothing.
        if purpose == Purpose::Fetch && self.lines.current == line || self.timing == FlashTiming::Ideal {
            return;
        }
        let now = cycle + u64::from(self.waits);
        self.waits += match purpose {
            Purpose::Fetch => self.lines.fetch(now, line),
            Purpose::Vector => {
                self.lines.fetch(now, line);
                0
            }
            Purpose::Load => self.lines.load(now, line),
        };
    }

    /// Counts the core's read at `offset` of flash in an instruction that began at `cycle`. Returns the line that a cache shows in place
    /// of the content of flash.
    pub fn read(&mut self, purpose: Purpose, offset: u32, cycle: u64) -> Option<[u8; LINE as usize]> {
        self.count(purpose, offset, cycle);
        let shows_old = self.is_stale && self.timing != FlashTiming::Ideal;
        shows_old.then(|| self.lines.stale(purpose, offset / LINE)).flatten()
    }

    /// Returns whether a cache may hold a line that flash no longer holds.
    pub fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// Cycles that the core had to wait since the last call.
    #[inline]
    pub fn take_waits(&mut self) -> u32 {
        std::mem::take(&mut self.waits)
    }

    /// FLASH_ACR was written.
    pub fn set(&mut self, acr: u32) {
        self.lines.set(if self.timing == FlashTiming::Unaccelerated { acr & LATENCY } else { acr });
        self.look_for_stale_lines();
    }

    /// A reset of the chip.
    pub fn reset(&mut self) {
        self.lines = Lines::new(self.lines.instructions.flash_lines());
        self.waits = 0;
        self.look_for_stale_lines();
    }

    /// Flash is about to hold `new` instead of `old` at `range`, which is made of whole lines. `stored`: the bytes that the core
    /// stored and where, which the data cache takes as well; `None` for an erase, of which it learns nothing (RM0090 3.6.4).
    pub fn change(&mut self, range: Range<u32>, old: &[u8], new: &[u8], stored: Option<(u32, &[u8])>) {
        self.lines.instructions.keep(&range, old);
        match stored {
            Some(stored) => self.lines.data.write_through(&range, old, new, stored),
            None => self.lines.data.keep(&range, old),
        }
        self.look_for_stale_lines();
    }

    fn look_for_stale_lines(&mut self) {
        self.is_stale = self.lines.instructions.is_stale() || self.lines.data.is_stale();
    }
}

/// Lines of flash and when they are there.
#[derive(Clone, Debug)]
struct Lines {
    acr: u32,
    instructions: Cache<64>,
    data: Cache<8>,
    /// The instruction line in use.
    current: u32,
    /// The line read ahead, and the first cycle in which it costs nothing.
    ahead: (u32, u64),
    /// The first cycle in which flash can have another line ready.
    next: u64,
}

impl Lines {
    fn new(flash_lines: u32) -> Self {
        let (instructions, data) = (Cache::new(flash_lines), Cache::new(flash_lines));
        Lines { acr: 0, instructions, data, current: NO_LINE, ahead: (NO_LINE, 0), next: 0 }
    }

    fn set(&mut self, acr: u32) {
        self.acr = acr;
        if acr & ICRST != 0 {
            self.instructions.clear();
        }
        if acr & DCRST != 0 {
            self.data.clear();
        }
        // What the core asks for next is looked up by the new rules.
        (self.current, self.ahead) = (NO_LINE, (NO_LINE, 0));
    }

    fn is_on(&self, bit: u32) -> bool {
        self.acr & bit != 0
    }

    /// The core needs an instruction at `now`: cycles that it waits.
    fn fetch(&mut self, now: u64, line: u32) -> u32 {
        let waits = if self.is_on(ICEN) && self.instructions.find(line) {
            0
        } else if self.ahead.0 == line {
            self.ahead.1.saturating_sub(now) as u32
        } else {
            if self.is_on(ICEN) {
                self.instructions.insert(line);
            }
            self.read(now)
        };
        self.current = line;
        self.ahead = (NO_LINE, 0);
        let next = line + 1;
        if self.is_on(PRFTEN) && !(self.is_on(ICEN) && self.instructions.holds(next)) {
            let ready = self.deliver(now + u64::from(waits) + self.span());
            self.ahead = (next, ready);
        }
        waits
    }

    /// The core needs a literal or constant at `now`: cycles that it waits.
    fn load(&mut self, now: u64, line: u32) -> u32 {
        if self.is_on(DCEN) {
            if self.data.find(line) {
                return 0;
            }
            self.data.insert(line);
        }
        self.read(now)
    }

    /// Cycles that a read takes.
    fn span(&self) -> u64 {
        u64::from(self.acr & LATENCY) + 1
    }

    /// A read that the core waits for.
    fn read(&mut self, now: u64) -> u32 {
        let ready = self.deliver(now + self.span() - 1);
        (ready - now) as u32
    }

    /// The cycle in which flash has a line ready that it could have at `earliest`.
    fn deliver(&mut self, earliest: u64) -> u64 {
        let ready = self.next.max(earliest);
        self.next = ready + self.span();
        ready
    }

    fn stale(&self, access: Purpose, line: u32) -> Option<[u8; LINE as usize]> {
        match access {
            Purpose::Load if self.is_on(DCEN) => self.data.stale(line),
            Purpose::Fetch | Purpose::Vector if self.is_on(ICEN) => self.instructions.stale(line),
            _ => None,
        }
    }
}
