//! Producer of SYNC (objects 1005h, 1006h, 1019h).

use super::objects::{COB_ID, CYCLE_PERIOD, OVERFLOW, SyncObjects};
use crate::od::CobIdEntry;
use crate::types::{Address, CobId, Duration, Frame, Instant, Periodic};

/// How SYNC is produced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// COB-ID.
    pub id: CobId,
    /// Communication cycle period; zero: not produced.
    pub period: Duration,
    /// The counter goes from 1 to this value; zero: no counter.
    pub overflow: u8,
}

impl Config {
    /// From the values of 1005h (which says whether SYNC is produced), 1006h (microseconds) and 1019h.
    pub const fn new(cob_id: u32, period: u32, overflow: u8) -> Config {
        let entry = CobIdEntry::from_raw(cob_id);
        let period = if entry.flag() { Duration::from_micros(period as u64) } else { Duration::ZERO };
        Config { id: entry.id(), period, overflow }
    }
}

/// The producer. It runs in Pre-operational and Operational.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Producer {
    config: Config,
    timer: Periodic,
    running: bool,
    /// That of the last SYNC.
    counter: u8,
}

impl Producer {
    /// Silent until started.
    pub const fn with(config: Config) -> Self {
        Producer { config, timer: Periodic::new(config.period), running: false, counter: 0 }
    }

    /// Its production begins, or begins anew: the first SYNC is due a period from now and has counter 1.
    pub fn start(&mut self, now: Instant) {
        self.running = true;
        self.counter = 0;
        self.timer.restart(now);
    }

    /// New values of 1005h, 1006h or 1019h. The next SYNC is due a new period from now; the counter goes on when only
    /// the period changed, and begins anew otherwise.
    pub fn configure(&mut self, config: Config, now: Instant) {
        if config == self.config {
            return;
        }
        let period = config.period;
        let goes_on = self.config.period > Duration::ZERO && Config { period, ..self.config } == config;
        if !goes_on {
            self.counter = 0;
        }
        self.config = config;
        self.timer = Periodic::new(period);
        if self.running {
            self.timer.restart(now);
        }
    }

    /// Follows its objects when one that it depends on was written.
    pub fn follow(&mut self, at: Address, objects: &SyncObjects, now: Instant) {
        if matches!(at.index, COB_ID | CYCLE_PERIOD | OVERFLOW) {
            self.configure(objects.config(), now);
        }
    }

    /// Its COB-ID.
    pub const fn id(&self) -> CobId {
        self.config.id
    }

    /// The SYNC, when it is due.
    pub fn poll(&mut self, now: Instant) -> Option<Frame> {
        if !self.timer.due(now) {
            return None;
        }
        let Config { id, overflow, .. } = self.config;
        if overflow == 0 {
            return Some(Frame::of(id, []));
        }
        self.counter = if self.counter < overflow { self.counter.saturating_add(1) } else { 1 };
        Some(Frame::of(id, [self.counter]))
    }

    /// When the next one is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline()
    }
}
