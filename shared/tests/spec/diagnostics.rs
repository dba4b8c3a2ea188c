//! The counters that a debugger reads.

use ecss_can::runner::{Diagnostics, Tally};
use ecss_can::types::Bus;

#[test]
fn a_tally_counts_and_wraps() {
    let tally = Tally::new();
    tally.count();
    tally.add(3);
    assert_eq!(tally.get(), 4);
    tally.add(u32::MAX);
    assert_eq!(tally.get(), 3);
}

#[test]
fn each_counter_stands_for_itself() {
    let diagnostics = Diagnostics::default();
    diagnostics.handled(Bus::Nominal).add(1);
    diagnostics.handled(Bus::Redundant).add(2);
    diagnostics.overruns().add(3);
    diagnostics.app_overflows().add(4);
    let counted = [
        diagnostics.handled(Bus::Nominal),
        diagnostics.handled(Bus::Redundant),
        diagnostics.overruns(),
        diagnostics.app_overflows(),
        &diagnostics.interrupts.receive,
    ];
    assert_eq!(counted.map(Tally::get), [1, 2, 3, 4, 0]);
}
