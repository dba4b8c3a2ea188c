//! One master, one slave, and the time pairs from one to the other.

use ecss_can::time::TimeSource;
use ecss_can::time::machine::LocalClock;
use ecss_can::types::{FineInstant, FineScet};
use fastrand::Rng;

use crate::local_clock::crystal::{Crystal, Data};
use crate::local_clock::follower::Follower;

/// How a node stamps SYNCs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stamps {
    /// By a timer of 84 MHz.
    Capture,
    /// In the interrupt: late by up to a microsecond, and a few times in a hundred by several.
    Interrupt,
}

/// A scenario.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Seed of crystals and latencies.
    pub seed: u64,
    /// Crystals of master and slave.
    pub crystals: [Data; 2],
    /// Length of the run, seconds.
    pub seconds: f64,
    /// Time between two samples of the slave's clock, nanoseconds.
    pub sampled: f64,
    /// Period of the SYNC by the master's clock, nanoseconds.
    pub period: f64,
    /// SYNCs in one time PDO.
    pub divider: u64,
    /// Greatest random delay of a SYNC, nanoseconds.
    pub jitter: f64,
    /// The producer delays each SYNC by a random number of microseconds below this, on purpose.
    pub dither: u64,
    /// How master and slave stamp SYNCs.
    pub stamps: [Stamps; 2],
    /// Delay from the master to the slave that is not corrected, nanoseconds.
    pub delay: f64,
    /// Share of the pairs that is lost, 0 to 1.
    pub lost: f64,
    /// Time after which no pair arrives, seconds.
    pub silent_from: f64,
}

/// One sample of the slave's clock.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// True time, seconds.
    pub time: f64,
    /// Slave minus master, nanoseconds.
    pub error: f64,
    /// Bound that the slave reports, nanoseconds.
    pub bound: f64,
}

/// Time that the master and slave have run when the slave first receives a SYNC, nanoseconds.
const BOOT: f64 = 2e9;

impl Scenario {
    /// Crystals of ±50 ppm that drift by 0.1 ppm/s apart, SYNC each second.
    pub fn new(seed: u64) -> Self {
        let mut rng = Rng::with_seed(seed);
        let drift = if rng.bool() { 0.1 } else { -0.1 };
        let crystals = [drift, -drift].map(|drift| Data::noisy(rng.f64() * 100.0 - 50.0, drift));
        Scenario {
            seed,
            crystals,
            seconds: 90.0,
            sampled: 1e7,
            period: 1e9,
            divider: 1,
            jitter: 20_000.0,
            dither: 1,
            stamps: [Stamps::Capture; 2],
            delay: 0.0,
            lost: 0.0,
            silent_from: f64::INFINITY,
        }
    }

    /// Returns the error of `slave` over time.
    pub fn run(&self, slave: &mut impl Follower) -> Vec<Sample> {
        let mut rng = Rng::with_seed(!self.seed);
        let [a, b] = self.crystals.map(|data| Crystal::run(data, self.seconds + 12.0, &mut rng));
        let (start, master) = self.master(&mut rng);
        // The slave was switched on up to 100 s earlier.
        let slave_start = (rng.f64() * 1e11).floor();
        let mut pending: Option<(f64, FineInstant, FineScet)> = None;
        let (mut samples, mut sync) = (Vec::new(), 0_u64);
        let mut next = self.next_sync(&a, sync, &mut rng);
        for point in 0..(self.seconds * 1e9 / self.sampled) as u64 {
            let time = BOOT + point as f64 * self.sampled;
            loop {
                let arrival = pending.map_or(f64::INFINITY, |(arrival, ..)| arrival);
                if arrival.min(next) > time {
                    break;
                }
                if arrival <= next {
                    let Some((_, at, scet)) = pending.take() else { break };
                    let now = local(b.reads(arrival) + slave_start);
                    slave.pair(at, scet, source(self.stamps[1]), now);
                } else {
                    let is_paired = sync.is_multiple_of(self.divider) && rng.f64() >= self.lost;
                    if is_paired && next < BOOT + self.silent_from * 1e9 {
                        let [of_a, of_b] = self.stamps;
                        let of_master = stamp(of_a, a.reads(next), &mut rng);
                        let at = stamp(of_b, b.reads(next + self.delay) + slave_start, &mut rng);
                        let scet = sent(of_a, master.at(of_master));
                        let delay = 200_000.0 + rng.f64() * 4_800_000.0;
                        pending = Some((next + delay, at, scet));
                    }
                    sync += 1;
                    next = self.next_sync(&a, sync, &mut rng);
                }
            }
            let reading = b.reads(time) + slave_start;
            let at = local(reading);
            let beside = reading - at.units() as f64 * 3.90625;
            let shown = slave.at(at).since(start) as f64 * (1e9 / 4_294_967_296.0) + beside;
            samples.push(Sample {
                time: (time - BOOT) / 1e9,
                error: shown - a.reads(time),
                bound: slave.bound(at),
            });
        }
        samples
    }

    /// Spacecraft time at the master's instant zero, near the wrap of the counter, and the master's clock.
    fn master(&self, rng: &mut Rng) -> (FineScet, LocalClock) {
        let start = FineScet::from_units(rng.u64(0..1 << 38).wrapping_sub(1 << 37));
        let mut clock = LocalClock::default();
        clock.set(FineInstant::from_units(0), start);
        (start, clock)
    }

    fn next_sync(&self, master: &Crystal, sync: u64, rng: &mut Rng) -> f64 {
        let dither = rng.u64(0..self.dither) as f64 * 1_000.0;
        master.shows(BOOT + (sync + 1) as f64 * self.period + dither) + rng.f64() * self.jitter
    }
}

/// Returns the time source that a node with these stamps reports.
fn source(stamps: Stamps) -> TimeSource {
    match stamps {
        Stamps::Capture => TimeSource::Capture,
        Stamps::Interrupt => TimeSource::Interrupt,
    }
}

/// Returns a time of the master as the slave receives it: 24 binary places, plus the mean of the truncated part. A
/// master without capture sends 21 places, rounded.
fn sent(stamps: Stamps, scet: FineScet) -> FineScet {
    let units = match stamps {
        Stamps::Capture => scet.units() & !0xFF,
        Stamps::Interrupt => scet.units().wrapping_add(0x400) & !0x7FF,
    };
    FineScet::from_units(units.wrapping_add(0x80))
}

/// Returns the stamp of an event at which the node's clock shows `reading`, nanoseconds.
fn stamp(stamps: Stamps, reading: f64, rng: &mut Rng) -> FineInstant {
    match stamps {
        // Ticks of 84 MHz, to the nearest 2^-8 µs.
        Stamps::Capture => {
            let ticks = (reading * 0.084).floor() as u64;
            FineInstant::from_units((ticks * 64 + 10) / 21)
        }
        Stamps::Interrupt => {
            let outlier = if rng.f64() < 0.03 { rng.f64() * 6_000.0 } else { 0.0 };
            let late = rng.f64() * 1_000.0 + outlier;
            FineInstant::from_units(((reading + late) / 1_000.0).floor() as u64 * 256)
        }
    }
}

/// Returns the instant of the node's clock nearest to a reading in nanoseconds.
fn local(reading: f64) -> FineInstant {
    FineInstant::from_units((reading / 3.90625).round() as u64)
}
