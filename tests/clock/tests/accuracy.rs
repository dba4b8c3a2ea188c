//! How near the local clock comes to the master's, with the crystals of the requirement.

use clock_worlds::{Figures, Scenario, Stamps};
use ecss_can::time::disciplined::LocalClock;

/// The figures of all seeds together, from 30 s on.
fn figures(seeds: u64, scenario: impl Fn(u64) -> Scenario) -> Figures {
    let errors = (0..seeds).flat_map(|seed| {
        let samples = scenario(seed).run(&mut LocalClock::new());
        samples.into_iter().filter(|sample| sample.time >= 30.0).map(|sample| sample.error)
    });
    Figures::of(errors)
}

#[test]
fn one_sync_a_second_gives_30_ns() {
    let figures = figures(5, Scenario::new);
    assert!(figures.rms <= 30.0 && figures.permille <= 100.0, "{figures:?}");
}

#[test]
fn ten_syncs_a_second_give_20_ns() {
    let figures = figures(5, |seed| Scenario { period: 1e8, ..Scenario::new(seed) });
    assert!(figures.rms <= 20.0 && figures.permille <= 60.0, "{figures:?}");
}

#[test]
fn stamps_of_interrupts_give_5_us() {
    let figures = figures(5, |seed| Scenario { stamps: Stamps::Interrupt, ..Scenario::new(seed) });
    assert!(figures.permille <= 5_000.0, "{figures:?}");
}
