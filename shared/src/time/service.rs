//! The time service of a node: its clock, the SYNCs that steer it, and what clients set and read in parts (ECSS 7.1, 7.2).

use super::clock::STEP_LIMIT;
use super::objects::{ClockQuality, TimeCorrection};
use super::{LocalClock, Step, TimeSource};
use crate::link::{Stamp, StampSource};
use crate::types::{Address, Bus, Duration, FineInstant, FineScet, Instant};

/// A part that was read or written waits so long for the others of its record.
const PATIENCE: Duration = Duration::from_millis(10_000);

/// Times that would step the clock are believed when the next one says the same: is as far off, to 1 ms.
const SAME: u64 = (1 << 32) / 1_000;
/// One that fits the SYNC before the last is late. That many in a row are not: the spacecraft time itself has changed.
const LATE_IN_A_ROW: u8 = 3;

/// Clock of a node and what belongs to it.
#[derive(Clone, Debug, Default)]
pub struct TimeService {
    clock: LocalClock,
    /// The last SYNC on the active bus, and the one before.
    syncs: [Option<SyncEnd>; 2],
    doubt: Doubt,
    /// Spacecraft times that were not used.
    late: u16,
    sample: FineScet,
    read: Parts,
    written: Parts,
    /// How many heartbeats of this node are still to be stamped.
    ranged: u8,
}

/// Each read of 2016h has this number of heartbeats stamped. Who measures a cable reads it after each heartbeat.
const RANGED: u8 = 8;

/// When a SYNC ended.
#[derive(Clone, Copy, Debug)]
struct SyncEnd {
    bus: Bus,
    at: FineInstant,
    source: StampSource,
}

/// Spacecraft times that are far off, one after the other.
#[derive(Clone, Copy, Debug, Default)]
struct Doubt {
    /// How far, units of 2^-32 s.
    off: i64,
    times: u8,
}

/// Parts of a record that are still to come.
#[derive(Clone, Copy, Debug, Default)]
struct Parts {
    index: u16,
    /// A bit for each sub-index.
    left: u8,
    until: Instant,
}

impl Parts {
    /// Takes one of `count` parts. Whether it belongs to those before.
    fn take(&mut self, at: Address, count: u8, now: Instant) -> bool {
        let bit = 1 << (at.sub & 7);
        let belongs = self.index == at.index && self.left & bit != 0 && now < self.until;
        if !belongs {
            // Sub-indices 1 to `count`.
            *self = Parts { index: at.index, left: (2 << count) - 2, until: now + PATIENCE };
        }
        self.left &= !bit;
        belongs
    }
}

/// What became of a spacecraft time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairOutcome {
    /// The clock follows it.
    Steered,
    /// The clock was set to it.
    Stepped(Step),
    /// It is of no SYNC that this node has seen, is late, or does not agree with the others: counted.
    Unused,
}

impl TimeService {
    /// The clock.
    pub const fn clock(&self) -> &LocalClock {
        &self.clock
    }

    /// A SYNC ended on the active bus, sent or received.
    pub fn on_sync(&mut self, bus: Bus, stamp: &Stamp) {
        let [last, _] = self.syncs;
        self.syncs = [Some(SyncEnd { bus, at: stamp.fine(), source: stamp.source }), last];
    }

    /// Neither SYNCs nor PDOs are consumed any more.
    pub fn stop(&mut self) {
        self.syncs = [None; 2];
    }

    /// When the last SYNC ended at the connector of its producer.
    pub fn last_sync(&self, correction: &TimeCorrection) -> Option<FineInstant> {
        let [last, _] = self.syncs;
        last.map(|sync| sync.corrected(correction))
    }

    /// Set by command: always a step.
    pub fn set(&mut self, scet: FineScet, at: FineInstant) -> Step {
        (self.doubt, self.written) = Default::default();
        self.clock.set(at, scet)
    }

    /// Received times have so many binary places of a second from now on.
    pub fn set_fine_bits(&mut self, bits: u32) {
        self.clock.set_fine_bits(bits);
    }

    /// A value of the Spacecraft Time PDO with a type of 0 to 240: the spacecraft time at the last SYNC (ECSS 7.2.3c).
    pub fn at_last_sync(&mut self, scet: FineScet, correction: &TimeCorrection, now: Instant) -> PairOutcome {
        let [last, before] = self.syncs;
        let Some(last) = last else { return self.unused() };
        let source = match last.source {
            StampSource::Capture => TimeSource::Capture,
            StampSource::Interrupt => TimeSource::Interrupt,
        };
        let before = before.map(|before| before.corrected(correction));
        self.pair(last.corrected(correction), before, scet, source, now)
    }

    /// A value of the Spacecraft Time PDO with type 254 or 255: the spacecraft time when it was sent, applied when it was
    /// received (ECSS 7.2.2).
    pub fn at_reception(&mut self, scet: FineScet, at: FineInstant, now: Instant) -> PairOutcome {
        self.pair(at, None, scet, TimeSource::Reception, now)
    }

    /// At `at` it was `scet`, unless that is a time of the SYNC `before`.
    fn pair(
        &mut self,
        at: FineInstant,
        before: Option<FineInstant>,
        scet: FineScet,
        source: TimeSource,
        now: Instant,
    ) -> PairOutcome {
        let off = |at| scet.since(self.clock.at(at));
        let error = off(at);
        if self.clock.is_set() && error.unsigned_abs() > STEP_LIMIT {
            let is_late = before.is_some_and(|before| off(before).unsigned_abs() <= STEP_LIMIT);
            let is_same = self.doubt.times > 0 && error.wrapping_sub(self.doubt.off).unsigned_abs() <= SAME;
            let times = if is_same { self.doubt.times.saturating_add(1) } else { 1 };
            self.doubt = Doubt { off: error, times };
            if times <= if is_late { LATE_IN_A_ROW } else { 1 } {
                return self.unused();
            }
        }
        (self.doubt, self.written) = Default::default();
        let refused = self.clock.refused();
        match self.clock.discipline(at, scet, source, now.into()) {
            Some(step) => PairOutcome::Stepped(step),
            None if self.clock.refused() != refused => PairOutcome::Unused,
            None => PairOutcome::Steered,
        }
    }

    fn unused(&mut self) -> PairOutcome {
        self.late = self.late.saturating_add(1);
        PairOutcome::Unused
    }

    /// The sample for a client that reads one of `count` sub-indices: a new one, unless it read another one before.
    pub fn read(&mut self, at: Address, count: u8, now: Instant) -> FineScet {
        if !self.read.take(at, count, now) {
            self.sample = self.clock.at(now.into());
        }
        self.sample
    }

    /// A client reads the time of a heartbeat: the next ones are stamped.
    pub fn range(&mut self) {
        self.ranged = RANGED;
    }

    /// Whether heartbeats of this node are stamped.
    pub const fn is_ranged(&self) -> bool {
        self.ranged > 0
    }

    /// A heartbeat of this node ended then. Its time, if it was to be stamped.
    pub fn on_heartbeat(&mut self, at: FineInstant) -> Option<FineScet> {
        self.ranged = self.ranged.checked_sub(1)?;
        Some(self.clock.at(at))
    }

    /// A client wrote one of `count` sub-indices. Whether that was the last one.
    pub fn is_written(&mut self, at: Address, count: u8, now: Instant) -> bool {
        self.written.take(at, count, now);
        let is_whole = self.written.left == 0;
        if is_whole {
            self.written = Parts::default();
        }
        is_whole
    }

    /// Object 2015h.
    pub fn quality(&self, now: Instant) -> ClockQuality {
        ClockQuality::new(&self.clock.quality(now.into()), self.late)
    }
}

impl SyncEnd {
    /// At the connector of the producer.
    fn corrected(&self, correction: &TimeCorrection) -> FineInstant {
        let ns = correction.of(self.bus);
        const UNITS: i64 = FineInstant::PER_MICRO as i64;
        // A multiple of the divisor that is more than any correction: one division of positive numbers rounds down.
        const AHEAD: i64 = 1 << 40;
        let ahead = (i64::from(ns) * UNITS + 500 + 1_000 * AHEAD) as u64 / 1_000;
        self.at.plus(AHEAD - ahead as i64)
    }
}

/// The mean of what is lost below the lowest of `bits`, 0 to 24, of a fine time, units of 2^-32 s.
pub fn mean_of_truncated(bits: u32) -> i64 {
    // The mean of 0 to 2^n - 1 units of 2^-24 s.
    ((1i64 << 24u32.saturating_sub(bits)) - 1) << 7
}
