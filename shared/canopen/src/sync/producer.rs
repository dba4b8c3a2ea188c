//! Producer of SYNC (objects 1005h, 1006h, 1019h), with dither.
//!
//! Time stamps have a quantum. SYNCs that are a whole number of quanta apart all fall on the same part of it. Then
//! no consumer can average its error. A random delay of each SYNC, the *dither*, spreads the SYNCs over the
//! quantum.

use super::Config;
use super::objects::{COB_ID, CYCLE_PERIOD, OVERFLOW, SyncObjects};
use crate::types::{Address, Duration, Frame, Instant, Periodic};

/// Producer of SYNC. It runs in Pre-operational and Operational.
#[doc(alias("1005h", "1006h", "1019h", "SYNC producer", "communication cycle period"))]
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
    /// Delay of the next SYNC, microseconds.
    late: u16,
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
    /// Makes a producer that is silent until it is started.
    pub const fn with(config: Config) -> Self {
        let timer = Periodic::new(config.period);
        Producer { config, timer, running: false, counter: 0, dither: 0, late: 0, random: Random(1) }
    }

    /// Sets the dither: from now on each SYNC is late by a random whole number of microseconds, `0..=most`, at
    /// most half of the period. The grid of the period does not move.
    pub fn set_dither(&mut self, most: u16) {
        self.dither = most;
        self.late = 0;
    }

    /// Starts the production, or starts it again. The first SYNC is due a period from `now` and has counter 1.
    pub fn start(&mut self, now: Instant) {
        self.running = true;
        self.counter = 0;
        self.timer.restart(now);
    }

    /// Starts the counter again: the next SYNC has counter 1. CiA 301 7.2.5.2 requires this when the producer leaves
    /// Stopped.
    pub fn restart_counter(&mut self) {
        self.counter = 0;
    }

    /// Takes new values of 1005h, 1006h or 1019h. The next SYNC is due a new period from `now`. The counter
    /// continues if only the period changed. Otherwise it starts again.
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

    /// Returns whether the producer was not started, or the values in use are those of the objects. They are not if a bit has flipped.
    pub fn agrees(&self, objects: &SyncObjects) -> bool {
        let config = objects.config();
        !self.running || (self.config == config && self.timer.period() == config.period)
    }

    /// Takes the values of the objects again. The next SYNC is due a period from `now`.
    pub fn restore(&mut self, objects: &SyncObjects, now: Instant) {
        self.config = objects.config();
        self.timer = Periodic::new(self.config.period);
        if self.running {
            self.timer.restart(now);
        }
    }

    /// Takes the new value of an object that was written, if the producer depends on it.
    pub fn follow(&mut self, at: Address, objects: &SyncObjects, now: Instant) {
        if matches!(at.index, COB_ID | CYCLE_PERIOD | OVERFLOW) {
            self.configure(objects.config(), now);
        }
    }

    /// Returns the SYNC when it is due.
    pub fn poll(&mut self, now: Instant) -> Option<Frame> {
        self.timer.confine(now);
        // A flipped bit must not stop it.
        if self.running && self.timer.deadline().is_none() {
            self.timer.restart(now);
        }
        if self.deadline().is_none_or(|due| now < due) {
            return None;
        }
        self.timer.due(now);
        let Config { id, period, overflow } = self.config;
        if self.dither > 0 {
            self.late = self.random.at_most(self.dither).min(period.as_micros() / 2) as u16;
        }
        if overflow == 0 {
            return Some(Frame::of(id, []));
        }
        self.counter = if self.counter < overflow { self.counter.saturating_add(1) } else { 1 };
        Some(Frame::of(id, [self.counter]))
    }

    /// Returns when the next SYNC is due.
    pub fn deadline(&self) -> Option<Instant> {
        self.timer.deadline().map(|due| due + Duration::from_micros(self.late.into()))
    }

    /// Returns whether the producer was not started, or the next SYNC is due within two periods, or was due less than two
    /// periods ago.
    pub fn is_on_schedule(&self, now: Instant) -> bool {
        !self.running || self.timer.is_on_schedule(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Given a producer of which any bit of a period flips, then it differs from its objects, and sends SYNC at their period once it
    /// has taken them again.
    #[test]
    fn flipped_bit_of_a_period_is_found() {
        let objects = SyncObjects { cob_id: 0x4000_0080, cycle_period: 100_000, ..SyncObjects::default() };
        for bit in 0..64 {
            for is_timer in [false, true] {
                let mut producer = Producer::with(objects.config());
                producer.start(Instant::ZERO);
                assert!(producer.agrees(&objects));
                let flipped = Duration::from_micros(100_000 ^ 1 << bit);
                if is_timer {
                    producer.timer = Periodic::new(flipped);
                } else {
                    producer.config.period = flipped;
                }
                assert!(!producer.agrees(&objects), "bit {bit}");
                producer.restore(&objects, Instant::ZERO);
                assert!(producer.agrees(&objects));
                assert_eq!(producer.deadline(), Some(Instant::from_micros(100_000)), "bit {bit}");
            }
        }
    }
}
