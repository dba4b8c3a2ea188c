//! Spacecraft times that were forged or corrupted.

use ecss_can::time::TimeSource;
use ecss_can::time::machine::LocalClock;
use ecss_can::types::{FineInstant, FineScet};

/// A slave with the crystal of its master that receives a time each second.
struct World {
    clock: LocalClock,
    second: u64,
    /// Largest ratio of the error to the bound.
    worst: f64,
}

const UNITS_PER_SECOND: u64 = 1 << 32;

impl World {
    fn synchronised() -> Self {
        let mut world = World { clock: LocalClock::default(), second: 10, worst: 0.0 };
        world.hear(20, 0);
        world.worst = 0.0;
        world
    }

    /// Receives `times` times, each off by `off` units of 2^-32 s. Between two of them the clock is compared with the
    /// true time.
    fn hear(&mut self, times: u64, off: i64) {
        for _ in 0..times {
            self.second += 1;
            let [at, now] =
                [0, 1_000].map(|us| FineInstant::from_units((self.second * 1_000_000 + us) * 256));
            let scet = FineScet::from_units((self.second * UNITS_PER_SECOND).wrapping_add_signed(off));
            self.clock.discipline(at, scet, TimeSource::Capture, now);
            for ms in (2..=1_000).step_by(2) {
                let at = FineInstant::from_units((self.second * 1_000 + ms) * 256_000);
                let truth =
                    FineScet::from_units(self.second * UNITS_PER_SECOND + ms * UNITS_PER_SECOND / 1_000);
                let error = self.clock.at(at).since(truth).unsigned_abs() as f64 / 4.294_967_296;
                self.worst = self.worst.max(error / f64::from(self.clock.quality(at).bound_ns));
            }
        }
    }

    fn error_ns(&self) -> f64 {
        let at = FineInstant::from_units((self.second + 1) * 256_000_000);
        self.clock.at(at).since(FineScet::from_units((self.second + 1) * UNITS_PER_SECOND)) as f64
            / 4.294_967_296
    }
}

const HALF_A_MS: i64 = (UNITS_PER_SECOND / 2_000) as i64;
const HALF_A_SECOND: i64 = (UNITS_PER_SECOND / 2) as i64;

/// Given 1 to 9 forged times in a row, 0.5 ms or 0.5 s off, then the error is never above the bound, and a minute later
/// the clock is correct again.
#[test]
fn forged_times_keep_the_error_in_the_bound() {
    for off in [HALF_A_MS, -HALF_A_MS, HALF_A_SECOND, -HALF_A_SECOND] {
        for forged in 1..=9 {
            let mut world = World::synchronised();
            world.hear(forged, off);
            world.hear(60, 0);
            assert!(world.worst <= 1.0, "{forged} times off by {off}: {} times the bound", world.worst);
            assert!(world.error_ns().abs() < 50.0, "{forged} times off by {off}: {} ns", world.error_ns());
        }
    }
}

#[test]
fn two_forged_times_move_nothing() {
    for off in [HALF_A_MS, HALF_A_SECOND] {
        let mut world = World::synchronised();
        world.hear(2, off);
        assert!(world.error_ns().abs() < 50.0, "{} ns", world.error_ns());
        assert_eq!(world.clock.quality(FineInstant::from_units(0)).steps, 1);
    }
}

/// Given times that are continuously 0.5 s off, then the third moves the clock, and nine more confirm it.
#[test]
fn bound_is_wide_until_a_step_is_confirmed() {
    let mut world = World::synchronised();
    world.hear(3, HALF_A_SECOND);
    let bound = |world: &World| {
        world.clock.quality(FineInstant::from_units((world.second * 1_000 + 100) * 256_000)).bound_ns
    };
    assert!((world.error_ns() - 0.5e9).abs() < 50.0, "{} ns", world.error_ns());
    assert!(bound(&world) > 500_000_000);
    world.hear(8, HALF_A_SECOND);
    assert!(bound(&world) > 500_000_000);
    world.hear(1, HALF_A_SECOND);
    assert!(bound(&world) < 1_000, "{}", bound(&world));
}

/// Given forged times that do not agree with each other at the rate of any two crystals, then none of them changes the
/// clock.
#[test]
fn times_that_contradict_each_other_move_nothing() {
    let mut world = World::synchronised();
    for nth in 1..=30 {
        world.hear(1, (nth * nth % 7 + 1) * HALF_A_MS * 4);
    }
    assert!(world.error_ns().abs() < 50.0, "{} ns", world.error_ns());
}

/// Given another producer whose crystal is 100 ppm off, then the seventh of its times moves the clock.
#[test]
fn times_at_another_rate_move_the_clock_later() {
    let mut world = World::synchronised();
    for nth in 1..=6 {
        world.hear(1, HALF_A_SECOND + nth * (UNITS_PER_SECOND / 10_000) as i64);
        assert!(world.error_ns().abs() < 50.0, "time {nth}: {} ns", world.error_ns());
    }
    world.hear(1, HALF_A_SECOND + 7 * (UNITS_PER_SECOND / 10_000) as i64);
    assert!(world.error_ns() > 0.4e9, "{} ns", world.error_ns());
}
