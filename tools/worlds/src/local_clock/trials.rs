//! Trials of the reported bound (2015h) with crystals, stamps and losses within the limits of the profile.

use ecss_can::profile::Profile;
use ecss_can::time::ClockPolicy;

use crate::local_clock::{Data, Sample, Scenario, Slave, Stamps, Warmth};

/// A scenario for each seed, and the profile of its slave.
pub struct Trial {
    /// Name in reports.
    pub name: &'static str,
    /// Makes the scenario of a seed.
    pub scenario: fn(u64) -> Scenario,
    /// Limits in the profile.
    pub clocks: ClockPolicy,
    /// 2014h of the slave.
    pub delay: i32,
}

/// Value of 2014h before it was written.
const UNKNOWN: i32 = i32::MIN;

/// Returns a scenario of crystals without drift of their own; that of the slave changes with temperature.
fn warm(seed: u64, warmth: Warmth) -> Scenario {
    let quiet = Scenario::new(seed);
    let [mut master, mut slave] = quiet.crystals;
    (master.drift_ppm, slave.drift_ppm, slave.warmth) = (0.0, 0.0, warmth);
    Scenario { crystals: [master, slave], ..quiet }
}

fn ramp(seed: u64, over: f64) -> Scenario {
    // At a different phase of the SYNC for each seed.
    let from = 40.0 + (seed % 97) as f64 / 97.0;
    warm(seed, Warmth::Ramp { from, over, ppm: 2.0 })
}

fn both(crystals: [Data; 2], change: impl Fn(&mut Data)) -> [Data; 2] {
    crystals.map(|mut data| {
        change(&mut data);
        data
    })
}

const POLICY: ClockPolicy = ClockPolicy::DEFAULT;

const fn trial(name: &'static str, scenario: fn(u64) -> Scenario) -> Trial {
    Trial { name, scenario, clocks: POLICY, delay: 0 }
}

/// For crystals that drift steadily by 0.2 ppm/s against each other, as those of [`Scenario::new`] do.
pub const STEADY: ClockPolicy = ClockPolicy { excursion: 40_000, ..POLICY };

const fn steady(name: &'static str, scenario: fn(u64) -> Scenario) -> Trial {
    Trial { clocks: STEADY, ..trial(name, scenario) }
}

/// All trials.
pub const TRIALS: [Trial; 13] = [
    steady("quiet: crystals that drift steadily", Scenario::new),
    trial("2 ppm within 10 s", |seed| ramp(seed, 10.0)),
    Trial {
        clocks: ClockPolicy { drift: 2_000, ..POLICY },
        ..trial("2 ppm within 1 s, profile 2 ppm/s", |seed| ramp(seed, 1.0))
    },
    trial("cycles of ±1 ppm, 60 s", |seed| warm(seed, Warmth::Cycles { ppm: 1.0, period: 60.0 })),
    trial("sine of 1 ppm, 60 s", |seed| warm(seed, Warmth::Sine { ppm: 1.0, period: 60.0 })),
    steady("random walk of 20 ppb", |seed| {
        let quiet = Scenario::new(seed);
        Scenario { crystals: both(quiet.crystals, |data| data.walk_ppb = 20.0), ..quiet }
    }),
    steady("30 % of the pairs lost", |seed| Scenario { lost: 0.3, ..Scenario::new(seed) }),
    steady("70 % of the pairs lost", |seed| Scenario { lost: 0.7, ..Scenario::new(seed) }),
    trial("100 s without SYNC after 2 ppm within 10 s", |seed| Scenario {
        silent_from: 51.5,
        seconds: 151.5,
        ..ramp(seed, 10.0)
    }),
    Trial {
        delay: UNKNOWN,
        ..steady("delay of 119 ns, not configured", |seed| Scenario { delay: 118.9, ..Scenario::new(seed) })
    },
    steady("master without capture wires", |seed| Scenario {
        stamps: [Stamps::Interrupt, Stamps::Capture],
        ..Scenario::new(seed)
    }),
    steady("no capture wires", |seed| Scenario { stamps: [Stamps::Interrupt; 2], ..Scenario::new(seed) }),
    steady("crystals of +100 and -100 ppm", |seed| {
        let quiet = Scenario::new(seed);
        let [mut master, mut slave] = quiet.crystals;
        (master.offset_ppm, slave.offset_ppm) = if seed % 2 == 0 { (100.0, -100.0) } else { (-100.0, 100.0) };
        Scenario { crystals: [master, slave], ..quiet }
    }),
];

impl Trial {
    /// Returns the samples of one seed each 10 ms, with a SYNC each `period` nanoseconds, from the second pair on.
    pub fn run(&self, seed: u64, period: f64) -> Vec<Sample> {
        let profile = Profile { clocks: self.clocks, ..Profile::DEFAULT };
        assert!(profile.is_clock_sound());
        let scenario = Scenario { period, ..(self.scenario)(seed) };
        let mut samples = scenario.run(&mut Slave::new(&profile, self.delay));
        samples.retain(|sample| sample.bound < f64::from(u32::MAX));
        samples
    }
}
