//! The local clock follows pairs of instant and spacecraft time.
//!
//! Verifies: ECSS 7.2.1a

use ecss_can::time::machine::LocalClock;
use ecss_can::time::{ClockPolicy, Step, TimeSource};
use ecss_can::types::{FineInstant, FineScet};

/// Units of the node's clock in a second, and in a microsecond.
const SECOND: u64 = 256_000_000;
const MICRO: u64 = 256;

/// Units of spacecraft time in a second.
const SCET_SECOND: u64 = 1 << 32;

fn local(seconds: u64, micros: u64) -> FineInstant {
    FineInstant::from_units(seconds * SECOND + micros * MICRO)
}

fn scet(seconds: u64, nanos: u64) -> FineScet {
    FineScet::from_units((seconds * SCET_SECOND).wrapping_add(nanos * SCET_SECOND / 1_000_000_000))
}

/// A pair by capture that is known 2 ms later.
fn pair(clock: &mut LocalClock, seconds: u64, time: FineScet) -> Option<Step> {
    clock.discipline(local(seconds, 0), time, TimeSource::Capture, local(seconds, 2_000))
}

/// How far the clock is from a time, nanoseconds.
fn off(clock: &LocalClock, at: FineInstant, time: FineScet) -> i64 {
    clock.at(at).since(time) * 1_000_000_000 / SCET_SECOND as i64
}

/// A clock with pairs at 10 s to 19 s, at the nominal rate: it is 90 s behind.
fn synchronised() -> LocalClock {
    let mut clock = LocalClock::default();
    for second in 10..20 {
        pair(&mut clock, second, scet(second + 90, 0));
    }
    clock
}

#[test]
fn the_first_pair_steps_the_clock_and_the_second_does_not() {
    let mut clock = LocalClock::default();
    let step = pair(&mut clock, 10, scet(100, 0));
    assert_eq!(step, Some(Step { from: scet(10, 0).scet(), to: scet(100, 0).scet() }));
    assert_eq!(clock.at(local(10, 0)), scet(100, 0));
    assert_eq!(pair(&mut clock, 11, scet(101, 9_000)), None);
    assert_eq!(clock.quality(local(11, 0)).steps, 1);
}

#[test]
fn two_pairs_give_the_rate_and_three_the_drift() {
    let mut clock = LocalClock::default();
    // 10 µs in the first second, 10.2 µs in the next: 0.2 ppm/s.
    pair(&mut clock, 10, scet(100, 0));
    pair(&mut clock, 11, scet(101, 10_000));
    let rate = clock.quality(local(11, 2_000)).rate_ppb;
    assert!((9_900..10_100).contains(&rate), "{rate}");
    assert!(off(&clock, local(12, 0), scet(102, 20_000)).abs() < 60);
    pair(&mut clock, 12, scet(102, 20_200));
    // 10.4 µs in the third, 10.3 ppm at its beginning.
    assert!(off(&clock, local(13, 0), scet(103, 30_600)).abs() < 60);
    let rate = clock.quality(local(12, 2_000)).rate_ppb;
    assert!((10_250..10_350).contains(&rate), "{rate}");
}

#[test]
fn a_correction_is_no_jump_and_is_over_after_31_ms() {
    let mut clock = LocalClock::default();
    pair(&mut clock, 10, scet(100, 0));
    // 1 µs in a second: 1 ppm, which is 2 ns until the pair is known, and 36 ns until the end of the correction.
    pair(&mut clock, 11, scet(101, 1_000));
    assert_eq!(off(&clock, local(11, 2_000), scet(101, 2_000_000)), 0);
    assert!((480..520).contains(&off(&clock, local(11, 17_625), scet(101, 17_625_000))));
    let after = off(&clock, local(11, 33_250), scet(101, 33_250_000));
    assert!((1_000..1_040).contains(&after), "{after}");
}

/// The third of the pairs that contradict the clock moves it: below 10 ms it is steered, above it steps.
#[test]
fn contradicting_pairs_step_the_clock_above_10_ms_only() {
    for (off_ns, is_step) in [(9_900_000, false), (10_100_000, true)] {
        let mut clock = synchronised();
        for second in [20, 21] {
            assert_eq!(pair(&mut clock, second, scet(second + 90, off_ns)), None);
        }
        assert_eq!(clock.refused(), 2);
        let step = pair(&mut clock, 22, scet(112, off_ns));
        let whole = Step { from: scet(112, 0).scet(), to: scet(112, off_ns).scet() };
        assert_eq!(step, is_step.then_some(whole));
        assert_eq!(clock.at(local(22, 0)) == scet(112, off_ns), is_step);
        assert_eq!(clock.refused(), 2);
    }
}

/// Given a clock that follows its master, when the time of the master is set by years, then the clock follows.
#[test]
fn a_clock_follows_a_step_of_years() {
    const YEAR: u64 = 31_557_600;
    for years in [1, 4, 5, 10, 30, 60] {
        for span in [years * YEAR * SCET_SECOND, (years * YEAR * SCET_SECOND).wrapping_neg()] {
            let mut clock = synchronised();
            let time = |second| FineScet::from_units(scet(second + 90, 0).units().wrapping_add(span));
            for second in 20..30 {
                pair(&mut clock, second, time(second));
            }
            let off = clock.at(local(29, 0)).since(time(29)).unsigned_abs();
            assert!(off < SCET_SECOND / 1_000, "{years} years, {span}");
        }
    }
}

#[test]
fn a_single_outlier_is_refused_and_the_third_in_a_row_taken() {
    let mut clock = synchronised();
    for second in 20..22 {
        assert_eq!(pair(&mut clock, second, scet(second + 90, 50_000)), None);
        assert!(off(&clock, local(second, 100_000), scet(second + 90, 100_000_000)).abs() < 20);
        // It is not decided who is wrong.
        assert!(clock.quality(local(second, 100_000)).bound_ns > 50_000);
    }
    assert_eq!(clock.refused(), 2);
    assert_eq!(pair(&mut clock, 22, scet(112, 50_000)), None);
    // At most 0.1 % fast: 50 µs take 51.2 ms.
    assert!(off(&clock, local(22, 10_000), scet(112, 10_000_000)) < 10_000);
    assert!(off(&clock, local(22, 60_000), scet(112, 60_050_000)).abs() < 20);
}

/// As those ahead of the clock.
#[test]
fn the_third_in_a_row_behind_the_clock_is_taken() {
    let mut clock = synchronised();
    for second in 20..23 {
        assert!(off(&clock, local(second, 0), scet(second + 90, 0)).abs() < 20);
        assert_eq!(pair(&mut clock, second, scet(second + 89, 999_950_000)), None);
    }
    assert!(off(&clock, local(22, 60_000), scet(112, 59_950_000)).abs() < 20);
}

/// Given a profile of five agreeing times, then the fifth moves the clock.
#[test]
fn the_profile_says_how_many_times_move_the_clock() {
    let mut clock = LocalClock::new(&ClockPolicy { agreeing: 5, ..ClockPolicy::DEFAULT });
    for second in 10..20 {
        pair(&mut clock, second, scet(second + 90, 0));
    }
    for second in 20..25 {
        assert!(off(&clock, local(second, 0), scet(second + 90, 0)).abs() < 20);
        pair(&mut clock, second, scet(second + 90, 50_000));
    }
    assert!(off(&clock, local(24, 60_000), scet(114, 60_050_000)).abs() < 20);
}

/// Given a profile that asks for more agreeing times than a policy may, then the clock waits for as many as it may.
#[test]
fn a_profile_cannot_keep_the_clock_from_moving() {
    let mut clock = LocalClock::new(&ClockPolicy { agreeing: 255, ..ClockPolicy::DEFAULT });
    for second in 10..20 {
        pair(&mut clock, second, scet(second + 90, 0));
    }
    for second in 20..60 {
        assert!(off(&clock, local(second, 0), scet(second + 90, 0)).abs() < 100, "at {second} s");
        pair(&mut clock, second, scet(second + 90, 500_000));
    }
    assert!(off(&clock, local(59, 600_000), scet(149, 600_500_000)).abs() < 100);
}

/// Given crystals farther apart than the profile admits (300 ppm), then the clock has no bound.
#[test]
fn a_rate_beyond_the_profile_has_no_bound() {
    let bound = |ppm: u64| {
        let mut clock = LocalClock::default();
        for second in 10..40 {
            pair(&mut clock, second, scet(second, second * ppm * 1_000));
        }
        (clock.is_saturated(), clock.quality(local(39, 100_000)).bound_ns == u32::MAX)
    };
    assert_eq!(bound(290), (false, false));
    assert_eq!(bound(310), (true, true));
}

/// Given more than 64 s without a pair, then the next one gives the time, and nothing of the rate: 0.1 ms after 71 s may be a
/// clock that was warmed up meanwhile.
#[test]
fn a_pair_after_a_long_silence_moves_the_clock_and_not_its_rate() {
    let mut clock = synchronised();
    let before = clock.quality(local(19, 100_000)).rate_ppb;
    assert_eq!(pair(&mut clock, 90, scet(180, 100_000)), None);
    assert_eq!(clock.refused(), 0);
    // At most 0.1 % fast: 0.1 ms takes 0.1 s.
    assert!(off(&clock, local(92, 0), scet(182, 100_000)).abs() < 100);
    assert!((clock.quality(local(92, 0)).rate_ppb - before).abs() <= 1);
}

#[test]
fn outliers_between_good_pairs_are_never_taken() {
    let mut clock = synchronised();
    for second in 20..60 {
        let outlier = if second % 3 == 0 { 0 } else { 8_000 };
        pair(&mut clock, second, scet(second + 90, outlier));
        assert!(off(&clock, local(second, 500_000), scet(second + 90, 500_000_000)).abs() < 20);
    }
}

#[test]
fn a_command_steps_and_keeps_the_rate() {
    let mut clock = LocalClock::default();
    for second in 10..20 {
        pair(&mut clock, second, scet(second, second * 20_000));
    }
    let step = clock.set(local(25, 0), scet(5_000, 0));
    assert_eq!(step.to, scet(5_000, 0).scet());
    // 20 ppm.
    assert!(off(&clock, local(35, 0), scet(5_010, 200_000)).abs() < 500);
    assert_eq!(clock.quality(local(35, 0)).source, TimeSource::Command);
}

#[test]
fn a_pair_before_the_last_correction_is_ignored() {
    let mut clock = synchronised();
    let before = clock.clone();
    assert_eq!(clock.discipline(local(19, 1_000), scet(0, 0), TimeSource::Capture, local(19, 3_000)), None);
    assert_eq!(clock, before);
}

/// The seconds count on through 2^32.
///
/// Verifies: ECSS 7.1.1a
/// Notices: ECSS 7.1.1a: the seconds saturate at 2^32 - 1.
#[test]
fn the_clock_runs_through_the_wrap_of_the_seconds() {
    let mut clock = LocalClock::default();
    let last = (1 << 32) - 1;
    pair(&mut clock, 10, scet(last - 1, 0));
    pair(&mut clock, 11, scet(last, 0));
    assert_eq!(clock.at(local(12, 500_000)).scet(), scet(0, 500_000_000).scet());
    assert!(clock.when(scet(1, 0)).units().abs_diff(13 * SECOND) <= 1);
    assert_eq!(pair(&mut clock, 12, scet(0, 0)), None);
    assert_eq!(clock.quality(local(12, 0)).steps, 1);
}

#[test]
fn when_is_the_first_instant_of_a_time() {
    let mut clock = LocalClock::default();
    assert_eq!(clock.when(scet(7, 0)), local(7, 0));
    clock.set(local(10, 0), scet(100, 0));
    assert_eq!(clock.when(scet(101, 500_000_000)), local(11, 500_000));
    // Past, and before power-on.
    assert_eq!(clock.when(scet(95, 0)), local(5, 0));
    assert_eq!(clock.when(scet(80, 0)), FineInstant::from_units(0));
    // A unit of 2^-8 µs is 16.8 units of time: the 17th needs the second.
    let time = FineScet::from_units(100 * SCET_SECOND + 17);
    assert_eq!(clock.when(time), FineInstant::from_units(10 * SECOND + 2));
}

#[test]
fn the_quality_says_where_the_time_came_from_and_how_good_it_is() {
    let mut clock = LocalClock::default();
    let quality = clock.quality(local(5, 0));
    assert_eq!((quality.source, quality.bound_ns, quality.age_ms), (TimeSource::None, u32::MAX, 5_000));
    clock.set(local(6, 0), scet(100, 0));
    let quality = clock.quality(local(8, 500_000));
    assert_eq!((quality.source, quality.age_ms, quality.steps), (TimeSource::Command, 2_500, 1));
    assert!(quality.bound_ns > 5_000_000);
    let clock = synchronised();
    // Ten pairs of some 20 ns.
    let fresh = clock.quality(local(19, 100_000)).bound_ns;
    assert!((60..300).contains(&fresh), "{fresh}");
    let mut last = fresh;
    for second in [21, 30, 60, 147, 148, 1_000] {
        let bound = clock.quality(local(second, 0)).bound_ns;
        assert!(bound > last, "{bound} ns after {second} s");
        last = bound;
    }
    // After an hour: 2 ppm for all but half of the first 10 s of 3,581 s, and what is not known of the rate.
    let hour = clock.quality(local(3_600, 0)).bound_ns;
    assert!((7_152_000..10_000_000).contains(&hour), "{hour}");
    assert_eq!(clock.quality(local(1 << 33, 0)).bound_ns, u32::MAX);
}

/// Given times of 16 binary places, whose last is 15 µs, none is refused for it.
#[test]
fn coarse_times_are_not_taken_for_outliers() {
    let mut clock = LocalClock::default();
    clock.set_fine_bits(16);
    for second in 10..60 {
        // Up to 15.2 µs are cut off, 7.6 µs in the mean.
        let cut = (second * 7_919) % 15_259;
        pair(&mut clock, second, scet(second, 15_259 + 7_630 - cut));
    }
    assert_eq!(clock.refused(), 0);
    assert!(off(&clock, local(60, 0), scet(60, 15_259)).abs() < 7_000);
}
