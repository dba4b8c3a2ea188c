//! Two active masters receive each other at any phase of their heartbeats.

use can_twin::wire::time::Time;
use ecss_can_cli::campaign::takeover::{Case, PERIOD, sweep};

/// Given equal clocks, or nearly equal ones, at 1 Mbit/s and 125 kbit/s, When a second master becomes active at any phase and its
/// boot-up message is lost, Then both are active for at most two heartbeat periods.
///
/// Verifies: ECSS 8.1a
#[test]
fn takeover_at_any_phase_leaves_two_masters_two_periods_at_most() {
    for kbit in [1_000, 125] {
        for ppm in [0, 1, 50] {
            let case = Case { kbit, ppm };
            let swept = sweep(case, (0..100_000).step_by(997));
            assert!(swept.both_active > 90, "{case:?}: {swept:?}");
            assert!(swept.undecided == 0 && swept.longest <= Time(2 * PERIOD.0), "{case:?}: {swept:?}");
        }
    }
}
