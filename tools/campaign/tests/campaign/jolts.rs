//! A sample of the table in which one jolt breaks the bus of a slave and resets it. `tests/second` flies all of it.

use campaign::jolt::table;
use campaign::{World, fly};

/// Prime, so that the sample meets every cause, distance and variant.
const EVERY: usize = 37;

#[test]
fn sample_of_jolts_violates_nothing() {
    for script in table().iter().step_by(EVERY) {
        let flown = fly(World::Host, script);
        assert!(flown.violations.is_empty(), "{:?}\n{script}", flown.violations);
    }
}
