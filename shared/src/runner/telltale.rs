//! Counters that a debugger or an emulator reads in a running image, without stopping it.

use core::sync::atomic::{AtomicU32, Ordering};

use crate::link::Miss;
use crate::types::Bus;

/// A block of counters at a fixed, documented layout: 32-bit words in the order below, little-endian.
///
/// An image exports one as the symbol `TELLTALE`. What an application counts is its own part, in a `static` of [`Tally`]s.
#[repr(C)]
#[derive(Debug)]
pub struct Telltale {
    magic: AtomicU32,
    handled_nominal: Tally,
    handled_redundant: Tally,
    overruns: Tally,
    app_overflows: Tally,
    /// Interrupts of both controllers.
    pub interrupts: Interrupts,
    /// Stamps that were to be measured in hardware.
    pub stamps: Stamps,
}

/// Interrupts by their kind: how often a controller called.
#[repr(C)]
#[derive(Debug)]
pub struct Interrupts {
    /// Results of transmissions.
    pub transmit: Tally,
    /// Received frames.
    pub receive: Tally,
    /// Changes of the error state.
    pub error: Tally,
}

/// What became of stamps that were to be measured in hardware, on both buses.
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

    /// Counts a stamp, by the low word of its timer, or why there is none.
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

/// A counter that only rises; it wraps at 2^32.
#[repr(transparent)]
#[derive(Debug, Default)]
pub struct Tally(AtomicU32);

impl Tally {
    /// Zero.
    pub const fn new() -> Self {
        Tally(AtomicU32::new(0))
    }

    /// Counts one more.
    pub fn count(&self) {
        self.add(1);
    }

    /// Counts `n` more.
    pub fn add(&self, n: u32) {
        self.0.fetch_add(n, Ordering::Relaxed);
    }

    /// The count.
    pub fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

impl Telltale {
    /// First word: `"ECAN"` in ASCII, little-endian.
    pub const MAGIC: u32 = u32::from_le_bytes(*b"ECAN");

    /// All zero.
    pub const fn new() -> Self {
        Telltale {
            magic: AtomicU32::new(Self::MAGIC),
            handled_nominal: Tally::new(),
            handled_redundant: Tally::new(),
            overruns: Tally::new(),
            app_overflows: Tally::new(),
            interrupts: Interrupts { transmit: Tally::new(), receive: Tally::new(), error: Tally::new() },
            stamps: Stamps::new(),
        }
    }

    /// Frames of this bus that the node has dealt with.
    pub fn handled(&self, bus: Bus) -> &Tally {
        match bus {
            Bus::Nominal => &self.handled_nominal,
            Bus::Redundant => &self.handled_redundant,
        }
    }

    /// Received frames lost in the port.
    pub fn overruns(&self) -> &Tally {
        &self.overruns
    }

    /// Events the application was too slow to take.
    pub fn app_overflows(&self) -> &Tally {
        &self.app_overflows
    }
}

impl Default for Telltale {
    fn default() -> Self {
        Self::new()
    }
}
