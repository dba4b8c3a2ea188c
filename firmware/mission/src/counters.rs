//! What the applications of the mission count, for a debugger or an emulator.

use ecss_can::runner::Tally;

/// Counters of an application: 32-bit words in the order below, little-endian.
#[repr(C)]
#[derive(Debug)]
pub struct Counters {
    /// Commands sent (master) or executed (slave).
    pub commands: Tally,
    /// Telemetry requests sent (master) or answered (slave).
    pub requests: Tally,
    /// Telemetry replies received (master).
    pub replies: Tally,
    /// Turns of slaves that were left out because the application was late (master).
    pub skipped_turns: Tally,
    /// Commands dropped as repeats of the last one (slave).
    pub repeats: Tally,
}

/// Counters of this image. Readers find them by this path in the symbols of its ELF file: `mission::counters::COUNTERS`.
#[used] // keeps it whole and in memory
pub static COUNTERS: Counters = Counters {
    commands: Tally::new(),
    requests: Tally::new(),
    replies: Tally::new(),
    skipped_turns: Tally::new(),
    repeats: Tally::new(),
};
