//! Counters that a debugger or an emulator reads in a running image, without stopping it.

use portable_atomic::{AtomicU32, Ordering};

use crate::link::Miss;
use crate::types::Bus;

/// Block of counters with a fixed layout: 32-bit words in the order below, little-endian.
///
/// An image exports one as the symbol `DIAGNOSTICS`. Counters of an application are in a `static` of [`Tally`]s of its
/// own.
#[repr(C)]
#[derive(Debug)]
pub struct Diagnostics {
    magic: AtomicU32,
    handled_nominal: Tally,
    handled_redundant: Tally,
    overruns: Tally,
    app_overflows: Tally,
    /// Interrupts of both controllers.
    pub interrupts: Interrupts,
    /// Results of stamps that were to be measured in hardware.
    pub stamps: Stamps,
}

/// Number of interrupts of each kind.
#[repr(C)]
#[derive(Debug)]
pub struct Interrupts {
    /// Interrupts for results of transmissions.
    pub transmit: Tally,
    /// Interrupts for received frames.
    pub receive: Tally,
    /// Interrupts for changes of the error state.
    pub error: Tally,
}

/// Results of stamps that were to be measured in hardware, on both buses.
#[repr(C)]
#[derive(Debug)]
pub struct Stamps {
    captured: Tally,
    silent: Tally,
    mismatched: Tally,
    late: Tally,
    ambiguous: Tally,
    last: AtomicU32,
}

impl Stamps {
    const fn new() -> Self {
        Stamps {
            captured: Tally::new(),
            silent: Tally::new(),
            mismatched: Tally::new(),
            late: Tally::new(),
            ambiguous: Tally::new(),
            last: AtomicU32::new(0),
        }
    }

    /// Counts a stamp, given by the low word of its timer, or the reason why there is none.
    pub fn note(&self, result: Result<u32, Miss>) {
        match result {
            Ok(low) => {
                // Whoever sees the count sees the stamp.
                self.last.store(low, Ordering::Relaxed);
                self.captured.count();
            }
            Err(Miss::Silent) => self.silent.count(),
            Err(Miss::Mismatch) => self.mismatched.count(),
            Err(Miss::Late) => self.late.count(),
            Err(Miss::Ambiguous) => self.ambiguous.count(),
        }
    }
}

/// Counter that only rises. It wraps at 2^32.
#[repr(transparent)]
#[derive(Debug, Default)]
pub struct Tally(AtomicU32);

impl Tally {
    /// Makes a counter at zero.
    pub const fn new() -> Self {
        Tally(AtomicU32::new(0))
    }

    /// Adds one to the counter.
    pub fn count(&self) {
        self.add(1);
    }

    /// Adds `n` to the counter.
    pub fn add(&self, n: u32) {
        self.0.fetch_add(n, Ordering::Relaxed);
    }

    /// Returns the present count.
    pub fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

impl Diagnostics {
    /// First word: `"ECAN"` in ASCII, little-endian.
    pub(crate) const MAGIC: u32 = u32::from_le_bytes(*b"ECAN");

    /// Makes a block in which all counters are zero.
    pub const fn new() -> Self {
        Diagnostics {
            magic: AtomicU32::new(Self::MAGIC),
            handled_nominal: Tally::new(),
            handled_redundant: Tally::new(),
            overruns: Tally::new(),
            app_overflows: Tally::new(),
            interrupts: Interrupts { transmit: Tally::new(), receive: Tally::new(), error: Tally::new() },
            stamps: Stamps::new(),
        }
    }

    /// Returns the counter of frames of this bus that the node handled.
    pub fn handled(&self, bus: Bus) -> &Tally {
        match bus {
            Bus::Nominal => &self.handled_nominal,
            Bus::Redundant => &self.handled_redundant,
        }
    }

    /// Returns the counter of received frames that the port lost.
    pub fn overruns(&self) -> &Tally {
        &self.overruns
    }

    /// Returns the counter of events that the application lost because it was too slow.
    pub fn app_overflows(&self) -> &Tally {
        &self.app_overflows
    }
}

impl Default for Diagnostics {
    fn default() -> Self {
        Self::new()
    }
}
