//! Fail-over times of a fixed share of the campaign of faults.

use ecss_can_cli::campaign::failover::times;
use ecss_can_cli::fly::drawing::chart::{Curve, Quantity, curves};
use ecss_can_cli::fly::drawing::{Layout, Range};

/// Runs of each kind of cut.
const RUNS: u64 = 100;
/// Width of a bin, milliseconds. The end of the axis follows.
const BIN: f64 = 20.0;
const END: f64 = 1_200.0;

/// Places of the cuts, metres. Node n is at 2 n.
const CUTS: [(u32, &str, &str); 3] = [
    (3, "the master alone is cut off", "blue thick"),
    (5, "three of four slaves are cut off", "amber thick"),
    (9, "one of four slaves is cut off", "teal thick"),
];

/// Returns names and contents of all pictures.
pub fn pictures() -> Vec<(&'static str, String)> {
    vec![("campaign-failover.svg", histogram())]
}

fn histogram() -> String {
    let drawn = CUTS.map(|(place, name, class)| {
        let ends: Vec<f64> = times(place, RUNS).into_iter().map(|[_, end]| end).collect();
        let name = format!("{name}: {} of {RUNS} runs changed the bus", ends.len());
        Curve { name: Some(name), class: class.into(), points: stairs(&ends) }
    });
    let across = Quantity {
        title: "from the cut until all slaves are Operational on the other bus",
        range: Range::Linear(0.0, END, 100.0),
        text: |value| format!("{value} ms"),
    };
    let up = Quantity {
        title: "runs in 20 ms",
        range: Range::Linear(0.0, 40.0, 10.0),
        text: |value| format!("{value}"),
    };
    let title =
        "Fail-over times of cuts at random instants: parallel access, heartbeat 100 ms, consumer time 250 ms";
    curves(title, Layout::WIDE, [across, up], &drawn).standalone()
}

/// Returns a histogram as a line.
fn stairs(values: &[f64]) -> Vec<(f64, f64)> {
    let bins = (END / BIN) as usize;
    let mut points = vec![(0.0, 0.0)];
    for bin in 0..bins {
        let (from, to) = (bin as f64 * BIN, (bin + 1) as f64 * BIN);
        let count = values.iter().filter(|value| (from..to).contains(*value)).count() as f64;
        points.extend([(from, count), (to, count)]);
    }
    points
}
