//! Equal worlds have equal histories.

use std::fmt::Write;

use ecss_can::types::Bus;
use mission::LIBRECUBE;

use crate::support::*;

/// Returns all observable events of a world with traffic and a fail-over.
fn history(seed: u64) -> String {
    let mut world = MissionWorld::busy(LIBRECUBE, 3, |world| world.seed(seed));
    world.run_until(ms(3_000));
    cut_next_to_master(&mut world, Bus::Nominal);
    world.run_until(ms(6_000));
    let mut history = String::new();
    for entry in world.log().iter() {
        writeln!(history, "{entry:?}").expect("a string takes everything");
    }
    for node in world.slaves() {
        writeln!(history, "{node:?} {:?}", world.reactions(node)).expect("a string takes everything");
    }
    for bus in Bus::ALL {
        for sent in world.frames(bus) {
            writeln!(history, "{bus:?} {sent:?}").expect("a string takes everything");
        }
    }
    history
}

#[test]
fn one_seed_is_one_history_and_another_seed_another() {
    let first = history(1);
    assert!(first.lines().count() > 500);
    assert!(first == history(1), "the same seed");
    assert!(first != history(2), "another seed");
}
