//! Producer of SYNC (objects 1005h, 1006h, 1019h), with dither.
//!
//! Times have a quantum. SYNCs that are a whole number of quanta apart all meet the same part of it, and then no consumer can
//! average its error away. A random delay of each SYNC spreads them over the quantum.

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
    /// Each SYNC is late by at most this, microseconds.
    dither: u16,
    /// By how much the next one is late.
    late: Duration,
    random: Random,
}

/// A sequence of random numbers: Marsaglia, *Xorshift RNGs*, 2003.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Random(u32);

impl Random {
    /// `0..=most`.
    fn at_most(&mut self, most: u16) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        // Of its upper half, whose bits are the better ones.
        (u64::from(self.0 >> 16) * (u64::from(most) + 1)) >> 16
    }
}

impl Producer {
    /// Silent until started.
    pub const fn with(config: Config) -> Self {
        let timer = Periodic::new(config.period);
        Producer {
            config,
            timer,
            running: false,
            counter: 0,
            dither: 0,
            late: Duration::ZERO,
            random: Random(1),
        }
    }

    /// From now on each SYNC is late by a random whole number of microseconds, `0..=most`, on the grid of its period: being late
    /// does not shift what follows. At most half of the period.
    pub fn set_dither(&mut self, most: u16) {
        self.dither = most;
        self.late = Duration::ZERO;
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
        if self.deadline().is_none_or(|due| now < due) {
            return None;
        }
        self.timer.due(now);
        let Config { id, period, overflow } = self.config;
        if self.dither > 0 {
            let late = self.random.at_most(self.dither).min(period.as_micros() / 2);
            self.late = Duration::from_micros(late);
        }
        if overflow == 0 {
            return Some(Frame::of(id, []));
        }
        self.counter = if self.counter < overflow { self.counter.saturating_add(1) } else { 1 };
        Some(Frame::of(id, [self.counter]))
    }

    /// When the next one is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline().map(|due| due + self.late)
    }
}
