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
//! a line shows what the flash held before. A reset of the chip empties both.
//!
//! The model is on the slow side of a real part: the core's own fetch of some halfwords ahead hides none of the
//! cycles, and each halfword of an unaligned load reads anew while the data cache is off. The order of two accesses in
//! one instruction is kept, their distance is not. The line in use and the line read ahead are never stale.

mod cache;
#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

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

/// The accelerator of one board. One thread uses it; see [`Link`](crate::link::Link).
#[derive(Debug)]
pub(crate) struct Accelerator {
    timing: FlashTiming,
    /// Line of the last fetch: a further one in it costs nothing and changes nothing.
    current: AtomicU32,
    /// Cycles that the core had to wait since they were last taken.
    waits: AtomicU32,
    /// A cache may hold a line that flash no longer holds.
    stale: AtomicBool,
    lines: Mutex<Lines>,
}

impl Accelerator {
    /// For a flash of `bytes`, as after a reset.
    pub fn new(timing: FlashTiming, bytes: u32) -> Self {
        Accelerator {
            timing,
            current: AtomicU32::new(NO_LINE),
            waits: AtomicU32::new(0),
            stale: AtomicBool::new(false),
            lines: Mutex::new(Lines::new(bytes / LINE)),
        }
    }

    fn lines(&self) -> std::sync::MutexGuard<'_, Lines> {
        self.lines.lock().expect("no panic under this lock")
    }

    /// Counts the core's read at `offset` of flash in an instruction that began at `cycle`. The stale bytes of the line,
    /// if a cache answers with such.
    #[inline]
    pub fn read(
        &self,
        access: Purpose,
        offset: u32,
        cycle: impl FnOnce() -> u64,
    ) -> Option<[u8; LINE as usize]> {
        if self.timing == FlashTiming::Ideal {
            return None;
        }
        let line = offset / LINE;
        if access != Purpose::Fetch || self.current.load(Ordering::Relaxed) != line {
            self.count(access, line, cycle());
        }
        if self.stale.load(Ordering::Relaxed) { self.lines().stale(access, line) } else { None }
    }

    /// Returns whether a cache may hold a line that flash no longer holds.
    #[inline]
    pub fn is_stale(&self) -> bool {
        self.stale.load(Ordering::Relaxed)
    }

    fn count(&self, access: Purpose, line: u32, cycle: u64) {
        let so_far = self.waits.load(Ordering::Relaxed);
        let now = cycle + u64::from(so_far);
        let mut lines = self.lines();
        let waited = match access {
            Purpose::Fetch => lines.fetch(now, line),
            Purpose::Vector => {
                lines.fetch(now, line);
                0
            }
            Purpose::Load => lines.load(now, line),
        };
        self.current.store(lines.current, Ordering::Relaxed);
        self.waits.store(so_far + waited, Ordering::Relaxed);
    }

    /// Cycles that the core had to wait since the last call.
    #[inline]
    pub fn take_waits(&self) -> u32 {
        let waits = self.waits.load(Ordering::Relaxed);
        if waits != 0 {
            self.waits.store(0, Ordering::Relaxed);
        }
        waits
    }

    /// FLASH_ACR was written.
    pub fn set(&self, acr: u32) {
        let mut lines = self.lines();
        lines.set(if self.timing == FlashTiming::Unaccelerated { acr & LATENCY } else { acr });
        self.follow(&lines);
    }

    /// A reset of the chip.
    pub fn reset(&self) {
        let mut lines = self.lines();
        *lines = Lines::new(lines.instructions.flash_lines());
        self.waits.store(0, Ordering::Relaxed);
        self.follow(&lines);
    }

    /// Flash is about to hold `new` instead of `old` at `range`, which is made of whole lines. Programming writes through
    /// the data cache, erasing does not (RM0090 3.5.2).
    pub fn change(&self, range: Range<u32>, old: &[u8], new: &[u8], erased: bool) {
        let mut lines = self.lines();
        lines.instructions.keep(&range, old);
        if erased {
            lines.data.keep(&range, old);
        } else {
            lines.data.write_through(&range, old, new);
        }
        self.follow(&lines);
    }

    fn follow(&self, lines: &Lines) {
        self.current.store(lines.current, Ordering::Relaxed);
        self.stale.store(lines.instructions.is_stale() || lines.data.is_stale(), Ordering::Relaxed);
    }
}

/// Lines of flash and when they are there.
#[derive(Debug)]
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
