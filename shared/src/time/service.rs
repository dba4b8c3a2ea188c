//! Time service of a node: its clock, the SYNCs that steer it, and the times that clients set and read in parts
//! (ECSS 7.1, 7.2).

use super::clock::STEP_LIMIT;
use super::objects::{ClockQuality, TimeCorrection};
use super::{ClockPolicy, LocalClock, Step, TimeSource};
use crate::link::bit_timing::Nanoseconds;
use crate::link::{Stamp, StampSource};
use crate::types::{Address, Bus, Duration, FineInstant, FineScet, Instant};

/// Time that a part that was read or written waits for the others of its record.
const PATIENCE: Duration = Duration::from_millis(10_000);

/// A time that fits the SYNC before the last is late. After that many in a row it is the spacecraft time that has
/// changed.
const LATE_IN_A_ROW: u8 = 3;

/// That many short times in a row show that the producer stamps in the interrupt. By chance one of 2^15 sequences does.
const SHORT_IN_A_ROW: u8 = 5;
/// SYNCs of a node, stamped in the interrupt one after the other, after which it has no capture wires.
const UNCAPTURED_IN_A_ROW: u8 = 5;
/// SYNCs in a row with more than one time after which there are two producers. One alone may be a repetition, or a
/// late time.
const TWICE_IN_A_ROW: u8 = 3;

/// Time service of a node: its clock, and the SYNCs and times that steer it.
#[derive(Clone, Debug)]
pub struct TimeService {
    clock: LocalClock,
    /// Longest delay from one node of the network to another, nanoseconds.
    longest_delay: u32,
    /// The last SYNC on the active bus, and the one before.
    syncs: [Option<SyncEnd>; 2],
    /// Spacecraft times that were late, or of no SYNC.
    late: u16,
    late_in_a_row: Run<LATE_IN_A_ROW>,
    short: Run<SHORT_IN_A_ROW>,
    /// A SYNC was captured since power-on.
    was_captured: bool,
    uncaptured: Run<UNCAPTURED_IN_A_ROW>,
    /// Times since the last SYNC.
    times: u8,
    twice: Run<TWICE_IN_A_ROW>,
    /// Samples of which a client reads 2011h and 2013h.
    samples: ClientSamples,
    /// Parts of 2010h and 2012h that are still to be written.
    written: [Parts; 2],
    /// Number of heartbeats of this node that are still to be stamped.
    ranged: u8,
}

/// Each read of 2016h has this number of heartbeats stamped. Who measures a cable reads it after each heartbeat.
const RANGED: u8 = 8;

/// End of a SYNC.
#[derive(Clone, Copy, Debug)]
struct SyncEnd {
    bus: Bus,
    at: FineInstant,
    source: StampSource,
}

/// Counts observations of one kind in a row, up to `MOST`.
#[derive(Clone, Copy, Debug, Default)]
struct Run<const MOST: u8>(u8);

impl<const MOST: u8> Run<MOST> {
    /// Another observation.
    fn note(&mut self, is_of_kind: bool) {
        self.0 = if is_of_kind { MOST.min(self.0 + 1) } else { 0 };
    }

    /// The last `MOST` were of this kind.
    const fn is_whole(self) -> bool {
        self.0 >= MOST
    }
}

/// Parts of a record that are still to come.
#[derive(Clone, Copy, Debug, Default)]
struct Parts {
    /// A bit for each sub-index.
    left: u8,
    until: Instant,
}

impl Parts {
    /// Takes part `sub` of `count`, 1 to `count`. Whether it belongs to those before.
    fn take(&mut self, sub: u8, count: u8, now: Instant) -> bool {
        let bit = 1 << (sub & 7);
        let belongs = self.left & bit != 0 && now < self.until;
        if !belongs {
            // Sub-indices 1 to `count`.
            *self = Parts { left: (2 << count) - 2, until: now + PATIENCE };
        }
        self.left &= !bit;
        belongs
    }
}

/// Samples of the time for a client that reads the parts of a record one by one.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClientSamples {
    /// Sample of 2011h, and that of 2013h.
    samples: [FineScet; 2],
    /// Parts of 2011h and 2013h that are still to be read.
    left: [Parts; 2],
}

/// Number of a record among two: 0 for SCET (2010h, 2011h), 1 for UTC (2012h, 2013h).
const fn record(at: Address) -> usize {
    (at.index >> 1 & 1) as usize
}

/// Binary places of a received time.
///
/// A producer that stamps its SYNCs in the interrupt sends *short* times: the lowest three bits are zero. So its
/// consumers know how it stamps. This quantum is small against the latency of an interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Places {
    /// Number of places, also of a short time.
    pub bits: u32,
    /// `true`: the lowest three of 24 places, or bits of the microseconds, are zero.
    pub is_short: bool,
}

impl Places {
    /// Number of places of a short time.
    pub(crate) const SHORT: u32 = 21;
}

/// Effect of a spacecraft time that arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairOutcome {
    /// The clock follows it.
    Steered,
    /// The clock was set to it.
    Stepped(Step),
    /// The time was not used, and was counted: it belongs to no SYNC that this node received, is late, or
    /// contradicts the clock.
    Unused,
}

impl TimeService {
    /// Makes a service whose clock was never set. `longest_delay`: delay between the two nodes of the network
    /// that are farthest apart.
    pub fn new(clocks: &ClockPolicy, longest_delay: Nanoseconds) -> Self {
        TimeService {
            clock: LocalClock::new(clocks),
            longest_delay: longest_delay.0,
            syncs: [None; 2],
            late: 0,
            late_in_a_row: Run(0),
            // Until the first time that is not.
            short: Run(SHORT_IN_A_ROW),
            was_captured: false,
            uncaptured: Run(0),
            times: 0,
            twice: Run(0),
            samples: ClientSamples::default(),
            written: [Parts::default(); 2],
            ranged: 0,
        }
    }

    /// Returns the local clock.
    pub const fn clock(&self) -> &LocalClock {
        &self.clock
    }

    /// Returns the local clock, to be compared with its copies.
    pub(crate) const fn clock_mut(&mut self) -> &mut LocalClock {
        &mut self.clock
    }

    /// Takes a SYNC that ended on the active bus, sent or received.
    pub fn on_sync(&mut self, bus: Bus, stamp: &Stamp) {
        let [last, _] = self.syncs;
        self.syncs = [Some(SyncEnd { bus, at: stamp.fine(), source: stamp.source }), last];
        let is_captured = stamp.source == StampSource::Capture;
        self.was_captured |= is_captured;
        self.uncaptured.note(!is_captured);
        self.twice.note(self.times > 1);
        self.times = 0;
    }

    /// Returns whether this node stamps its SYNCs in the interrupt: it has no capture wires, or they are broken.
    pub(crate) const fn is_uncaptured(&self) -> bool {
        self.uncaptured.is_whole()
    }

    /// Returns whether times at SYNCs are sent short.
    pub(crate) const fn is_coarse(&self) -> bool {
        !self.was_captured || self.is_uncaptured()
    }

    /// Returns whether two nodes send the spacecraft time: more than one came after each of the last SYNCs.
    pub(crate) const fn has_two_producers(&self) -> bool {
        self.twice.is_whole()
    }

    /// Stops the consumption of SYNCs and times.
    pub fn stop(&mut self) {
        self.syncs = [None; 2];
    }

    /// Returns the instant at which the last SYNC ended at the connector of its producer.
    pub(crate) fn last_sync(&self, correction: &TimeCorrection) -> Option<FineInstant> {
        let [last, _] = self.syncs;
        last.map(|sync| sync.corrected(correction))
    }

    /// Sets the clock by command, which is always a step.
    pub fn set(&mut self, scet: FineScet, at: FineInstant) -> Step {
        self.clock.set(at, scet)
    }

    /// Forgets the parts that a client wrote: a time that was received stands in 2010h or 2012h in their place.
    pub(crate) fn forget_written(&mut self) {
        self.written = Default::default();
    }

    /// Notes the binary places of a spacecraft time that was received.
    pub fn on_places(&mut self, places: Places) {
        self.times = self.times.saturating_add(1);
        self.clock.set_fine_bits(places.bits);
        self.short.note(places.is_short);
    }

    /// Takes a value of the Spacecraft Time PDO with transmission type 0 to 240: the spacecraft time at the last
    /// SYNC (ECSS 7.2.3c).
    pub fn at_last_sync(&mut self, scet: FineScet, correction: &TimeCorrection, now: Instant) -> PairOutcome {
        let [last, before] = self.syncs;
        let Some(last) = last else { return self.unused() };
        let source = match last.source {
            StampSource::Capture if !self.short.is_whole() => TimeSource::Capture,
            _ => TimeSource::Interrupt,
        };
        let before = before.map(|before| before.corrected(correction));
        self.pair(last.corrected(correction), before, scet, source, now)
    }

    /// Takes a value of the Spacecraft Time PDO with transmission type 254 or 255: the spacecraft time when it
    /// was sent, applied at its reception (ECSS 7.2.2).
    pub(crate) fn at_reception(&mut self, scet: FineScet, at: FineInstant, now: Instant) -> PairOutcome {
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
        self.clock.confine(at, now.into());
        if self.clock.is_over(at) {
            return self.unused();
        }
        let is_off = |at| scet.since(self.clock.at(at)).unsigned_abs() > STEP_LIMIT;
        let is_late = self.clock.is_set() && is_off(at) && before.is_some_and(|before| !is_off(before));
        let was_late = self.late_in_a_row.is_whole();
        self.late_in_a_row.note(is_late);
        if is_late && !was_late {
            return self.unused();
        }
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

    /// Returns the samples of the client that reads the time, to be exchanged for those of another client.
    pub(crate) fn samples_mut(&mut self) -> &mut ClientSamples {
        &mut self.samples
    }

    /// Returns the sample for a client that reads part `at` of `count`: a new sample, unless the client read another
    /// part of the record before. `None`: sub-index 0 and those above `count` are no part of the time.
    pub fn read(&mut self, at: Address, count: u8, now: Instant) -> Option<FineScet> {
        if at.sub == 0 || at.sub > count {
            return None;
        }
        let nth = record(at);
        let ClientSamples { samples, left } = &mut self.samples;
        if !left[nth].take(at.sub, count, now) {
            samples[nth] = self.clock.at(now.into());
        }
        Some(samples[nth])
    }

    /// Notes that a client reads the time of a heartbeat: the next heartbeats are stamped.
    pub fn range(&mut self) {
        self.ranged = RANGED;
    }

    /// Returns whether heartbeats of this node are stamped.
    pub(crate) const fn is_ranged(&self) -> bool {
        self.ranged > 0
    }

    /// Takes the end of a heartbeat of this node. Returns its spacecraft time if it was to be stamped.
    pub fn on_heartbeat(&mut self, at: FineInstant) -> Option<FineScet> {
        self.ranged = self.ranged.checked_sub(1)?;
        Some(self.clock.at(at))
    }

    /// Notes that a client wrote part `at` of `count`. Returns whether it was the last one.
    pub(crate) fn on_part_written(&mut self, at: Address, count: u8, now: Instant) -> bool {
        let parts = &mut self.written[record(at)];
        parts.take(at.sub, count, now);
        parts.left == 0
    }

    /// Returns the value of object 2015h. Until the delay of the bus is known, it counts as the longest of the
    /// network.
    pub fn quality(&self, correction: &TimeCorrection, now: Instant) -> ClockQuality {
        let mut quality = self.clock.quality(now.into());
        let [last, _] = self.syncs;
        if last.is_some_and(|sync| correction.of(sync.bus).is_none()) {
            quality.bound_ns = quality.bound_ns.saturating_add(self.longest_delay);
        }
        ClockQuality::new(&quality, self.late)
    }
}

impl SyncEnd {
    /// At the connector of the producer.
    fn corrected(&self, correction: &TimeCorrection) -> FineInstant {
        let ns = correction.of(self.bus).unwrap_or(0);
        const UNITS: i64 = FineInstant::PER_MICRO as i64;
        // A multiple of the divisor that is more than any correction: one division of positive numbers rounds down.
        const AHEAD: i64 = 1 << 40;
        let ahead = (i64::from(ns) * UNITS + 500 + 1_000 * AHEAD) as u64 / 1_000;
        self.at.plus(AHEAD - ahead as i64)
    }
}

/// Returns the mean of what is lost below the lowest of `bits`, 0 to 24, of a fine time, in units of 2^-32 s.
pub fn mean_of_truncated(bits: u32) -> i64 {
    // The mean of 0 to 2^n - 1 units of 2^-24 s.
    ((1i64 << 24u32.saturating_sub(bits)) - 1) << 7
}
