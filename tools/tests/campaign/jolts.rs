//! A sample of the table in which one jolt breaks the bus of a slave and resets it. `tests/second` runs all of it.

use ecss_can_cli::campaign::jolt::table;
use ecss_can_cli::campaign::{World, fly};

/// Every 37th script is run; a prime number, so that the sample contains every cause, distance and variant.
const EVERY: usize = 37;

#[test]
fn sample_of_jolts_violates_nothing() {
    for script in table().iter().step_by(EVERY) {
        let flown = fly(World::Host, script);
        assert!(flown.violations.is_empty(), "{:?}\n{script}", flown.violations);
    }
}
