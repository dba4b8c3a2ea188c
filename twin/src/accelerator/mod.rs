//! Flash accelerator between a core and its flash: wait states, prefetch, instruction cache, data cache.
//!
//! RM0090 3.5 ("Adaptive real-time memory accelerator") and RM0390 3.4, as FLASH_ACR sets it. Time is counted per access:
//!
//! * The flash gives a line of 128 bits. A read takes LATENCY + 1 cycles and is never interrupted. There is one read at
//!   a time.
//! * Instructions in the line in use cost nothing. With PRFTEN the next line is prefetched as soon as a line is in use.
//!   A core that needs it earlier waits for the rest of the read.
//! * With ICEN a line that is neither in use nor prefetched is looked up in a cache of 64 lines. If it is missing, it
//!   replaces the least recently used line. Prefetched lines are not cached, as the manual says.
//! * With DCEN loads (literals, constants) use a cache of 8 lines in the same way. Without it each load reads the
//!   flash.
//! * Vectors come over the instruction bus while the core stacks its registers, so they cost nothing and use a line.
//!
//! An erase leaves both caches as they are and programming leaves the instruction cache as it is: until it is reset,
//! such a line shows what the flash held before. A line of the data cache takes what the core stores to flash. Until
//! that cache is reset, it shows the stored bits, which may differ from the flash. A reset of the chip empties both
//! caches.
//!
//! The model is on the slow side of a real part: the core's prefetch of some halfwords hides none of the cycles, and
//! each halfword of an unaligned load is read separately while the data cache is off. The order of two accesses in one
//! instruction is modelled, the time between them is not. The line in use and the prefetched line are never stale.

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

/// Timing of flash reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FlashTiming {
    /// As the program configures it in FLASH_ACR.
    #[default]
    AsSet,
    /// The wait states of FLASH_ACR; prefetch and caches are always off.
    Unaccelerated,
    /// No wait states and no caches: ideal memory.
    Ideal,
}

/// Purpose of a read by the core.
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
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Accelerator {
    timing: FlashTiming,
    /// Wait cycles of the core since the last [`Accelerator::take_waits`].
    waits: u32,
    /// A cache may hold a line that differs from flash.
    is_stale: bool,
    lines: Lines,
}

impl Accelerator {
    /// Makes the accelerator of a flash of `bytes`, as after a reset.
    pub fn new(timing: FlashTiming, bytes: u32) -> Self {
        Accelerator { timing, waits: 0, is_stale: false, lines: Lines::new(bytes / LINE) }
    }

    /// Counts a read by the core at `offset` of flash in an instruction that began at `cycle`.
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

    /// Counts a read by the core at `offset` of flash in an instruction that began at `cycle`. Returns the cached line
    /// if it differs from flash.
    pub fn read(&mut self, purpose: Purpose, offset: u32, cycle: u64) -> Option<[u8; LINE as usize]> {
        self.count(purpose, offset, cycle);
        let shows_old = self.is_stale && self.timing != FlashTiming::Ideal;
        shows_old.then(|| self.lines.stale(purpose, offset / LINE)).flatten()
    }

    /// Returns whether a cache may hold a line that differs from flash.
    pub fn is_stale(&self) -> bool {
        self.is_stale
    }

    /// Returns whether another accelerator answers equally from `cycle` on.
    pub fn continues_as(&self, other: &Accelerator, cycle: u64) -> bool {
        (self.timing, self.waits, self.is_stale) == (other.timing, other.waits, other.is_stale)
            && self.lines.continues_as(&other.lines, cycle)
    }

    /// Returns the wait cycles of the core since the last call.
    #[inline]
    pub fn take_waits(&mut self) -> u32 {
        std::mem::take(&mut self.waits)
    }

    /// Handles a write to FLASH_ACR.
    pub fn set(&mut self, acr: u32) {
        self.lines.set(if self.timing == FlashTiming::Unaccelerated { acr & LATENCY } else { acr });
        self.look_for_stale_lines();
    }

    /// Resets the accelerator with the chip.
    pub fn reset(&mut self) {
        self.lines = Lines::new(self.lines.instructions.flash_lines());
        self.waits = 0;
        self.look_for_stale_lines();
    }

    /// Handles a change of flash from `old` to `new` at `range`, which consists of whole lines. `stored`: bytes and
    /// offset of a store by the core, which also updates the data cache. `None` for an erase, which does not (RM0090
    /// 3.6.4).
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

/// Instruction lines read from flash, and when they are available.
#[derive(Clone, Debug, PartialEq)]
struct Lines {
    acr: u32,
    instructions: Cache<64>,
    data: Cache<8>,
    /// The instruction line in use.
    current: u32,
    /// The prefetched line, and the first cycle in which it costs nothing.
    ahead: (u32, u64),
    /// The first cycle in which flash can deliver another line.
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
        // The next access is looked up with the new settings.
        (self.current, self.ahead) = (NO_LINE, (NO_LINE, 0));
    }

    /// An instant that has passed is as good as the present.
    fn continues_as(&self, other: &Lines, cycle: u64) -> bool {
        let timing = |lines: &Lines| {
            let (ahead, ready) = lines.ahead;
            (lines.acr, lines.current, ahead, ready.max(cycle), lines.next.max(cycle))
        };
        timing(self) == timing(other)
            && self.instructions.continues_as(&other.instructions)
            && self.data.continues_as(&other.data)
    }

    fn is_on(&self, bit: u32) -> bool {
        self.acr & bit != 0
    }

    /// Fetches an instruction at `now`. Returns the wait cycles.
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

    /// Loads a literal or constant at `now`. Returns the wait cycles.
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

    /// Reads a line while the core waits. Returns the wait cycles.
    fn read(&mut self, now: u64) -> u32 {
        let ready = self.deliver(now + self.span() - 1);
        (ready - now) as u32
    }

    /// Returns the cycle in which flash delivers a line, `earliest` or later.
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
