//! What a slave reports while its bus fails is known to the master afterwards, see [`host::events`].

use host::events::{flights, fly};

/// One flight in twenty; the second tier flies all.
#[test]
fn reports_during_a_failure_of_the_bus_are_known_afterwards() {
    let wrong: Vec<String> = flights(20).filter_map(|flight| fly(flight).err()).collect();
    assert!(wrong.is_empty(), "{} flights:\n{}", wrong.len(), wrong.join("\n"));
}
