//! Longest time with two active masters when one becomes active at any phase of the other one's heartbeats.

use std::thread;

use ecss_can_cli::campaign::takeover::{Case, PERIOD, sweep};

use crate::bench::context::Context;
use crate::bench::row::Row;

/// Steps of the phase, microseconds.
const STEP_US: usize = 5;

const CASES: [Case; 6] = [
    Case { kbit: 1_000, ppm: 0 },
    Case { kbit: 1_000, ppm: 1 },
    Case { kbit: 1_000, ppm: 50 },
    Case { kbit: 125, ppm: 0 },
    Case { kbit: 125, ppm: 1 },
    Case { kbit: 125, ppm: 50 },
];

pub fn measure(_: &Context) -> anyhow::Result<Vec<Row>> {
    let fly = |case| sweep(case, (0..PERIOD.as_us()).step_by(STEP_US));
    let swept = thread::scope(|scope| {
        let flown = CASES.map(|case| scope.spawn(move || fly(case)));
        flown.map(|thread| thread.join().expect("a world without a panic"))
    });
    let rows = CASES.iter().zip(swept).flat_map(|(Case { kbit, ppm }, swept)| {
        let name = format!("{kbit}_kbit_{ppm}_ppm");
        [
            Row::lower(format!("{name}_longest"), swept.longest.as_secs_f64() * 1e3, "ms")
                .within(2.0 * PERIOD.as_secs_f64() * 1e3),
            Row::lower(format!("{name}_undecided"), swept.undecided, "phases").within(0),
            Row::higher(format!("{name}_both_active"), swept.both_active, "phases"),
        ]
    });
    Ok(rows.collect())
}
