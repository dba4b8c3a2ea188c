//! The counters that a debugger reads.

use ecss_can::runner::{Tally, Telltale};
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
    let telltale = Telltale::default();
    telltale.handled(Bus::Nominal).add(1);
    telltale.handled(Bus::Redundant).add(2);
    telltale.overruns().add(3);
    telltale.app_overflows().add(4);
    let counted = [
        telltale.handled(Bus::Nominal),
        telltale.handled(Bus::Redundant),
        telltale.overruns(),
        telltale.app_overflows(),
        &telltale.interrupts.receive,
    ];
    assert_eq!(counted.map(Tally::get), [1, 2, 3, 4, 0]);
}
