//! Random schedules: lost SYNCs, jumps of the time, resets of the slave, changes of the producer, commands.

use ecss_can::time::TimeSource;
use ecss_can::time::machine::LocalClock;
use ecss_can::types::{FineInstant, FineScet};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Event of a schedule.
#[derive(Clone, Debug)]
enum Event {
    /// Milliseconds without an event.
    Silence(u32),
    /// A SYNC, and the pair some units of 2^-8 µs later. The pair is off by nanoseconds.
    Pair { source: TimeSource, late: u32, off: i32 },
    /// The producer's time is set: it jumps by this number of microseconds.
    Jump(i64),
    /// Another producer: its time is off by microseconds, its crystal by 10^-9.
    Producer { off: i32, rate: i32 },
    /// The slave is reset, and with it its clock.
    Reset,
    /// The slave's clock is set, microseconds from the right time.
    Command(i64),
}

fn source() -> impl Strategy<Value = TimeSource> {
    prop_oneof![
        6 => Just(TimeSource::Capture),
        2 => Just(TimeSource::Interrupt),
        1 => Just(TimeSource::Reception),
    ]
}

fn event() -> impl Strategy<Value = Event> {
    let pair = (source(), 51_200_u32..1_280_000, prop_oneof![8 => -60..60_i32, 1 => -9_000_000..9_000_000])
        .prop_map(|(source, late, off)| Event::Pair { source, late, off });
    prop_oneof![
        12 => pair,
        12 => prop_oneof![Just(100_u32), Just(1_000), 6..3_000_u32, 3_000..200_000_u32].prop_map(Event::Silence),
        1 => prop_oneof![-50_000..50_000_i64, -1_000_000_000_000..1_000_000_000_000_i64].prop_map(Event::Jump),
        1 => (-15_000..15_000, -100_000..100_000).prop_map(|(off, rate)| Event::Producer { off, rate }),
        1 => Just(Event::Reset),
        1 => (-1_000_000..1_000_000_i64).prop_map(Event::Command),
    ]
}

/// Producer, slave, and the last reading of the slave's clock.
struct World {
    clock: LocalClock,
    /// Present on the slave's clock, units of 2^-8 µs.
    now: u64,
    /// Producer's time at `since`, and its rate error in units of 10^-9.
    scet: u64,
    since: u64,
    rate: i64,
    read: Option<(u64, u64)>,
    steps: u16,
    /// A pair was received since the reset.
    is_paired: bool,
}

const SECOND: i128 = 1 << 32;
const UNITS: i128 = 256_000_000;

impl World {
    fn new(start: u64) -> Self {
        let clock = LocalClock::default();
        World {
            clock,
            now: 256_000_000,
            scet: start,
            since: 0,
            rate: 0,
            read: None,
            steps: 0,
            is_paired: false,
        }
    }

    /// Returns the producer's time at an instant of the slave.
    fn truth(&self, at: u64) -> u64 {
        let passed = i128::from(at) - i128::from(self.since);
        let units = passed * SECOND * i128::from(1_000_000_000 + self.rate) / (UNITS * 1_000_000_000);
        self.scet.wrapping_add(units as u64)
    }

    fn produce(&mut self, off_us: i64, rate: i64) {
        let off = (i128::from(off_us) * SECOND / 1_000_000) as u64;
        (self.scet, self.since, self.rate) = (self.truth(self.now).wrapping_add(off), self.now, rate);
    }

    fn at(&self, at: u64) -> u64 {
        self.clock.at(FineInstant::from_units(at)).units()
    }

    /// Checks that between two reads the clock runs at most 0.2 % fast or slow: it never runs backwards, and no second
    /// is lost.
    fn read(&mut self) {
        let shown = self.at(self.now);
        if let Some((at, before)) = self.read {
            let due = (i128::from(self.now - at) * SECOND) / UNITS;
            let ran = i128::from(shown.wrapping_sub(before) as i64);
            // And 1 ns for rounding.
            let room = due / 500 + 4;
            assert!(ran >= 0, "backwards by {} units at {}", -ran, self.now);
            assert!((ran - due).abs() <= room, "{ran} units in {due} from {at} to {}", self.now);
        }
        self.read = Some((self.now, shown));
    }

    fn pass(&mut self, units: u64) {
        // At short distances, where something may change, and at the end.
        for part in [units / 1_000, units / 50, units / 3] {
            self.now += part;
            self.read();
        }
        self.now += units - units / 1_000 - units / 50 - units / 3;
        self.read();
    }

    /// Checks that `when` returns the first instant of a time.
    fn check_when(&self, scet: u64) {
        let when = self.clock.when(FineScet::from_units(scet)).units();
        let since = |at| self.at(at).wrapping_sub(scet) as i64;
        assert!(since(when) >= 0, "{when} is too early by {}", since(when));
        assert!(when == 0 || since(when - 1) < 0, "{when} is not the first instant");
    }

    fn happens(&mut self, event: &Event) {
        match *event {
            Event::Silence(ms) => self.pass(u64::from(ms) * 256_000),
            Event::Pair { source, late, off } => {
                let at = self.now;
                let scet = self.truth(at).wrapping_add_signed(i64::from(off) * 4_295 / 1_000);
                self.pass(late.into());
                let [at, now] = [at, self.now].map(FineInstant::from_units);
                let before = self.clock.at(at);
                let step = self.clock.discipline(at, FineScet::from_units(scet), source, now);
                if let Some(step) = step {
                    self.steps += 1;
                    self.read = None;
                    assert_eq!((step.from, step.to), (before.scet(), FineScet::from_units(scet).scet()));
                    assert_eq!(self.clock.at(at).units(), scet);
                    let size = (scet.wrapping_sub(before.units()) as i64).unsigned_abs();
                    assert!(!self.is_paired || size > 42_949_672, "a step of {size} units");
                } else {
                    assert!(self.is_paired, "the first pair did not step");
                }
                self.is_paired = true;
                self.read();
            }
            Event::Jump(us) => self.produce(us, self.rate),
            Event::Producer { off, rate } => self.produce(off.into(), rate.into()),
            Event::Reset => {
                (self.clock, self.read) = (LocalClock::default(), None);
                (self.steps, self.is_paired) = (0, false);
            }
            Event::Command(us) => {
                let scet = self.truth(self.now).wrapping_add_signed(us * 4_295);
                let at = FineInstant::from_units(self.now);
                let before = self.clock.at(at);
                let step = self.clock.set(at, FineScet::from_units(scet));
                assert_eq!((step.from, step.to), (before.scet(), FineScet::from_units(scet).scet()));
                (self.steps, self.read) = (self.steps + 1, None);
            }
        }
        assert_eq!(self.clock.quality(FineInstant::from_units(self.now)).steps, self.steps);
    }
}

/// Configures `count` random schedules, the same each time; PROPTEST_CASES changes the number.
fn cases(count: u32) -> ProptestConfig {
    let config = ProptestConfig {
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(301),
        ..ProptestConfig::default()
    };
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { config.cases } else { count };
    ProptestConfig { cases, ..config }
}

proptest! {
    #![proptest_config(cases(1_000))]

    /// Given any schedule, between two steps the clock runs forwards, at the right pace to 0.2 %; it steps at a command, at
    /// the first pair and above 10 ms, and reports each step once; `when` is the inverse of `at`.
    #[test]
    fn the_clock_runs_forwards_between_reported_steps(
        start in prop_oneof![any::<u64>(), (0..200_u64 << 32).prop_map(u64::wrapping_neg)],
        events in prop::collection::vec((event(), any::<i32>()), 1..60),
    ) {
        let mut world = World::new(start);
        for (event, ahead) in &events {
            world.happens(event);
            let shown = world.at(world.now);
            // Up to half a second, and up to 128 s, either way.
            world.check_when(shown.wrapping_add_signed(i64::from(*ahead)));
            world.check_when(shown.wrapping_add_signed(i64::from(*ahead) << 8));
        }
    }
}

fn extreme() -> impl Strategy<Value = u64> {
    prop_oneof![any::<u64>(), 0..1_u64 << 40, Just(0), Just(u64::MAX), Just(1 << 63)]
}

proptest! {
    #![proptest_config(cases(1_000))]

    /// Given any instants and times in any order, nothing overflows. A step leads exactly to the time that was set or
    /// received, and is counted. A pair that only corrects the rate or is refused does not change the present reading.
    #[test]
    fn any_instants_and_times_are_taken(
        calls in prop::collection::vec((0..6_u8, source(), extreme(), extreme(), extreme()), 1..50),
    ) {
        let (mut clock, mut steps) = (LocalClock::default(), 0);
        for (call, source, at, scet, now) in calls {
            let (at, now) = (FineInstant::from_units(at), FineInstant::from_units(now));
            let scet = FineScet::from_units(scet);
            let (from, shown, is_set) = (clock.at(at).scet(), clock.at(now.max(at)), clock.is_set());
            let step = match call {
                0 => Some(clock.set(at, scet)),
                1 => None,
                2 => {
                    clock.when(scet);
                    None
                }
                3 => {
                    let bound = clock.quality(now).bound_ns;
                    assert!(is_set || bound == u32::MAX, "{bound} ns, and never set");
                    None
                }
                _ => clock.discipline(at, scet, source, now),
            };
            if let Some(step) = step {
                steps += 1;
                assert_eq!((step.from, step.to), (from, scet.scet()));
                assert_eq!(clock.at(at), scet);
            } else {
                assert_eq!(clock.at(now.max(at)), shown);
            }
            assert_eq!(clock.quality(now).steps, steps);
        }
    }
}
