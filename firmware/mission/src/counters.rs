//! Counters of the applications of the mission, for the log, a debugger or an emulator.

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
    /// Turns of slaves that were skipped because the application was late (master).
    pub skipped_turns: Tally,
    /// Commands dropped as repeats of the last one (slave).
    pub repeats: Tally,
    /// Heartbeats of the master that were heard (slave).
    pub heartbeats: Tally,
    /// SYNCs sent (master) or heard (slave).
    pub syncs: Tally,
    /// Spacecraft times heard (slave).
    pub times: Tally,
}

/// Number of heartbeats of the master (slave) or SYNCs (master) between two logs of the statistics.
#[cfg(feature = "defmt")]
const LOGGED_EVERY: u32 = 100;

impl Counters {
    /// Counts a heartbeat of the master that a slave received. Logs the statistics at every hundredth.
    pub fn on_heartbeat(&self) {
        self.heartbeats.count();
        #[cfg(feature = "defmt")]
        if self.heartbeats.get().is_multiple_of(LOGGED_EVERY) {
            defmt::info!(
                "heard {=u32} heartbeats, {=u32} SYNC, {=u32} spacecraft times; {=u32} commands, {=u32} repeats, {=u32} requests",
                self.heartbeats.get(),
                self.syncs.get(),
                self.times.get(),
                self.commands.get(),
                self.repeats.get(),
                self.requests.get()
            );
        }
    }

    /// Counts a SYNC that the master sent. Logs the statistics at every hundredth.
    pub fn on_sync_sent(&self) {
        self.syncs.count();
        #[cfg(feature = "defmt")]
        if self.syncs.get().is_multiple_of(LOGGED_EVERY) {
            defmt::info!(
                "sent {=u32} SYNC, {=u32} commands, {=u32} requests, {=u32} replies; {=u32} turns left out",
                self.syncs.get(),
                self.commands.get(),
                self.requests.get(),
                self.replies.get(),
                self.skipped_turns.get()
            );
        }
    }
}

/// Counters of this image. Readers find them by this path in the symbols of its ELF file: `mission::counters::COUNTERS`.
#[used] // keeps it whole and in memory
pub static COUNTERS: Counters = Counters {
    commands: Tally::new(),
    requests: Tally::new(),
    replies: Tally::new(),
    skipped_turns: Tally::new(),
    repeats: Tally::new(),
    heartbeats: Tally::new(),
    syncs: Tally::new(),
    times: Tally::new(),
};
