//! Local clock, timers.

use ecss_can::time::Step;
use ecss_can::time::machine::LocalClock;
use ecss_can::types::{Duration, FineInstant, Instant, Periodic, Scet};

use crate::bench::{ms, span};

fn scet(coarse: u32, fine: u32) -> Scet {
    Scet::new(coarse, fine).unwrap()
}

/// Verifies: ECSS 7.1.1a
/// Notices: ECSS 7.1.1a: before the instant at which it was set the clock stands still.
#[test]
fn a_clock_counts_from_power_on_until_it_is_set() {
    let mut clock = LocalClock::default();
    let shows = |clock: &LocalClock, at| clock.at(FineInstant::from(at)).scet();
    assert_eq!(shows(&clock, ms(2_500)), scet(2, 0x0080_0000));
    let step = clock.set(ms(2_500).into(), scet(1_000, 0).into());
    assert_eq!(step, Step { from: scet(2, 0x0080_0000), to: scet(1_000, 0) });
    assert_eq!(shows(&clock, ms(3_500)), scet(1_001, 0));
    // A stamp may be older than the setting.
    assert_eq!(shows(&clock, ms(2_000)), scet(999, 0x0080_0000));
}

/// Given a clock that was set once, when it hears no time for hours, days and years, then it shows the seconds since then.
///
/// Verifies: ECSS 7.1.1a
/// Notices: ECSS 7.1.1a: the clock goes back when it has heard no time for some hours.
#[test]
fn a_clock_counts_on_for_years_without_a_time() {
    let mut clock = LocalClock::default();
    clock.set(ms(2_500).into(), scet(1_000, 0).into());
    for (seconds, shown) in [(3_600, 4_600), (7_200, 8_200), (86_400, 87_400), (315_360_000, 315_361_000)] {
        let at = FineInstant::from(ms(2_500 + 1_000 * seconds));
        assert_eq!(clock.at(at).scet(), scet(shown, 0), "{seconds} s later");
    }
}

#[test]
fn instants_and_durations_saturate() {
    let end = Instant::from_micros(u64::MAX);
    assert_eq!(end + span(1), end);
    assert_eq!(Instant::ZERO - span(1), Instant::ZERO);
    assert_eq!(ms(1).since(ms(2)), Duration::ZERO);
    assert_eq!(Duration::from_micros(u64::MAX).times(2), Duration::from_micros(u64::MAX));
    assert_eq!(Duration::from_micros(u64::MAX) + span(1), Duration::from_micros(u64::MAX));
}

#[test]
fn a_timer_asked_late_skips_what_it_missed_and_says_how_much() {
    let mut timer = Periodic::new(span(100));
    timer.start(ms(30));
    assert_eq!(timer.take(ms(29)), None);
    assert_eq!(timer.take(ms(30)), Some(0));
    assert_eq!(timer.take(ms(229)), Some(0));
    // Due at 230, 330 and 430: one of them counts, the grid stays.
    assert_eq!(timer.take(ms(430)), Some(2));
    assert_eq!(timer.deadline(), Some(ms(530)));
}
